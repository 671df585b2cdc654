// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/light/backdrop.h>

#include <scrim/base/parallel.h>
#include <scrim/engine/model/plan.h>
#include <scrim/scene/picture_cells.h>

#include <algorithm>
#include <limits>
#include <numbers>

#include <glm/geometric.hpp>

namespace scrim {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

bool coloured(const Solid& solid) {
    return solid.color.has_value();
}

FrameLayer* backdropOf(Frame& frame) {
    const auto found = std::ranges::find(frame.layers, Layer::backdrop, &FrameLayer::layer);
    return found == frame.layers.end() ? nullptr : &*found;
}

}  // namespace

bool hasBackdrop(const ViewScene& scene) {
    return wants(scene, Layer::backdrop) && (std::ranges::any_of(scene.lights, &Light::visible) ||
                                             (scene.solids && std::ranges::any_of(scene.solids->all(), coloured)));
}

Backdrop::Backdrop(const ViewScene& scene)
    : m_scene(scene),
      m_rays(wsRays(scene.camera)),
      m_pixel(pixelAt(scene.camera, 1)),
      m_light(scene),
      m_sky(std::ranges::any_of(scene.lights, &Light::visible)) {}

Rgb Backdrop::skies(const Vec3& wsDirection) const {
    Rgb sum(0);
    for (const Light& light : m_scene.lights)
        if (light.visible) sum += visibleSky(light, wsDirection, m_pixel);
    return sum;
}

std::array<double, 4> Backdrop::at(double x, double y) const {
    const Vec3 origin = m_rays.origin(x, y), way = m_rays.direction(x, y), direction = glm::normalize(way);
    if (m_scene.solids) {
        const SolidHit hit = m_scene.solids->trace(SolidRole::holdout, origin, way, m_rays.near, kInfinity);
        if (hit.solid != nullptr) {
            if (!hit.solid->color) return {};
            const Vec3 normal = glm::normalize(hit.wsNormal);
            const Vec3 towards = glm::dot(normal, direction) > 0 ? -normal : normal;
            const Rgb light = m_light.irradiance(origin + hit.t * way, towards) / std::numbers::pi + m_scene.ambient;
            const Rgb seen = *hit.solid->color * light;
            return {seen.x, seen.y, seen.z, 1};
        }
    }
    if (!m_sky) return {};
    const Rgb seen = skies(direction);
    return {seen.x, seen.y, seen.z, 1};
}

std::size_t BackdropRays::bytes(const ViewScene& scene) {
    return hasBackdrop(scene) ? supersampled(scene.region, scene.dials.antialias).pixelCount() * sizeof(float) * 4 : 0;
}

BackdropRays::BackdropRays(const ViewScene& scene, const Checkpoint& checkpoint)
    : m_antialias(scene.dials.antialias), m_window(supersampled(scene.region, m_antialias)) {
    const Backdrop backdrop(scene);
    m_rays.resize(m_window.pixelCount());
    const auto width = std::size_t(m_window.width()), rows = std::size_t(m_window.height());
    constexpr std::size_t kRows = 16;  // between two checkpoints
    for (std::size_t first = 0; first < rows; first += kRows) {
        checkpoint();
        parallelFor(std::min(kRows, rows - first), [&](std::size_t r) {
            for (std::size_t i = 0; i < width; ++i) {
                const auto seen = backdrop.at((double(m_window.x0) + double(i) + 0.5) / m_antialias,
                                              (double(m_window.y0) + double(first + r) + 0.5) / m_antialias);
                std::ranges::copy(seen, m_rays[(first + r) * width + i].begin());
            }
        });
    }
}

void BackdropRays::begin(Frame& frame) const {
    FrameLayer* layer = backdropOf(frame);
    if (layer == nullptr) return;
    const PixelWindow& region = frame.image.window;
    const float share = 1.0f / float(m_antialias * m_antialias);
    layer->data.assign(4 * region.pixelCount(), 0.0f);
    float* pixel = layer->data.data();
    for (int y = region.y0; y < region.y1; ++y)
        for (int x = region.x0; x < region.x1; ++x, pixel += 4)
            for (int k = 0; k < m_antialias * m_antialias; ++k) {
                const auto& seen = ray(x * m_antialias + k % m_antialias, y * m_antialias + k / m_antialias);
                for (std::size_t c = 0; c < 4; ++c) pixel[c] += share * seen[c];
            }
}

void finishBackdrop(Frame& frame) {
    FrameLayer* layer = backdropOf(frame);
    const std::size_t pixels = frame.image.rgba.size() / 4;
    if (layer == nullptr || layer->data.size() != 4 * pixels) return;
    std::vector<float> rgb(3 * pixels);
    for (std::size_t i = 0; i < 4 * pixels; ++i) {
        const float seen = std::max(layer->data[i], 0.0f);
        float& value = frame.image.rgba[i];
        value += seen;
        if (i % 4 == 3)
            value = std::min(value, 1.0f);
        else
            rgb[i / 4 * 3 + i % 4] = seen;
    }
    layer->data = std::move(rgb);
}

}  // namespace scrim
