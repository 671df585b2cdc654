// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/light/solid_shadow.h>

#include <scrim/base/parallel.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

namespace scrim {
namespace {

// A ray lights sheet n if it ends at N >= n + pastSheet.
//
// A surface that hides what is behind it ends the eye's ray at the same place as the light's. The eye's ray then
// already determines how much of the sheet counts, and the light must not reduce it once more. If eye and light are on
// the same side of the surface, a sheet is lit if any part of it is, and so is one more sheet, since texels behind the
// surface are looked up together with those in front of it. If the surface lies between them, the side that the eye
// sees is dark, and so is the space next to it. Thus the look of a surface does not depend on the positions of the
// sheets. A surface that does not hide casts shadows from the middle of a sheet on.
double pastSheet(const SolidHit& hit, const Vec3& wsLight, const Vec3& wsEye) {
    if (!hit.hides) return 0.5;
    return glm::dot(hit.wsNormal, wsLight) * glm::dot(hit.wsNormal, wsEye) > 0 ? -1 : 2;
}

// The direction of the eye's ray to a point.
Vec3 eyeTo(const Vec3& ws, const Camera& camera) {
    return camera.type == CameraType::orthographic ? viewingAxis(camera) : ws - camera.wsPosition;
}

}  // namespace

SolidShadow::SolidShadow(const Solids& solids, const LightView& view, const Sheets& sheets, const Camera& camera)
    : m_view(view) {
    constexpr double kInfinity = std::numeric_limits<double>::infinity();
    m_hits.resize(std::size_t(view.width) * std::size_t(view.height));
    const Vec3 wsSource = sheets.wsPoint(view.tsSource);
    parallelFor(std::size_t(view.height), [&](std::size_t y) {
        for (int x = 0; x < view.width; ++x) {
            const double a = view.first.x + x * view.cell, b = view.first.y + double(y) * view.cell;
            // N is the parameter of a distant light's ray; for other lights the parameter is N minus that of the
            // source.
            const Vec3 origin = view.distant ? sheets.wsPoint({a, b, 0}) : wsSource;
            const Vec3 along = view.distant ? sheets.wsPoint({a + view.tsSource.x, b + view.tsSource.y, 1}) - origin
                                            : sheets.wsPoint(view.tsSource + Vec3(a, b, 1)) - wsSource;
            const SolidHit hit =
                solids.trace(SolidRole::shadow, origin, along, view.distant ? -kInfinity : 0, kInfinity);
            const double past = hit.t < kInfinity ? pastSheet(hit, along, eyeTo(origin + hit.t * along, camera)) : 0;
            m_hits[y * std::size_t(view.width) + std::size_t(x)] =
                static_cast<float>(hit.t + (view.distant ? 0 : view.tsSource.z) - past);
        }
    });
}

void SolidShadow::multiply(int n, const Real* u, const Real* v, Real* light) const {
    if (!m_view.reaches(n)) return;
    const LightView::Cells map = m_view.at(n);
    const auto scale = static_cast<float>(1 / map.scale);
    const auto shiftU = static_cast<float>(-map.offsetU / map.scale),
               shiftV = static_cast<float>(-map.offsetV / map.scale);
    const auto sheet = static_cast<float>(n);
    const auto lastX = static_cast<float>(m_view.width - 2), lastY = static_cast<float>(m_view.height - 2);
    for (int k = 0; k < kTileSize; ++k) {
        const float x = std::clamp(static_cast<float>(u[k]) * scale + shiftU, 0.0f, lastX);
        const float y = std::clamp(static_cast<float>(v[k]) * scale + shiftV, 0.0f, lastY);
        const auto column = static_cast<int>(x), row = static_cast<int>(y);
        const float* at = m_hits.data() + std::size_t(row) * std::size_t(m_view.width) + std::size_t(column);
        const auto lit = [sheet](float end) { return end >= sheet ? 1.0f : 0.0f; };
        const float fx = x - static_cast<float>(column), fy = y - static_cast<float>(row);
        const float upper = lit(at[0]) + fx * (lit(at[1]) - lit(at[0]));
        const float* below = at + m_view.width;
        const float lower = lit(below[0]) + fx * (lit(below[1]) - lit(below[0]));
        light[k] *= upper + fy * (lower - upper);
    }
}

}  // namespace scrim
