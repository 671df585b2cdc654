// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/light/backdrop.h>

#include <scrim/engine/light/ray_blocks.h>
#include <scrim/engine/model/plan.h>
#include <scrim/scene/picture_cells.h>

#include <algorithm>
#include <limits>
#include <numbers>
#include <optional>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace scrim {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

bool coloured(const Solid& solid) {
    return solid.color.has_value();
}

}  // namespace

bool hasBackdrop(const ViewScene& scene) {
    return wants(scene, Layer::backdrop) && (std::ranges::any_of(scene.lights, &Light::visible) ||
                                             (scene.solids && std::ranges::any_of(scene.solids->all(), coloured)));
}

Backdrop::Backdrop(const ViewScene& scene)
    : m_scene(scene), m_rays(wsRays(scene.camera)), m_pixel(pixelAt(scene.camera, 1)), m_light(scene) {}

Backdrop::Met Backdrop::meets(double x, double y) const {
    const Vec3 origin = m_rays.origin(x, y), way = m_rays.direction(x, y), direction = glm::normalize(way);
    Met met;
    if (m_scene.solids) {
        const SolidHit hit = m_scene.solids->trace(SolidRole::holdout, origin, way, m_rays.near, kInfinity);
        if (hit.solid != nullptr) {
            const Vec3 normal = glm::normalize(hit.wsNormal), ws = origin + hit.t * way;
            if (hit.solid->light) {
                const double away = m_scene.camera.type == CameraType::orthographic ? 1 : hit.t * glm::length(way);
                const Rgb shines =
                    visibleSurface(m_scene.lights[*hit.solid->light], ws, normal, direction, m_pixel * away);
                met.shines = {shines.x, shines.y, shines.z, 1};
                return met;
            }
            if (!hit.solid->color) return met;
            return {hit.solid, ws, glm::dot(normal, direction) > 0 ? -normal : normal, {}};
        }
    }
    for (const Light& light : m_scene.lights) {
        if (!light.visible || !light.dome()) continue;
        const Rgb sky = visibleSky(light, direction, m_pixel);
        for (int c = 0; c < 3; ++c) met.shines[std::size_t(c)] += sky[c];
        met.shines[3] = 1;
    }
    return met;
}

Rgb Backdrop::lightOn(const Met& met) const {
    return m_light.irradiance(met.ws, met.normal) / std::numbers::pi + m_scene.ambient;
}

namespace {

std::array<double, 4> shown(const Backdrop::Met& met, const Rgb& light) {
    const Rgb seen = *met.solid->color * light;
    return {seen.x, seen.y, seen.z, 1};
}

// A square of rays, and those of the next row and column.
class BackdropBlock {
  public:
    static constexpr int kEdge = 8;

    BackdropBlock(const Backdrop& backdrop, const Int2& first, int antialias) : m_backdrop(backdrop) {
        for (int y = 0; y <= kEdge; ++y)
            for (int x = 0; x <= kEdge; ++x)
                m_met[y][x] = backdrop.meets((first.x + x + 0.5) / antialias, (first.y + y + 0.5) / antialias);
        fillRays(
            Int2(0), kEdge, [&](const Int2& at) { return m_met[at.y][at.x].solid != nullptr; },
            [&](const Int2& from, int edge) { return isEven(from, edge); },
            [&](const Int2& at) -> const Rgb& { return lightAt(at); },
            [&](const Int2& at, const InSquare& place, const auto&... corners) {
                m_filled[at.y][at.x] = place.between(corners...);
            });
    }
    std::array<double, 4> at(int x, int y) const {
        return m_met[y][x].solid != nullptr ? shown(m_met[y][x], m_filled[y][x]) : m_met[y][x].shines;
    }

  private:
    // True if all rays of a square meet one plane of one solid, and the light is about the same at its corners and in
    // its middle.
    bool isEven(const Int2& from, int edge) {
        constexpr double kPlane = 1 - 1e-6, kAlike = 0.01;
        const Backdrop::Met& first = m_met[from.y][from.x];
        if (first.solid == nullptr) return false;
        for (int y = from.y; y <= from.y + edge; ++y)
            for (int x = from.x; x <= from.x + edge; ++x)
                if (m_met[y][x].solid != first.solid || glm::dot(m_met[y][x].normal, first.normal) < kPlane)
                    return false;
        Rgb least(kInfinity), most(0);
        for (const Int2& at : {Int2(0), Int2(edge, 0), Int2(0, edge), Int2(edge), Int2(edge / 2)}) {
            least = glm::min(least, lightAt(from + at));
            most = glm::max(most, lightAt(from + at));
        }
        return largest(most - least) <= kAlike * largest(most);
    }

    const Rgb& lightAt(const Int2& at) {
        std::optional<Rgb>& light = m_light[at.y][at.x];
        if (!light) light = m_backdrop.lightOn(m_met[at.y][at.x]);
        return *light;
    }

    const Backdrop& m_backdrop;
    Backdrop::Met m_met[kEdge + 1][kEdge + 1];
    std::optional<Rgb> m_light[kEdge + 1][kEdge + 1];
    Rgb m_filled[kEdge][kEdge];
};

}  // namespace

std::array<double, 4> Backdrop::at(double x, double y) const {
    const Met met = meets(x, y);
    return met.solid != nullptr ? shown(met, lightOn(met)) : met.shines;
}

std::size_t BackdropRays::bytes(const ViewScene& scene) {
    return hasBackdrop(scene) ? supersampled(scene.region, scene.dials.antialias).pixelCount() * sizeof(float) * 4 : 0;
}

BackdropRays::BackdropRays(const ViewScene& scene, const Checkpoint& checkpoint)
    : m_antialias(scene.dials.antialias), m_window(supersampled(scene.region, m_antialias)) {
    const Backdrop backdrop(scene);
    m_rays.resize(m_window.pixelCount());
    constexpr int kEdge = BackdropBlock::kEdge;
    forRayBlocks(m_window, kEdge, kEdge, checkpoint, [&](const Int2& first) {
        const BackdropBlock block(backdrop, first, m_antialias);
        for (int y = std::max(first.y, m_window.y0); y < std::min(first.y + kEdge, m_window.y1); ++y)
            for (int x = std::max(first.x, m_window.x0); x < std::min(first.x + kEdge, m_window.x1); ++x)
                std::ranges::copy(block.at(x - first.x, y - first.y), m_rays[indexOf(x, y)].begin());
    });
}

}  // namespace scrim
