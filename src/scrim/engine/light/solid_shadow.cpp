// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/light/solid_shadow.h>

#include <scrim/engine/light/marched_light.h>
#include <scrim/engine/light/ray_blocks.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <vector>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

namespace scrim {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// One layer and what it catches.
struct Caught {
    std::vector<float>* data;
    std::size_t light;
};

// Catches the shadows of blocks of eye rays. What arrives at a solid is as smooth as the volumes'
// grids, so where a block's points on solids are closer together than the sheets are thick, at most
// a voxel, it is interpolated between the block's corners.
class Catcher {
  public:
    static constexpr int kBlock = 16;  // rays along an edge

    Catcher(const ViewScene& scene, const std::vector<Caught>& layers)
        : m_scene(scene),
          m_layers(layers),
          m_light(scene),
          m_rays(wsRays(supersampled(scene.camera, scene.dials.antialias))),
          m_span(std::min(scene.dials.sheetThickness, 1.0) * voxelUnit(scene)) {}

    // Catches the rays from `first` on that belong to pixels of the region. Returns the number of rays to lights.
    std::uint64_t catchBlock(const Int2& first) const {
        Block block{first, {}, {}, 0};
        for (int y = 0; y <= kBlock; ++y)
            for (int x = 0; x <= kBlock; ++x)
                block.points[y][x] = caughtAt(*m_scene.solids, m_rays, first.x + x + 0.5, first.y + y + 0.5);
        std::vector<Rgb> arrives(m_layers.size());
        fillRays(
            Int2(0), kBlock, [&](const Int2& at) { return block.points[at.y][at.x].has_value(); },
            [&](const Int2& from, int edge) { return isSmooth(block, from, edge); },
            [&](const Int2& at) -> const std::vector<Rgb>& { return arrivesAt(block, at); },
            [&](const Int2& at, const InSquare& place, const auto&... corners) {
                for (std::size_t i = 0; i < arrives.size(); ++i) arrives[i] = place.between(corners[i]...);
                add(block, at, arrives);
            });
        return block.marched;
    }

  private:
    struct Block {
        Int2 first;  // ray of the supersampled picture
        std::optional<Vec3> points[kBlock + 1][kBlock + 1];
        std::vector<Rgb> arrives[kBlock + 1][kBlock + 1];  // of each layer; empty where it is not known
        std::uint64_t marched;
    };

    // True if all rays of a square meet solids that catch, close together.
    bool isSmooth(const Block& block, const Int2& from, int edge) const {
        Bounds box;
        for (int y = from.y; y <= from.y + edge; ++y)
            for (int x = from.x; x <= from.x + edge; ++x) {
                if (!block.points[y][x]) return false;
                box.include(*block.points[y][x]);
            }
        return glm::length(box.size()) <= m_span;
    }

    const std::vector<Rgb>& arrivesAt(Block& block, const Int2& at) const {
        std::vector<Rgb>& arrives = block.arrives[at.y][at.x];
        if (!arrives.empty()) return arrives;
        for (const Caught& layer : m_layers) {
            arrives.push_back(m_light.transmittance(layer.light, *block.points[at.y][at.x]));
            block.marched += m_light.rays(layer.light);
        }
        return arrives;
    }

    void add(const Block& block, const Int2& at, const std::vector<Rgb>& arrives) const {
        const int n = m_scene.dials.antialias;
        const PixelWindow& region = m_scene.region;
        const Int2 pixel = glm::ivec2(glm::floor(Vec2(block.first + at) / double(n)));
        if (pixel.x < region.x0 || pixel.x >= region.x1 || pixel.y < region.y0 || pixel.y >= region.y1) return;
        const std::size_t offset =
            3 * (std::size_t(pixel.y - region.y0) * std::size_t(region.width()) + std::size_t(pixel.x - region.x0));
        for (std::size_t i = 0; i < m_layers.size(); ++i) {
            const Rgb lost = (1.0 - arrives[i]) / double(n * n);
            for (int c = 0; c < 3; ++c) (*m_layers[i].data)[offset + std::size_t(c)] -= static_cast<float>(lost[c]);
        }
    }

    const ViewScene& m_scene;
    const std::vector<Caught>& m_layers;
    MarchedLight m_light;
    RayFamily m_rays;
    double m_span;
};

}  // namespace

std::optional<Vec3> caughtAt(const Solids& solids, const RayFamily& rays, double x, double y) {
    const Vec3 origin = rays.origin(x, y), direction = rays.direction(x, y);
    const double caught = solids.firstHit(SolidRole::catcher, origin, direction, rays.near, kInfinity);
    if (caught == kInfinity) return std::nullopt;
    constexpr double kSame = 1e-6;  // relative to the distance: one solid may both catch and hide
    if (solids.firstHit(SolidRole::holdout, origin, direction, rays.near, caught * (1 - kSame)) < kInfinity)
        return std::nullopt;
    return origin + caught * direction;
}

std::uint64_t catchShadows(const ViewScene& scene, Frame& frame, const Checkpoint& checkpoint) {
    const bool any = scene.solids && scene.solids->any(SolidRole::catcher);
    std::vector<Caught> layers;
    for (FrameLayer& layer : frame.layers) {
        if (layer.layer != Layer::shadow) continue;
        std::fill(layer.data.begin(), layer.data.end(), 1.0f);
        if (any && scene.lights[std::size_t(layer.light)].shadows)
            layers.push_back({&layer.data, std::size_t(layer.light)});
    }
    if (layers.empty()) return 0;
    const Catcher catcher(scene, layers);
    // Blocks hold whole pixels or are parts of one row of blocks, whose pixels no other thread adds to.
    const int n = scene.dials.antialias;
    std::atomic<std::uint64_t> marched = 0;
    forRayBlocks(supersampled(scene.region, n), Catcher::kBlock, std::lcm(Catcher::kBlock, n), checkpoint,
                 [&](const Int2& first) { marched += catcher.catchBlock(first); });
    return marched;
}

namespace {

// A ray lights its path up to N, which is `past` sheets before it meets a surface.
//
// A surface that hides what is behind it ends the eye's ray at the same place as the light's. The eye's ray then
// already determines how much of the sheet counts, and the light must not reduce it once more. So light goes on for
// `margin` sheets if eye and light are on the same side of the surface. If the surface lies between them, the side that
// the eye sees is dark, and so is the space next to it. Thus the look of a surface does not depend on the positions of
// the sheets. A surface that does not hide casts shadows from where it is.
double pastSheet(const SolidHit& hit, const Vec3& wsLight, const Vec3& wsEye, double margin) {
    if (!hit.solid->holdout) return 0;
    return glm::dot(hit.wsNormal, wsLight) * glm::dot(hit.wsNormal, wsEye) > 0 ? -margin : margin;
}

// The direction of the eye's ray to a point.
Vec3 eyeTo(const Vec3& ws, const Camera& camera) {
    return camera.type == CameraType::orthographic ? viewingAxis(camera) : ws - camera.wsPosition;
}

// Ends of rays that differ by less than this are those of one surface, sheets.
constexpr Real kOneSurface = 1;

SolidRaster trace(const Solids& solids, const LightView& view, const Sheets& sheets, const Camera& camera,
                  const SolidDetail& detail) {
    const Vec3 wsSource = sheets.wsPoint(view.tsSource);
    const auto endAt = [&](double x, double y) {
        const double a = view.first.x + x * view.cell, b = view.first.y + y * view.cell;
        // N is the parameter of a distant light's ray; for other lights the parameter is N minus that of the source.
        const Vec3 origin = view.distant ? sheets.wsPoint({a, b, 0}) : wsSource;
        const Vec3 along = view.distant ? sheets.wsPoint({a + view.tsSource.x, b + view.tsSource.y, 1}) - origin
                                        : sheets.wsPoint(view.tsSource + Vec3(a, b, 1)) - wsSource;
        const SolidHit hit = solids.trace(SolidRole::shadow, origin, along, view.distant ? -kInfinity : 0, kInfinity);
        const double past =
            hit.t < kInfinity ? pastSheet(hit, along, eyeTo(origin + hit.t * along, camera), detail.margin) : 0;
        return static_cast<Real>(hit.t + (view.distant ? 0 : view.tsSource.z) - past);
    };
    return {Int2(view.width, view.height), detail.parts, kOneSurface, endAt};
}

// Texel positions on a plane to positions in the raster.
struct ToRaster {
    Real scale, shiftU, shiftV;

    explicit ToRaster(const LightView::Cells& map)
        : scale(static_cast<Real>(1 / map.scale)),
          shiftU(static_cast<Real>(-map.offsetU / map.scale)),
          shiftV(static_cast<Real>(-map.offsetV / map.scale)) {}
};

}  // namespace

SolidShadow::SolidShadow(const Solids& solids, const LightView& view, const Sheets& sheets, const Camera& camera,
                         const SolidDetail& detail, Simd simd)
    : m_view(view),
      m_simd(simd),
      m_toTexels(sheets.thickness / sheets.texel),
      m_raster(trace(solids, view, sheets, camera, detail)) {}

void SolidShadow::multiply(int n, const SampleTile& samples, Real* light) const {
    if (!m_view.reaches(n)) return;
    RasterPaths paths;
    constexpr double kLeast = 0.01;  // sheets from the light, where its rays begin
    const double begin = m_view.distant ? -0.5 : std::max(-0.5, m_view.tsSource.z + kLeast - n - 0.5);
    // The places on the samples' rays at N = n + 1/2 + `plane`, which lie `away` sheets from the samples.
    const auto mapAt = [&](double plane) { return ToRaster(m_view.atPlane(n + 0.5 + plane)); };
    const auto place = [&](int k, double away, double plane, const ToRaster& map, RasterPaths::Places& to) {
        const auto shift = static_cast<Real>(away * m_toTexels);
        to.x[k] = (samples.u[k] + shift * samples.eyeA[k]) * map.scale + map.shiftU;
        to.y[k] = (samples.v[k] + shift * samples.eyeB[k]) * map.scale + map.shiftV;
        to.n[k] = static_cast<Real>(n + 0.5 + plane);
    };
    if (samples.part == nullptr) {
        const ToRaster first = mapAt(begin), last = mapAt(0.5);
        for (int k = 0; k < kTileSize; ++k) place(k, begin, begin, first, paths.first);
        for (int k = 0; k < kTileSize; ++k) place(k, 0.5, 0.5, last, paths.last);
    } else {
        for (int k = 0; k < kTileSize; ++k) {
            const double middle = double(samples.at[k]) - double(samples.step), half = 0.5 * double(samples.part[k]);
            const double from = std::max(middle - half, begin), to = std::max(middle + half, begin);
            place(k, from - middle, from, mapAt(from), paths.first);
            place(k, to - middle, to, mapAt(to), paths.last);
        }
    }
    m_raster.pass(paths, m_simd, light);
}

void SolidShadow::multiply(int n, const Real* u, const Real* v, Real* light) const {
    if (!m_view.reaches(n)) return;
    const ToRaster map(m_view.at(n));
    const auto middle = static_cast<Real>(n + 0.5);
    for (int k = 0; k < kTileSize; ++k)
        light[k] *= m_raster.passed(u[k] * map.scale + map.shiftU, v[k] * map.scale + map.shiftV, middle);
}

}  // namespace scrim
