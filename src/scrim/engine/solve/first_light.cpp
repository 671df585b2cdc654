// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/solve/first_light.h>

#include <scrim/base/parallel.h>
#include <scrim/scene/picture_cells.h>
#include <scrim/engine/cells/cell_walk.h>
#include <scrim/engine/model/served_lights.h>
#include <scrim/engine/model/sub_lights.h>
#include <scrim/scene/light_at.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <utility>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

namespace scrim {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
// At this distance from the centre of a cube, in edges, 1/r^2 equals its mean over the cube; that
// mean is 3 / R^2 for a ball of the same volume.
constexpr double kNearest = 0.36;
// Cells nearer to a lamp than this, in edges, get the mean of its light over all of the cell, by rays from the lamp. A
// lamp lies anywhere in its cell: with 1/r^2 at centres, smoke of 48 voxels around a lamp was 5 to 32 % off in means
// over 4 x 4 pixels as everything moved by parts of a cell of 1.12 voxels, and its mean by 5 %; with rays 1.7 to 3.2,
// and 0.3 % (2.5 edges: the same), which is what cells cannot resolve of the light of further collisions.
constexpr double kNear = 1.5;

// The middle of the i-th of kParts parts of a cell.
constexpr int kParts = 64;
Vec3 wsPart(const CellGrid& grid, std::size_t cell, int i) {
    constexpr int kAlong = 4;
    return grid.wsFromCs(Vec3(grid.place(cell)) +
                         (Vec3(i % kAlong, i / kAlong % kAlong, i / (kAlong * kAlong)) + 0.5) / double(kAlong));
}

// The mean transmittance over a path of optical depth `own`, whose middle lies at `middle`. A bundle of rays that
// grazes a dense cell may lie at less than a half of the cell's own depth: nothing is brighter than where light enters.
double meanOverCell(double middle, double own) {
    return std::exp(-std::max(middle - 0.5 * own, 0.0)) * (own < 1e-6 ? 1 : -std::expm1(-own) / own);
}

// The light of a light that arrives in a cell; light that scattered straight on is part of the irradiance.
struct ArrivingInCell : Arriving {
    // As the last sweep splits phase functions: the irradiance, and the optical depth of scattering straight on.
    Rgb last{0}, straightDepth{0};
};

// What arrives in a cell near a lamp by one bundle of its rays.
struct NearLamp {
    std::size_t cell;
    Vec3 travel{0};
    double irradiance = 0, last = 0, straightDepth = 0;  // as ArrivingInCell has them
};

// Rays to one light that is not extended, through extinction that is constant in each cell.
class FirstCollisions {
  public:
    // `media`, those of the solve, `last`, those of its last sweep, `around`, what lies around both (null: nothing),
    // `light` and the scene's solids must outlive this object. A light's slide must be loaded.
    FirstCollisions(const ViewScene& scene, const CellMedia& media, const CellMedia& last, const Around* around,
                    const Light& light);

    // The light in cell `cell`: the mean along the ray through its centre.
    ArrivingInCell at(std::size_t cell) const;
    // True if the light is a lamp so near to the cell that its light there is known from rays around it.
    bool isNear(std::size_t cell) const;
    // The light of colour `colour` in these cells.
    std::vector<NearLamp> aroundLamp(std::size_t colour) const;
    // The irradiance on a small surface, one-sided and with the length of its normal as a factor.
    Rgb onto(const Vec3& ws, const Vec3& wsNormal) const;

  private:
    bool reaches(const Vec3& ws) const;
    Rgb meanIn(std::size_t cell) const;
    void findShadows();
    void follow(const Vec3& direction, double solidAngle, std::size_t colour, std::vector<NearLamp>& bundle) const;

    const ViewScene& m_scene;
    const CellMedia &m_media, &m_last;
    const Light& m_light;
    LightAt m_unattenuated;
    std::array<std::optional<DepthsBeyond>, 2> m_beyond;  // of the solve's media, and of those of its last sweep
    std::vector<Real> m_lit;  // the part of each cell that is not in a solid's shadow; empty: no solid casts one
};

// The distance to the light is at least the mean distance of a cell's points from its centre.
FirstCollisions::FirstCollisions(const ViewScene& scene, const CellMedia& media, const CellMedia& last,
                                 const Around* around, const Light& light)
    : m_scene(scene),
      m_media(media),
      m_last(last),
      m_light(light),
      m_unattenuated(light, kNearest * media.grid.edge()) {
    if (light.shadows && media.grid.hasWalls()) findShadows();
    const auto toLight = [&](const Vec3& ws) {
        const Arriving arriving = m_unattenuated.at(ws);
        return std::pair(-arriving.travel, arriving.distance);
    };
    for (const bool ofLast : {false, true})
        if (around && light.shadows && (!ofLast || &last != &media))
            m_beyond[ofLast ? 1 : 0].emplace(*around, media.grid, ofLast, toLight);
}

// True if no solid stands between a point and the light.
bool FirstCollisions::reaches(const Vec3& ws) const {
    const Arriving light = m_unattenuated.at(ws);
    return m_scene.solids->firstHit(SolidRole::shadow, ws, -light.travel, 0, light.distance) == kInfinity;
}

// Without attenuation, the mean over a cell, in which beams and pictures may be smaller.
Rgb FirstCollisions::meanIn(std::size_t cell) const {
    Rgb sum(0);
    for (int i = 0; i < kParts; ++i) sum += m_unattenuated.at(wsPart(m_media.grid, cell, i)).irradiance;
    return sum / double(kParts);
}

// Where the edge of a shadow passes a cell, or between the centres of neighbours, a cell counts by its part that is
// lit, on its own side of walls. Beams may be narrower than cells: a few places in each are looked at. Not so for
// elements, many of which stand for one surface: edges of their shadows lie anywhere in cells, and even out.
void FirstCollisions::findShadows() {
    const CellGrid& grid = m_media.grid;
    constexpr int kLooks = 8;
    std::vector<Real> parts(grid.cells(), Real(0));  // of the looks, that are lit
    m_lit.assign(grid.cells(), Real(0));
    const auto forCells = [&](const auto& visit) {
        parallelFor(grid.storedBlocks().size(), [&](std::size_t block) {
            for (std::size_t cell = block * kBlockCells; cell < (block + 1) * kBlockCells; ++cell) visit(block, cell);
        });
    };
    forCells([&](std::size_t, std::size_t cell) {
        const Int3 place = grid.place(cell);
        if (reaches(grid.wsInside(place))) m_lit[cell] = 1;
        if (m_light.element()) return;
        for (int i = 0; i < kLooks; ++i) {
            const Vec3 ws = grid.wsFromCs(Vec3(place) + 0.25 + 0.5 * Vec3(i & 1, i >> 1 & 1, i >> 2));
            parts[cell] += reaches(ws) ? Real(1) / kLooks : Real(0);
        }
    });
    if (m_light.element()) return;
    const std::vector<Real> centres = m_lit;
    forCells([&](std::size_t block, std::size_t cell) {
        const Int3 place = grid.place(cell);
        bool edge = parts[cell] != centres[cell];
        for (int i = 0; i < 27 && !edge; ++i) {
            const std::ptrdiff_t beside = grid.index(place + Int3(i % 3, i / 3 % 3, i / 9) - 1);
            edge = beside >= 0 && centres[std::size_t(beside)] != centres[cell];
        }
        if (!edge) return;
        int lit = 0, all = 0;
        for (int i = 0; i < kParts; ++i) {
            const Vec3 ws = wsPart(grid, cell, i);
            if (grid.walled(block) >= 0 && !grid.sees(grid.wsInside(place), ws)) continue;
            ++all;
            lit += reaches(ws) ? 1 : 0;
        }
        if (all > 0) m_lit[cell] = static_cast<Real>(lit) / static_cast<Real>(all);
    });
}

ArrivingInCell FirstCollisions::at(std::size_t cell) const {
    if (m_light.intensity == Rgb(0)) return {};
    const Vec3 ws = m_media.grid.wsCenter(cell);
    ArrivingInCell out{m_unattenuated.at(ws)};
    if (m_light.slide || m_light.spot() || m_light.luminaire) out.irradiance = meanIn(cell);
    if (!m_lit.empty()) out.irradiance *= double(m_lit[cell]);
    out.last = out.irradiance;
    if (out.irradiance == Rgb(0) || !m_light.shadows) return out;
    const Vec3 toLight = -out.travel;
    // The mean chord of a cube along a direction is its volume divided by its projected area.
    const double chord = m_media.grid.edge() / (std::abs(toLight.x) + std::abs(toLight.y) + std::abs(toLight.z));
    const auto attenuate = [&](const CellMedia& media, Rgb& irradiance) {
        Depths depths = bundleDepths(media, ws, toLight, out.distance);
        if (const std::size_t of = &media == &m_media ? 0 : 1; m_beyond[of]) depths += m_beyond[of]->at(cell);
        for (int c = 0; c < 3; ++c)
            irradiance[c] *= meanOverCell(depths.tau[c], chord * double(media.extinctionOf(std::size_t(c))[cell]));
        return depths.straight;
    };
    out.straightDepth = attenuate(m_last, out.last);
    if (&m_last == &m_media)
        out.irradiance = out.last;
    else
        attenuate(m_media, out.irradiance);
    return out;
}

bool FirstCollisions::isNear(std::size_t cell) const {
    const CellGrid& grid = m_media.grid;
    return !m_light.distant() && m_light.point().decay && grid.walled(cell / kBlockCells) < 0 &&
           glm::distance(grid.wsCenter(cell), m_light.wsPosition) < kNear * grid.edge();
}

// Adds what a ray from the lamp, which stands for a solid angle, brings to the near cells on its way.
void FirstCollisions::follow(const Vec3& direction, double solidAngle, std::size_t colour,
                             std::vector<NearLamp>& bundle) const {
    const CellGrid& grid = m_media.grid;
    const double edge = grid.edge(), radius = m_light.point().radius, away = std::max(radius, edge);
    const Vec3& lamp = m_light.wsPosition;
    const double intensity = away * away * m_unattenuated.at(lamp + away * direction).irradiance[int(colour)];
    if (intensity == 0) return;
    double reach = (kNear + 0.5 * std::sqrt(3.0)) * edge;
    if (m_light.shadows && grid.hasWalls())
        reach = std::min(reach, m_scene.solids->firstHit(SolidRole::shadow, lamp, direction, 0, reach));
    // The integral of r^2 / max(r, radius)^2.
    const auto integral = [&](double r) { return r < radius ? r * r * r / (3 * radius * radius) : r - 2 * radius / 3; };
    double tau = 0, tauOfLast = 0, straight = 0;
    walkCells(grid, lamp, direction, reach, [&](std::ptrdiff_t index, double begin, double end) {
        if (index < 0) return true;
        const auto cell = std::size_t(index);
        const double way = m_light.shadows ? end - begin : 0;  // through what attenuates it
        const auto passed = [&](const CellMedia& media, double& depth) {
            const double own = way * double(media.extinctionOf(colour)[cell]);
            return std::exp(-std::exchange(depth, depth + own)) * (own < 1e-6 ? 1 : -std::expm1(-own) / own);
        };
        const double share = solidAngle * intensity * (integral(end) - integral(begin)) / (edge * edge * edge);
        const double arrives = share * passed(m_media, tau), last = share * passed(m_last, tauOfLast);
        const auto& rows = m_last.straight;
        const double goesOn = rows.empty() ? 0 : way * double(rows[rows.size() == 1 ? 0 : colour][cell]);
        straight += goesOn;
        if (!isNear(cell)) return true;
        auto own = std::ranges::find(bundle, cell, &NearLamp::cell);
        if (own == bundle.end()) own = bundle.insert(own, NearLamp{cell});
        own->irradiance += arrives;
        own->last += last;
        own->travel += arrives * direction;
        own->straightDepth += arrives * (straight - 0.5 * goesOn);
        return true;
    });
}

std::vector<NearLamp> FirstCollisions::aroundLamp(std::size_t colour) const {
    constexpr int kBundles = 4, kRays = 12;  // along an edge of a cube around the lamp, and of a bundle
    if (m_light.distant() || !m_light.point().decay) return {};
    const Vec3 cs = m_media.grid.csFromWs(m_light.wsPosition);
    const Vec3 size = Vec3(m_media.grid.blocks() * kCellEdge);
    if (smallest(cs) < -kNear || smallest(size - cs) < -kNear) return {};
    // Turned, so that rows of rays do not lie along the sides of cells.
    const Mat3 frame = frameAround(glm::normalize(Vec3(1, 2, 3.5)));
    std::vector<std::vector<NearLamp>> bundles(std::size_t(6 * kBundles * kBundles));
    parallelFor(bundles.size(), [&](std::size_t b) {
        constexpr double kStep = 0.5 * std::numbers::pi / (kBundles * kRays);  // equal angles on the cube's faces
        const auto slope = [](int k) { return std::tan(kStep * (k + 0.5) - 0.25 * std::numbers::pi); };
        const int face = int(b) % 6, first = int(b) / 6;
        for (int i = 0; i < kRays * kRays; ++i) {
            const double x = slope(first % kBundles * kRays + i % kRays);
            const double y = slope(first / kBundles * kRays + i / kRays), length = std::sqrt(1 + x * x + y * y);
            Vec3 way;
            way[face % 3] = face < 3 ? 1 : -1;
            way[(face + 1) % 3] = x;
            way[(face + 2) % 3] = y;
            follow(frame * way / length, kStep * kStep * (1 + x * x) * (1 + y * y) / std::pow(length, 3), colour,
                   bundles[b]);
        }
    });
    std::vector<NearLamp> all;
    for (const std::vector<NearLamp>& bundle : bundles)
        for (NearLamp light : bundle) {
            if (!(light.irradiance > 0)) continue;
            light.straightDepth /= light.irradiance;
            light.travel = glm::normalize(light.travel);
            all.push_back(light);
        }
    return all;
}

Rgb FirstCollisions::onto(const Vec3& ws, const Vec3& wsNormal) const {
    const Arriving light = m_unattenuated.at(ws);
    const double factor = -glm::dot(light.travel, wsNormal);
    if (factor <= 0 || light.irradiance == Rgb(0)) return Rgb(0);
    if (!m_light.shadows) return light.irradiance * factor;
    constexpr double kBeside = 1e-3;  // of a cell's edge: solids are traced in floats
    const Vec3 beside = ws + kBeside * m_media.grid.edge() * glm::normalize(wsNormal);
    if (!reaches(beside)) return Rgb(0);
    return light.irradiance * factor * glm::exp(-opticalDepths(m_media, beside, -light.travel, light.distance).tau);
}

// The most points that represent an extended light.
constexpr int kMostPoints = 12, kMostOfSkies = 96;
// The mean for one ordinate, weighted by solid angles.
struct SkyMean {
    double radiance = 0, weight = 0;
};

void addSky(const Light& sky, const Ordinates& ordinates, int colour, std::vector<double>& radiance) {
    if (!sky.slide) {
        for (double& r : radiance) r += sky.intensity[colour];
        return;
    }
    const Texture::Level& picture = wideLevel(*sky.slide);
    // A picture of few pixels is sampled at more points, so that every ordinate gets some.
    constexpr int kColumns = 256;
    const int finer = std::max(1, kColumns / (2 * std::max(picture.width, picture.height)));
    const int width = picture.width * finer, height = picture.height * finer;
    std::vector<int> nearest(std::size_t(width) * std::size_t(height));
    parallelFor(std::size_t(height), [&](std::size_t y) {
        const double v = (double(y) + 0.5) / height;
        for (int x = 0; x < width; ++x)
            nearest[y * std::size_t(width) + std::size_t(x)] =
                nearestOrdinate(ordinates, -domeDirection(sky, (x + 0.5) / width, v));
    });
    std::vector<SkyMean> means(radiance.size());
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            const double v = (y + 0.5) / height;
            const auto at = std::size_t(y) * std::size_t(width) + std::size_t(x);
            SkyMean& mean = means[std::size_t(nearest[at])];
            const double weight = std::sin(std::numbers::pi * v);
            mean.radiance += weight * double(picture.pixel(x / finer, y / finer)[colour]);
            mean.weight += weight;
        }
    for (std::size_t m = 0; m < radiance.size(); ++m)
        if (means[m].weight > 0) radiance[m] += sky.intensity[colour] * means[m].radiance / means[m].weight;
}

// The light itself, or a few lights that represent it; of a sky that comes in at the border its suns.
std::vector<Light> pointsOf(const ViewScene& scene, std::size_t number) {
    const Light& light = scene.lights[number];
    if (entersAtBorder(scene, number)) return sunsOfSky(scene, light);
    if (!light.extended()) return {light};
    ViewScene alone = scene;
    alone.lights = {light};
    alone.lights.front().samples = std::min(subLightCount(scene, light), light.dome() ? kMostOfSkies : kMostPoints);
    if (light.dome()) alone.volumes.clear();
    return subLights(alone).lights;
}

}  // namespace

std::vector<Real> inflowOf(const ViewScene& scene, const ScatterTarget& target, const Ordinates& ordinates,
                           int colour) {
    std::vector<double> radiance(std::size_t(ordinates.count()), 0.0);
    if (target.ambient)
        for (double& r : radiance) r += scene.ambient[colour];
    for (const int light : target.lights)
        if (entersAtBorder(scene, std::size_t(light)))
            addSky(scene.lights[std::size_t(light)], ordinates, colour, radiance);
    if (std::all_of(radiance.begin(), radiance.end(), [](double r) { return r == 0; })) return {};
    return {radiance.begin(), radiance.end()};
}

FirstLight::FirstLight(const ViewScene& scene, const ScatterTarget& target, int colour, const Cells& cells,
                       const TransportSolver& solver)
    : m_colour(colour), m_emission(target.emission), m_solver(solver) {
    if (!cells.last.straight.empty())
        m_straight.assign(cells.moments ? 4 : cells.classes.size(), std::vector<Real>(solver.rows(), Real(0)));
    m_onSides.assign(cells.media.grid.sides(), Real(0));
    for (const int owner : target.lights) {
        for (const Light& point : pointsOf(scene, std::size_t(owner))) {
            const FirstCollisions rays(scene, cells.media, cells.last, cells.around, point);
            std::vector<Real>& irradiance = m_irradiance.emplace_back(solver.rows());
            m_points.emplace_back(std::size_t(owner), point);
            parallelFor(solver.rows(), [&](std::size_t row) {
                const std::size_t cell = solver.cellOfRow()[row];
                if (rays.isNear(cell) || (m_straight.empty() && !cells.media.sends(cell))) return;
                const ArrivingInCell arriving = rays.at(cell);
                irradiance[row] = static_cast<Real>(arriving.irradiance[colour]);
                addStraight(scene, cells, std::size_t(owner),
                            {arriving.travel, arriving.last[colour], arriving.straightDepth[colour],
                             cells.media.grid.wsCenter(cell)},
                            row);
            });
            auto& near = m_near.emplace_back();
            for (const NearLamp& light : rays.aroundLamp(std::size_t(colour))) {
                const std::int32_t row = solver.rowOfCell()[light.cell];
                if (row < 0) continue;
                near.emplace_back(row, light.travel, static_cast<Real>(light.irradiance));
                addStraight(scene, cells, std::size_t(owner),
                            {light.travel, light.last, light.straightDepth, cells.media.grid.wsCenter(light.cell)},
                            std::size_t(row));
            }
            parallelFor(m_onSides.size(), [&](std::size_t side) {
                double sum = 0;
                for (const auto& [ws, normal] : cells.media.grid.pointsOfSide(side))
                    sum += rays.onto(ws, normal)[colour];
                m_onSides[side] +=
                    static_cast<Real>(sum * cells.media.grid.firstOfSide(side)[colour] / std::numbers::pi);
            });
        }
    }
}

bool FirstLight::turnTo(int colour, const CellMedia& media, const CellMedia& last) {
    if (!m_onSides.empty() || media.extinction.size() > 1 || last.extinction.size() > 1 || last.straight.size() > 1)
        return false;
    std::vector<Real> factors;
    for (const auto& [owner, light] : m_points) {
        if (light.slide || light.intensity[m_colour] == 0) return false;
        factors.push_back(static_cast<Real>(light.intensity[colour] / light.intensity[m_colour]));
        if (!m_straight.empty() && factors.back() != factors.front()) return false;  // it is the sum of all
    }
    for (std::size_t p = 0; p < factors.size(); ++p) {
        for (Real& irradiance : m_irradiance[p]) irradiance *= factors[p];
        for (auto& [row, travel, irradiance] : m_near[p]) irradiance *= factors[p];
    }
    for (std::vector<Real>& row : m_straight)
        for (Real& light : row) light *= factors.empty() ? Real(1) : factors.front();
    m_colour = colour;
    return true;
}

FirstLight FirstLight::ofOnce() const {
    FirstLight out = *this;
    out.m_once = true;
    out.m_emission = false;
    out.m_straight.clear();
    out.m_onSides.clear();
    return out;
}

std::size_t FirstLight::points(const ViewScene& scene, const ScatterTarget& target) {
    std::size_t count = 0;
    for (const int light : target.lights) count += pointsOf(scene, std::size_t(light)).size();
    return count;
}

std::size_t FirstLight::bytes() const {
    std::size_t values = m_onSides.size();
    for (const auto* rows : {&m_irradiance, &m_straight})
        for (const std::vector<Real>& row : *rows) values += row.size();
    std::size_t bytes = values * sizeof(Real);
    for (const auto& near : m_near) bytes += near.size() * sizeof(near.front());
    return bytes;
}

// Where phase functions are mixed, each class sees the beam as if its own phase function had spread it.
void FirstLight::addStraight(const ViewScene& scene, const Cells& cells, std::size_t owner, const Straight& light,
                             std::size_t row) {
    const auto& [travel, irradiance, depth, ws] = light;
    if (m_straight.empty() || depth == 0 || !(irradiance > 0)) return;
    if (cells.moments) {
        const double mean = -std::expm1(-depth) * irradiance / (4 * std::numbers::pi);
        m_straight[0][row] += static_cast<Real>(mean);
        for (int axis = 0; axis < 3; ++axis)
            m_straight[std::size_t(1 + axis)][row] += static_cast<Real>(mean * travel[axis]);
        return;
    }
    const double cosine = glm::dot(travel, travelToEye(scene.camera, ws));
    for (std::size_t k = 0; k < cells.classes.size(); ++k)
        if (const ScatterClass& own = cells.classes[k]; !own.once && own.litBy(owner))
            m_straight[k][row] += static_cast<Real>(irradiance * own.split.scatteredAgain(depth, cosine));
}

void FirstLight::addTo(const Ordinates& along, const std::vector<ScatterClass>& classes, const CellMedia& media,
                       Simd simd, std::vector<Real>& source) const {
    const std::size_t values = m_solver.valuesPerRow();
    const std::vector<std::size_t>& cells = m_solver.cellOfRow();
    for (std::size_t p = 0; p < m_points.size(); ++p) {
        const auto& [owner, point] = m_points[p];
        const LightAt light(point, kNearest * media.grid.edge());
        std::vector<std::pair<std::size_t, std::vector<Real>>> lit;  // classes, and rows that serve all their cells
        for (std::size_t k = 0; k < classes.size(); ++k) {
            if (classes[k].once != m_once || !classes[k].litBy(owner)) continue;
            std::vector<Real>& even = lit.emplace_back(k, std::vector<Real>(point.distant() ? values : 0)).second;
            if (!even.empty() && !m_solver.isotropic())
                scatteringRow(along, classes[k].first(), point.wsDirection, even.data(), simd);
        }
        const auto add = [&](std::size_t row, Real irradiance, const Vec3& travel, std::vector<Real>& own) {
            for (const auto& [k, even] : lit) {
                const Real scattered = media.scatteringOf(k, std::size_t(m_colour))[cells[row]] * irradiance;
                Real* to = source.data() + row * values;
                if (m_solver.isotropic()) {
                    *to += scattered / static_cast<Real>(4 * std::numbers::pi);
                    continue;
                }
                if (even.empty() && scattered > 0) scatteringRow(along, classes[k].first(), travel, own.data(), simd);
                const Real* into = even.empty() ? own.data() : even.data();
                for (std::size_t m = 0; scattered > 0 && m < values; ++m) to[m] += scattered * into[m];
            }
        };
        parallelChunks(cells.size(), [&](std::size_t begin, std::size_t end) {
            std::vector<Real> own(values);
            for (std::size_t row = begin; row < end; ++row)
                if (m_irradiance[p][row] > 0)
                    add(row, m_irradiance[p][row], light.at(media.grid.wsCenter(cells[row])).travel, own);
        });
        std::vector<Real> own(values);
        for (const auto& [row, travel, irradiance] : m_near[p]) add(std::size_t(row), irradiance, travel, own);
    }
    for (std::size_t side = 0; side < m_onSides.size(); ++side) source[cells.size() * values + side] += m_onSides[side];
    for (std::size_t row = 0; m_emission && !media.emission.empty() && row < cells.size(); ++row)
        for (std::size_t m = 0; m < values; ++m)
            source[row * values + m] += media.emission[std::size_t(m_colour)][cells[row]];
}

}  // namespace scrim
