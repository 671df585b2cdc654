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

bool anyColoured(const ViewScene& scene) {
    return scene.solids &&
           std::ranges::any_of(scene.solids->all(), [](const Solid& solid) { return solid.color.has_value(); });
}

}  // namespace

bool hasBackdrop(const ViewScene& scene) {
    return wants(scene, Layer::backdrop) && (std::ranges::any_of(scene.lights, &Light::visible) || anyColoured(scene));
}

bool backdropIsLitByVolumes(const ViewScene& scene) {
    return wants(scene, Layer::backdrop) && anyColoured(scene) && anyShines(scene);
}

Backdrop::Backdrop(const ViewScene& scene, const TransportPlan& again, const Checkpoint& checkpoint)
    : m_scene(scene), m_rays(wsRays(scene.camera)), m_pixel(pixelAt(scene.camera, 1)), m_light(scene) {
    if (backdropIsLitByVolumes(scene)) m_shine = std::make_unique<const VolumeShine>(scene, again, checkpoint);
}

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

Rgb Backdrop::shineOn(const Met& met) const {
    return m_shine ? m_shine->irradiance(met.ws, met.normal) / std::numbers::pi : Rgb(0);
}

namespace {

std::array<double, 4> shown(const Backdrop::Met& met, const Rgb& light) {
    const Rgb seen = *met.solid->color * light;
    return {seen.x, seen.y, seen.z, 1};
}

// A square of rays, and those of the next row and column.
class BackdropBlock {
  public:
    static constexpr int kEdge = 16;

    BackdropBlock(const Backdrop& backdrop, const Int2& first, int antialias) {
        for (int y = 0; y <= kEdge; ++y)
            for (int x = 0; x <= kEdge; ++x)
                m_met[y][x] = backdrop.meets((first.x + x + 0.5) / antialias, (first.y + y + 0.5) / antialias);
        constexpr int kSquare = 8;
        constexpr double kAlike = 0.01, kMost = 0.3;
        fill(
            m_light, kSquare, [&](const Backdrop::Met& met) { return backdrop.lightOn(met); },
            [](const Int2&, const Square& light) { return light.range() <= kAlike * largest(light.most); });
        // What volumes send has no sharp shadows, so that it may be nearly linear where it is not even.
        fill(
            m_shine, kEdge, [&](const Backdrop::Met& met) { return backdrop.shineOn(met); },
            [&](const Int2& from, const Square& light) {
                const double all = largest(light.most) + largest(m_light.filled[from.y][from.x]);
                return light.bend <= 2 * kAlike * all && light.range() <= kMost * all;
            });
    }
    std::array<double, 4> at(int x, int y) const {
        return m_met[y][x].solid != nullptr ? shown(m_met[y][x], m_light.filled[y][x] + m_shine.filled[y][x])
                                            : m_met[y][x].shines;
    }

  private:
    // One kind of light at the rays: where it was asked for, and at all rays.
    struct Kind {
        std::optional<Rgb> known[kEdge + 1][kEdge + 1];
        Rgb filled[kEdge][kEdge];
    };

    // Light at the corners of a square and in its middle.
    struct Square {
        Rgb least{kInfinity}, most{0};
        double bend = 0;  // by how much the middle differs from the mean of the corners
        double range() const { return largest(most - least); }
    };

    // `square`: the edge of the largest parts that are interpolated; isEven(first ray, light) says whether they may be.
    template <class LightOn, class IsEven>
    void fill(Kind& kind, int square, const LightOn& lightOn, const IsEven& isEven) {
        const auto lightAt = [&](const Int2& at) -> const Rgb& {
            std::optional<Rgb>& light = kind.known[at.y][at.x];
            if (!light) light = lightOn(m_met[at.y][at.x]);
            return *light;
        };
        for (int y = 0; y < kEdge; y += square)
            for (int x = 0; x < kEdge; x += square)
                fillRays(
                    Int2(x, y), square, [&](const Int2& at) { return m_met[at.y][at.x].solid != nullptr; },
                    [&](const Int2& from, int edge) {
                        return isPlane(from, edge) && isEven(from, squareOf(from, edge, lightAt));
                    },
                    lightAt,
                    [&](const Int2& at, const InSquare& place, const auto&... corners) {
                        kind.filled[at.y][at.x] = place.between(corners...);
                    });
    }

    // True if all rays of a square meet one plane of one solid.
    bool isPlane(const Int2& from, int edge) const {
        constexpr double kPlane = 1 - 1e-6;
        const Backdrop::Met& first = m_met[from.y][from.x];
        if (first.solid == nullptr) return false;
        for (int y = from.y; y <= from.y + edge; ++y)
            for (int x = from.x; x <= from.x + edge; ++x)
                if (m_met[y][x].solid != first.solid || glm::dot(m_met[y][x].normal, first.normal) < kPlane)
                    return false;
        return true;
    }

    template <class LightAt>
    static Square squareOf(const Int2& from, int edge, const LightAt& lightAt) {
        Square out;
        const Rgb& middle = lightAt(from + edge / 2);
        Rgb bend = -middle;
        for (const Int2& at : {Int2(0), Int2(edge, 0), Int2(0, edge), Int2(edge)}) {
            const Rgb& light = lightAt(from + at);
            out.least = glm::min(out.least, light);
            out.most = glm::max(out.most, light);
            bend += 0.25 * light;
        }
        out.least = glm::min(out.least, middle);
        out.most = glm::max(out.most, middle);
        out.bend = largest(glm::abs(bend));
        return out;
    }

    Backdrop::Met m_met[kEdge + 1][kEdge + 1];
    Kind m_light, m_shine;
};

}  // namespace

std::array<double, 4> Backdrop::at(double x, double y) const {
    const Met met = meets(x, y);
    return met.solid != nullptr ? shown(met, lightOn(met) + shineOn(met)) : met.shines;
}

std::size_t BackdropRays::bytes(const ViewScene& scene) {
    if (!hasBackdrop(scene)) return 0;
    const std::size_t shine = backdropIsLitByVolumes(scene) ? VolumeShine::bytes() : 0;
    return shine + supersampled(scene.region, scene.dials.antialias).pixelCount() * sizeof(float) * 4;
}

BackdropRays::BackdropRays(const ViewScene& scene, const TransportPlan& again, const Checkpoint& checkpoint)
    : m_antialias(scene.dials.antialias), m_window(supersampled(scene.region, m_antialias)) {
    const Backdrop backdrop(scene, again, checkpoint);
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
