// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/balls/ball_sheets.h>

#include <scrim/base/parallel.h>
#include <scrim/geometry/camera.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <tuple>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

constexpr double kSmall = 0.5;  // pixels; the radius of the largest ball that is one point
constexpr double kStep = 0.5;   // pixels; of the points of a way
// Pixels; the width of rings, and the distance of points along them. Where they are by chance
// closer, a pixel of an opaque ball would hide more than everything, and send more than the ball
// does, by up to 2.5 %. That is lost: up to 0.2 % of the ball.
constexpr double kRing = 0.25;
constexpr int kMostSteps = 1 << 12;       // of a ball along its way
constexpr double kMostRings = 1 << 12;    // a ball larger than this, in half pixels, is drawn coarser
constexpr Real kThin = Real(1.0 / 8192);  // the optical depth of the sheet that stands for a ball while it is lit

// Where a camera sees a place, in pixels, with the depth along its axis and the width of a pixel there.
struct Seen {
    Vec2 at{0};
    double depth = 0, pixel = 1;
    double across = 1;  // the cosine of the ray to the axis: a ball is seen as an ellipse of 1 / across its area
};

class Projection {
  public:
    explicit Projection(const Camera& camera)
        : m_rays(wsRays(camera)),
          m_axis(viewingAxis(camera)),
          m_eye(camera.wsPosition),
          m_orthographic(camera.type == CameraType::orthographic),
          m_fromRay(glm::inverse(Mat3(m_rays.directionX, m_rays.directionY, m_rays.direction0))) {
        const Vec3 &x = m_orthographic ? m_rays.originX : m_rays.directionX,
                   &y = m_orthographic ? m_rays.originY : m_rays.directionY;
        m_width = glm::length(x);
        m_aspect = m_width / glm::length(y);
    }

    // Width of a pixel over its height.
    double aspect() const { return m_aspect; }

    // No value for places that the camera does not see because they are behind it, or too near.
    std::optional<Seen> see(const Vec3& ws) const {
        Seen out;
        out.depth = glm::dot(ws - m_eye, m_axis);
        if (!(out.depth > m_rays.near) || (!m_orthographic && !(out.depth > 0))) return {};
        if (m_orthographic) {
            const Vec3 p = ws - m_rays.origin0;
            const auto along = [&](const Vec3& axis) { return glm::dot(p, axis) / glm::dot(axis, axis); };
            out.at = {along(m_rays.originX), along(m_rays.originY)};
            out.pixel = m_width;
            return out;
        }
        const Vec3 ray = (ws - m_eye) / out.depth, p = m_fromRay * ray;
        out.at = {p.x / p.z, p.y / p.z};
        out.pixel = m_width * out.depth;
        out.across = 1 / glm::length(ray);
        return out;
    }

  private:
    RayFamily m_rays;
    Vec3 m_axis, m_eye;
    bool m_orthographic;
    Mat3 m_fromRay;
    double m_width = 1, m_aspect = 1;
};

// The numbers of a list; 0 where a block is left out.
class List {
  public:
    List() = default;
    explicit List(const SparseField& field) : m_field(&field) {
        if (field.empty()) return;
        m_blocks.resize(std::size_t(field.blockOrigins.back().x / kBlockEdge) + 1, nullptr);
        for (std::size_t b = 0; b < field.blockCount(); ++b)
            m_blocks[std::size_t(field.blockOrigins[b].x / kBlockEdge)] = field.block(b);
    }
    float operator[](std::size_t i) const {
        const std::size_t b = i / kBlockVoxels;
        return b < m_blocks.size() && m_blocks[b] != nullptr ? m_blocks[b][i % kBlockVoxels] : 0;
    }
    const SparseField& field() const { return *m_field; }

  private:
    const SparseField* m_field = nullptr;
    std::vector<const float*> m_blocks;
};

}  // namespace

bool seesBalls(const ViewScene& scene, const Plan& plan) {
    return std::ranges::any_of(scene.volumes, [&](const ViewVolume& volume) { return seesBalls(plan, volume); });
}

// A ball, or the way that it goes while the moment lasts.
struct BallSheets::Ball {
    float x, y;        // raster position, of the middle of its way
    float wayX, wayY;  // from begin to end, pixels
    float radius;      // pixels, along x
    float n;           // in sheets
    float hides;       // h of its profile; of a disc its opacity
    std::uint32_t kind, index;
};

// What the balls of a pixel, from the front of a sheet to one of them, do in each colour.
struct BallSheets::Mixed {
    std::array<Real, 3> hidden{};  // their opacity
    std::array<Real, 3> lost{};    // the share of what the rest of the sheet sends that they hide
};

// A volume of balls.
struct BallSheets::Kind {
    const ViewVolume* volume;
    std::array<List, 3> place;
    List radius, density;
    std::vector<List> scatter, emission, velocity;
    double scale = 1;          // of the asset's world; the mean of its axes
    std::array<Real, 3> tint;  // of its extinction, in the colours of samples
    std::unique_ptr<SheetShader> shader;

    const ViewBalls& balls() const { return *volume->balls; }

    Vec3 velocityOf(std::size_t i) const {
        if (velocity.empty()) return Vec3(0);
        const auto along = [&](std::size_t axis) {
            return double(velocity[2 * axis][i]) - double(velocity[2 * axis + 1][i]);
        };
        return {along(0), along(1), along(2)};
    }
    double radiusOf(std::size_t i) const { return scale * double(radius[i]); }
    // The way that profiles are relative to: a diameter, or what stands for it in a disc.
    double chordOf(std::size_t i) const { return balls().discs ? 1 : 2 * radiusOf(i); }
    // Its extinction within, per world unit; the opacity of a disc.
    double extinctionOf(std::size_t i) const {
        const double own = double(density[i]) * volume->medium.mostExtinction();
        return balls().discs ? std::min(own, 1.0) : own;
    }
};

BallSheets::~BallSheets() = default;

BallSheets::BallSheets(const ViewScene& scene, const Plan& plan, const LevelSheets& level, const EyeView& eye,
                       const PixelWindow& region, const std::vector<CellLight>& cellLight, const OtherLevels& others)
    : m_group(level.group),
      m_eye(eye),
      m_region(region),
      m_window(tilesAround(region)),
      m_tilesX(m_window.width() / kTileEdge),
      m_tilesY(m_window.height() / kTileEdge),
      m_layout(level.group.outputs.layout),
      m_frontToBack(level.group.sameSide) {
    const int n = scene.dials.antialias;
    m_aspect = Projection(supersampled(scene.camera, n)).aspect();
    std::vector<Ball> all;
    for (std::size_t v = 0; v < scene.volumes.size(); ++v) {
        const ViewVolume& volume = scene.volumes[v];
        if (!seesBalls(plan, volume)) continue;
        auto kind = std::make_unique<Kind>();
        kind->volume = &volume;
        for (std::size_t axis = 0; axis < 3; ++axis) kind->place[axis] = List(*volume.balls->place[axis]);
        kind->radius = List(*volume.balls->radius);
        kind->density = List(*volume.balls->density);
        for (const auto& field : volume.balls->scatter) kind->scatter.emplace_back(*field);
        for (const ViewEmission& emission : volume.balls->emission) kind->emission.emplace_back(*emission.field.field);
        for (const auto& field : volume.balls->velocity) kind->velocity.emplace_back(*field);
        kind->scale = std::cbrt(std::abs(glm::determinant(Mat3(volume.balls->wsFromAsset[0]))));
        const Rgb tint = volume.medium.relativeTint();
        for (int c = 0; c < 3; ++c)
            kind->tint[std::size_t(c)] = plan.extinction.coloured ? static_cast<Real>(tint[c]) : Real(1);
        kind->shader = std::make_unique<SheetShader>(scene, plan, level, eye, cellLight, others, v);
        m_kinds.push_back(std::move(kind));
        place(scene, level.group.sheets, n, m_kinds.size() - 1, all);
    }
    sort(std::move(all));
}

// Finds where the eye sees the balls of a volume. Those that it does not see are left out.
void BallSheets::place(const ViewScene& scene, const Sheets& sheets, int n, std::size_t number,
                       std::vector<Ball>& all) const {
    const Kind& kind = *m_kinds[number];
    const ViewBalls& balls = kind.balls();
    const auto cameraAt = [&](std::size_t end) {
        Camera camera = scene.span ? (*scene.span)[end] : scene.camera;
        camera.resolution = scene.camera.resolution;  // pilots are smaller
        return supersampled(camera, n);
    };
    const Projection begins(cameraAt(0)), ends(cameraAt(1)), middle(supersampled(scene.camera, n));
    const Mat4& assetFromList = kind.place[0].field().wsFromIs;
    const std::size_t count = balls.count(), before = all.size();
    all.resize(before + count);
    const PixelWindow& region = m_region;
    parallelChunks(count, [&](std::size_t first, std::size_t last) {
        for (std::size_t i = first; i < last; ++i) {
            Ball& ball = all[before + i];
            ball.radius = 0;
            const double radius = kind.radiusOf(i);
            if (!(radius > 0)) continue;
            const Vec3 at = transformPoint(assetFromList, Vec3(kind.place[0][i], kind.place[1][i], kind.place[2][i]));
            if (!balls.clip.empty() && depthIn(balls.clip, at) < 0) continue;
            const Vec3 velocity = kind.velocityOf(i);
            const Vec3 from = transformPoint(balls.wsFromAsset[0], at + balls.time[0] * velocity),
                       to = transformPoint(balls.wsFromAsset[1], at + balls.time[1] * velocity), ws = 0.5 * (from + to);
            const auto seen = middle.see(ws);
            if (!seen) continue;
            const auto seenFrom = begins.see(from), seenTo = ends.see(to);
            const bool moves = seenFrom && seenTo;
            const Vec2 raster = moves ? 0.5 * (seenFrom->at + seenTo->at) : seen->at;
            const Vec2 way = moves ? seenTo->at - seenFrom->at : Vec2(0);
            const double pixels = radius / (seen->pixel * std::sqrt(seen->across));
            const Vec2 reach = 0.5 * glm::abs(way) + Vec2(pixels, pixels * m_aspect) + 1.0;
            if (raster.x + reach.x <= region.x0 || raster.x - reach.x >= region.x1 || raster.y + reach.y <= region.y0 ||
                raster.y - reach.y >= region.y1)
                continue;
            ball = {static_cast<float>(raster.x),
                    static_cast<float>(raster.y),
                    static_cast<float>(way.x),
                    static_cast<float>(way.y),
                    static_cast<float>(pixels),
                    static_cast<float>(sheets.tsPoint(ws).z),
                    static_cast<float>(kind.extinctionOf(i) * kind.chordOf(i)),
                    static_cast<std::uint32_t>(number),
                    static_cast<std::uint32_t>(i)};
        }
    });
    std::erase_if(all, [](const Ball& ball) { return !(ball.radius > 0); });
}

// Sorts the balls by sheet, and leaves out those that are not in the sheets which are swept.
void BallSheets::sort(std::vector<Ball> all) {
    const NeededTiles& needed = m_group.needed;
    const int sheets = std::max(needed.last - needed.first, 0);
    const auto sheetOf = [&](const Ball& ball) { return static_cast<int>(std::floor(ball.n)) - needed.first; };
    std::erase_if(all, [&](const Ball& ball) { return sheetOf(ball) < 0 || sheetOf(ball) >= sheets; });
    std::vector<std::size_t> next(std::size_t(sheets) + 1, 0);
    for (const Ball& ball : all) ++next[std::size_t(sheetOf(ball)) + 1];
    for (std::size_t s = 1; s < next.size(); ++s) next[s] += next[s - 1];
    m_firstOf = next;
    m_balls.resize(all.size());
    for (const Ball& ball : all) m_balls[next[std::size_t(sheetOf(ball))]++] = ball;
}

bool BallSheets::anyIn(int sheet, int end) const {
    const auto at = [&](int s) {
        return m_firstOf[std::size_t(std::clamp(s, m_group.needed.first, m_group.needed.last) - m_group.needed.first)];
    };
    return at(sheet) < at(end);
}

ShadeWork BallSheets::enter(int firstSheet, int count) {
    m_firstSheet = firstSheet;
    m_touched.clear();
    m_entries.clear();
    if (!anyIn(firstSheet, firstSheet + count)) return {};
    const std::size_t before = std::size_t(firstSheet - m_group.needed.first);
    m_firstBall = m_firstOf[before];
    const std::size_t floats = std::size_t(m_layout.floats());
    m_samples.resize((m_firstOf[before + std::size_t(count)] - m_firstBall) * floats);
    struct Task {
        std::size_t first, last;
        int plane;
        ShadeWork work;
    };
    std::vector<Task> tasks;  // each of one sheet and one volume
    for (int p = 0; p < count; ++p)
        for (std::size_t first = m_firstOf[before + std::size_t(p)], end = m_firstOf[before + std::size_t(p) + 1];
             first < end;) {
            std::size_t last = first + 1;
            while (last < end && last - first < kTileSize && m_balls[last].kind == m_balls[first].kind) ++last;
            tasks.push_back({first, last, p, {}});
            first = last;
        }
    parallelFor(tasks.size(),
                [&](std::size_t t) { tasks[t].work = shade(tasks[t].first, tasks[t].last, tasks[t].plane); });
    listTiles(count);
    ShadeWork sum;
    for (const Task& task : tasks) sum += task.work;
    return sum;
}

// Lights up to 256 balls of one volume in one sheet. Each is shaded as a sheet so thin that nothing
// in it hides anything else, of which the ball is a multiple.
ShadeWork BallSheets::shade(std::size_t first, std::size_t last, int plane) {
    const Kind& kind = *m_kinds[m_balls[first].kind];
    const Sheets& sheets = m_group.sheets;
    const double middle = m_firstSheet + plane + 0.5;
    SampleTile samples;
    SheetShader::GivenRows rows;
    const bool flows = m_layout.motion && !kind.velocity.empty();
    rows.resize(kind.scatter.size(), kind.emission.size(), flows ? 3 : 0);
    std::array<Real, kTileSize> scale;
    for (std::size_t k = 0; k < kTileSize; ++k) {
        const Ball& ball = m_balls[std::min(first + k, last - 1)];
        const EyeView::Ray ray = m_eye.ray(double(ball.x), double(ball.y), double(ball.n));
        const auto toSlope = sheets.texel / sheets.thickness;
        samples.u[k] = static_cast<Real>(ray.u);
        samples.v[k] = static_cast<Real>(ray.v);
        samples.eyeA[k] = static_cast<Real>(ray.slopeU * toSlope);
        samples.eyeB[k] = static_cast<Real>(ray.slopeV * toSlope);
        rows.behind[k] = static_cast<Real>(double(ball.n) - (middle - 0.5));
        const double slant = std::sqrt(1 + double(samples.eyeA[k]) * double(samples.eyeA[k]) +
                                       double(samples.eyeB[k]) * double(samples.eyeB[k]));
        const double path = slant * sheets.thickness;
        const double chord = kind.chordOf(ball.index), hides = double(ball.hides);
        const double thin = double(kThin) / std::max(hides, 1.0);
        scale[k] = static_cast<Real>(1 / thin);
        rows.extinction[k] = static_cast<Real>(thin * hides / path);
        const double density = double(kind.density[ball.index]);
        for (std::size_t c = 0; c < kind.scatter.size(); ++c)
            rows.scatter[c].values[k] =
                density > 0 ? rows.extinction[k] * static_cast<Real>(double(kind.scatter[c][ball.index]) / density) : 0;
        for (std::size_t e = 0; e < kind.emission.size(); ++e)
            rows.emission[e].values[k] = static_cast<Real>(thin * chord * double(kind.emission[e][ball.index]) / path);
        const Vec3 velocity = flows ? kind.velocityOf(ball.index) : Vec3(0);
        for (int axis = 0; flows && axis < 3; ++axis)
            rows.velocity[std::size_t(axis)].values[k] = static_cast<Real>(velocity[axis]);
    }
    m_eye.setDepth(middle, samples);
    samples.spacing = m_eye.pixelSpacing(middle);
    ShadeWork work;
    const std::size_t floats = std::size_t(m_layout.floats());
    std::vector<Real> out(floats * kTileSize);
    kind.shader->shadeGiven(plane, samples, rows, out.data(), work);
    for (std::size_t k = 0; k < last - first; ++k)
        for (std::size_t i = 0; i < floats; ++i)
            m_samples[(first - m_firstBall + k) * floats + i] = scale[k] * out[k * floats + i];
    return work;
}

// The tiles that a box of raster positions touches.
Box2<int> BallSheets::tilesIn(const Box2<double>& positions) const {
    const auto tileOf = [](double x, int corner, int count) {
        return static_cast<int>(std::clamp(std::floor((x - corner) / kTileEdge), -1.0, double(count)));
    };
    return {std::max(tileOf(positions.x0, m_window.x0, m_tilesX), 0),
            std::max(tileOf(positions.y0, m_window.y0, m_tilesY), 0),
            std::min(tileOf(positions.x1, m_window.x0, m_tilesX) + 1, m_tilesX),
            std::min(tileOf(positions.y1, m_window.y0, m_tilesY) + 1, m_tilesY)};
}

// Finds the tiles of the picture that the batch's balls touch.
void BallSheets::listTiles(int count) {
    const auto tiles = tileCount();
    m_touched.assign(std::size_t(count) * tiles, 0);
    const std::size_t before = std::size_t(m_firstSheet - m_group.needed.first);
    for (int p = 0; p < count; ++p)
        for (std::size_t i = m_firstOf[before + std::size_t(p)]; i < m_firstOf[before + std::size_t(p) + 1]; ++i) {
            const Ball& ball = m_balls[i];
            const double x = double(ball.x), y = double(ball.y), r = double(ball.radius);
            const double reachX = 0.5 * std::abs(double(ball.wayX)) + r + 0.5,
                         reachY = 0.5 * std::abs(double(ball.wayY)) + r * m_aspect + 0.5;
            // A pixel's centre is at its half; balls are seen by those less than a pixel from any of their points.
            const Box2<int> box = tilesIn({x - reachX - 0.5, y - reachY - 0.5, x + reachX + 0.5, y + reachY + 0.5});
            for (int ty = box.y0; ty < box.y1; ++ty)
                for (int tx = box.x0; tx < box.x1; ++tx) {
                    const std::size_t at = std::size_t(p) * tiles + std::size_t(ty * m_tilesX + tx);
                    m_touched[at] = 1;
                    m_entries.emplace_back(at, static_cast<std::uint32_t>(i - m_firstBall));
                }
        }
    // Those of a sheet from its front on, as the eye sees them.
    const auto depthOf = [&](const auto& entry) {
        const float n = m_balls[m_firstBall + entry.second].n;
        return m_frontToBack ? n : -n;
    };
    std::sort(m_entries.begin(), m_entries.end(), [&](const auto& a, const auto& b) {
        return std::tuple(a.first, depthOf(a), a.second) < std::tuple(b.first, depthOf(b), b.second);
    });
}

// Calls add(pixel of the tile, shares) for the pixels that see a ball, perhaps several times: the
// integral of its profile over the part that the pixel sees, in pixels, for each colour.
template <class Add>
void BallSheets::draw(const Ball& ball, int tile, const Add& add) const {
    const Kind& kind = *m_kinds[ball.kind];
    const bool discs = kind.balls().discs;
    const int colours = m_layout.coloured ? 3 : 1;
    const double r = double(ball.radius), area = std::numbers::pi * r * r * m_aspect;
    const double x0 = m_window.x0 + tile % m_tilesX * kTileEdge + 0.5,
                 y0 = m_window.y0 + tile / m_tilesX * kTileEdge + 0.5;
    std::array<Real, 3> shares{};
    // A point's share of the four pixels around it.
    const auto addPoint = [&](double x, double y) {
        const double left = std::floor(x), top = std::floor(y);
        if (left < -1 || top < -1 || left >= kTileEdge || top >= kTileEdge) return;
        const auto u = static_cast<Real>(x - left), v = static_cast<Real>(y - top);
        const int i = static_cast<int>(left), j = static_cast<int>(top);
        for (int corner = 0; corner < 4; ++corner) {
            const int px = i + (corner & 1), py = j + (corner >> 1);
            if (px < 0 || py < 0 || px >= kTileEdge || py >= kTileEdge) continue;
            const Real part = ((corner & 1) != 0 ? u : 1 - u) * ((corner >> 1) != 0 ? v : 1 - v);
            add(py * kTileEdge + px, part, shares);
        }
    };
    const double length = std::hypot(double(ball.wayX), double(ball.wayY));
    const int steps = std::clamp(static_cast<int>(std::ceil(length / std::max(kStep, 0.5 * r))), 1, kMostSteps);
    const int rings = r <= kSmall ? 1 : static_cast<int>(std::ceil(std::min(r / kRing, kMostRings)));
    for (int ring = 0; ring < rings; ++ring) {
        const double from = double(ring) / rings, to = double(ring + 1) / rings, q = rings == 1 ? 0 : 0.5 * (from + to);
        const int points =
            rings == 1 ? 1 : std::max(3, static_cast<int>(std::ceil(2 * std::numbers::pi * q * r / kRing)));
        for (int c = 0; c < colours; ++c) {
            const double h = double(ball.hides) * double(kind.tint[std::size_t(c)]);
            const double share = discs ? discShare(from, to) : ballShare(h, from, to);
            shares[std::size_t(c)] = static_cast<Real>(area * share / points / steps);
        }
        const double turn = 2 * std::numbers::pi / points;
        for (int point = 0; point < points; ++point) {
            // Rings begin at different angles.
            const double angle = turn * (point + 0.618 * ring);
            const double dx = q * r * std::cos(angle), dy = q * r * m_aspect * std::sin(angle);
            for (int step = 0; step < steps; ++step) {
                const double t = (step + 0.5) / steps - 0.5;
                addPoint(double(ball.x) + t * double(ball.wayX) + dx - x0,
                         double(ball.y) + t * double(ball.wayY) + dy - y0);
            }
        }
    }
}

// Adds a ball, of which `shares` are seen, to those in front of it. The rest of the sheet is even
// between its two faces: `infront` of it is in front of the ball, and hides it; the ball hides what
// is behind. `rest` is the rest's sample.
void BallSheets::addBall(const Ball& ball, const Real* own, const Real* shares, const Real* rest, Mixed& mixed,
                         Real* sums) const {
    const int last = m_layout.floats() - 4;
    const auto beyond = static_cast<Real>(double(ball.n) - std::floor(double(ball.n)));
    const Real infront = m_frontToBack ? beyond : 1 - beyond;
    for (int c = 0; c < 3; ++c) {
        const int at = last + (m_layout.coloured ? c : 3);
        const Real there = std::clamp(-rest[at], Real(0), Real(1));
        // What the rest in front hides, 1 - (1 - there)^infront, and how much of the rest's light
        // is from behind: of `there` the part (1 - there)^infront - (1 - there).
        Real hiding = 0, behind = 1 - infront;
        if (there > 0 && infront > 0) {
            hiding = -std::expm1(infront * std::log1p(-there));
            behind = 1 - hiding / there;
        }
        Real share = shares[m_layout.coloured ? c : 0];
        Real hides = -own[at] * share;
        if (hides > 1) share /= hides;  // see kRing
        hides = std::clamp(hides, Real(0), Real(1));
        Real& hidden = mixed.hidden[std::size_t(c)];
        const Real passes = 1 - hidden;
        for (int q = 0; q < m_layout.outputQuads(); ++q)
            sums[4 * q + c] += own[4 * q + c] * share * ((1 - hiding) * passes);
        mixed.lost[std::size_t(c)] += hides * passes * behind;
        hidden += hides * passes;
    }
}

// Adds the balls of a pixel to its sample of the rest.
void BallSheets::mix(const Mixed& mixed, const Real* sums, Real* sample) const {
    const int last = m_layout.floats() - 4;
    std::array<Real, 3> hidden;
    for (std::size_t c = 0; c < 3; ++c) {
        const Real there = std::clamp(-sample[std::size_t(last) + (m_layout.coloured ? c : 3)], Real(0), Real(1));
        for (std::size_t q = 0; q < std::size_t(m_layout.outputQuads()); ++q)
            sample[4 * q + c] = sample[4 * q + c] * (1 - mixed.lost[c]) + sums[4 * q + c];
        hidden[c] = there + (1 - there) * mixed.hidden[c];
    }
    if (!m_layout.coloured) {
        for (int q = 0; q <= last; q += 4) sample[q + 3] = -hidden[0];
        return;
    }
    for (int c = 0; c < 3; ++c) sample[last + c] = -hidden[std::size_t(c)];
    sample[last + 3] = -std::min({hidden[0], hidden[1], hidden[2]});
}

void BallSheets::addTo(int sheet, int tile, const Limits& limits, Real* samples) const {
    const std::uint64_t at = std::uint64_t(sheet - m_firstSheet) * std::uint64_t(tileCount()) + std::uint64_t(tile);
    const auto less = [](const auto& entry, std::uint64_t key) { return entry.first < key; };
    const auto floats = std::size_t(m_layout.floats());
    std::array<std::array<Real, 3>, kTileSize> shares;
    std::array<std::uint8_t, kTileSize> seen{}, known{};
    std::array<int, kTileSize> pixels, all;
    std::array<Mixed, kTileSize> mixed;
    std::size_t allCount = 0;
    thread_local std::vector<Real> sums;  // of each pixel
    if (sums.size() < kTileSize * floats) sums.resize(kTileSize * floats);
    for (auto entry = std::lower_bound(m_entries.begin(), m_entries.end(), at, less);
         entry != m_entries.end() && entry->first == at; ++entry) {
        const Ball& ball = m_balls[m_firstBall + entry->second];
        const Real* const own = m_samples.data() + std::size_t(entry->second) * floats;
        std::size_t count = 0;
        draw(ball, tile, [&](int k, Real part, const std::array<Real, 3>& profile) {
            std::array<Real, 3>& share = shares[std::size_t(k)];
            if (seen[std::size_t(k)] == 0) {
                seen[std::size_t(k)] = 1;
                pixels[count++] = k;
                share = {};
            }
            for (std::size_t c = 0; c < 3; ++c) share[c] += part * profile[c];
        });
        const Real n = static_cast<Real>(double(ball.n) - limits.block - 0.5);
        for (std::size_t i = 0; i < count; ++i) {
            const auto k = std::size_t(pixels[i]);
            seen[k] = 0;
            const Real near = m_frontToBack ? limits.starts[k] : -limits.starts[k], depth = m_frontToBack ? n : -n;
            if (depth < near) continue;
            if (limits.ends && depth > (m_frontToBack ? limits.ends[k] : -limits.ends[k])) continue;
            if (limits.seen)
                for (Real& share : shares[k]) share *= limits.seen(pixels[i], n);
            Real* const sum = sums.data() + k * floats;
            if (known[k] == 0) {
                known[k] = 1;
                all[allCount++] = pixels[i];
                mixed[k] = {};
                std::fill_n(sum, floats, Real(0));
            }
            addBall(ball, own, shares[k].data(), samples + k * floats, mixed[k], sum);
        }
    }
    for (std::size_t i = 0; i < allCount; ++i) {
        const auto k = std::size_t(all[i]);
        mix(mixed[k], sums.data() + k * floats, samples + k * floats);
    }
}

std::uint64_t BallSheets::count() const {
    return m_balls.size();
}

std::size_t BallSheets::bytes() const {
    return m_balls.capacity() * sizeof(Ball) + m_samples.capacity() * sizeof(Real) + m_touched.capacity() +
           m_entries.capacity() * sizeof(m_entries.front());
}

// While they are sorted, all balls exist twice. Samples are those of a batch, in which all balls may be.
std::size_t BallSheets::bytes(const ViewScene& scene, const Plan& plan, const OutputLayout& layout) {
    std::size_t balls = 0;
    for (const ViewVolume& volume : scene.volumes)
        if (seesBalls(plan, volume)) balls += volume.balls->count();
    return balls * (2 * sizeof(Ball) + std::size_t(layout.floats()) * sizeof(Real) + 2 * 16);
}

}  // namespace scrim
