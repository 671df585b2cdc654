// SPDX-License-Identifier: Apache-2.0
#include <scrim/render/eye_view.h>

#include <algorithm>

#include <glm/matrix.hpp>

namespace scrim {

EyeView::EyeView(const Camera& camera, const Sheets& sheets)
    : m_orthographic(camera.type == CameraType::orthographic) {
    const RayFamily ws = wsRays(camera);
    m_ts.near = ws.near;
    m_ts.origin0 = sheets.tsPoint(ws.origin0);
    m_ts.originX = sheets.tsVector(ws.originX);
    m_ts.originY = sheets.tsVector(ws.originY);
    m_ts.direction0 = sheets.tsVector(ws.direction0);
    m_ts.directionX = sheets.tsVector(ws.directionX);
    m_ts.directionY = sheets.tsVector(ws.directionY);
    if (m_orthographic)
        m_rasterFromOffset = glm::inverse(Mat3(m_ts.originX, m_ts.originY, m_ts.direction0));
    else
        m_rasterFromOffset = glm::inverse(Mat3(m_ts.directionX, m_ts.directionY, m_ts.direction0));

    const double toSlope = sheets.texel / sheets.thickness;
    m_slopes.parallel = m_orthographic;
    m_slopes.a = m_ts.direction0.x / m_ts.direction0.z * toSlope;
    m_slopes.b = m_ts.direction0.y / m_ts.direction0.z * toSlope;
    m_slopes.tsEye = m_ts.origin0;
}

PixelRay EyeView::ray(double x, double y, double reference) const {
    const Vec3 o = m_ts.origin(x, y), d = m_ts.direction(x, y);
    const double slopeU = d.x / d.z, slopeV = d.y / d.z;
    const double away = reference - o.z;
    return {o.x + slopeU * away, o.y + slopeV * away, slopeU, slopeV, o.z + m_ts.near * d.z};
}

// In double, because an eye may be far away; simple enough for the compiler to vectorise.
RayTile EyeView::rays(int x0, int y0, double reference) const {
    RayTile tile;
    for (int j = 0; j < kTileEdge; ++j) {
        const Vec3 o = m_ts.origin(x0 + 0.5, y0 + j + 0.5), d = m_ts.direction(x0 + 0.5, y0 + j + 0.5);
        const Vec3 ox = m_ts.originX, dx = m_ts.directionX;
        const double near = m_ts.near;
        for (int i = 0; i < kTileEdge; ++i) {
            const int k = j * kTileEdge + i;
            const double originN = o.z + i * ox.z, directionN = d.z + i * dx.z;
            const double inverse = 1 / directionN, away = reference - originN;
            const double slopeU = (d.x + i * dx.x) * inverse, slopeV = (d.y + i * dx.y) * inverse;
            tile.u[k] = static_cast<float>(o.x + i * ox.x + slopeU * away);
            tile.v[k] = static_cast<float>(o.y + i * ox.y + slopeV * away);
            tile.stepU[k] = static_cast<float>(slopeU);
            tile.stepV[k] = static_cast<float>(slopeV);
            tile.startN[k] = static_cast<float>(near * directionN - away);
        }
    }
    return tile;
}

std::optional<EyeView::Box> EyeView::seenBy(double u0, double v0, double u1, double v1, double middle) const {
    Box box{1e30, 1e30, -1e30, -1e30};
    for (const double u : {u0, u1})
        for (const double v : {v0, v1}) {
            Vec3 p = m_rasterFromOffset * (Vec3(u, v, middle) - m_ts.origin0);
            if (!m_orthographic) {
                if (p.z <= 0) return std::nullopt;  // behind the eye: (x t, y t, t) with t <= 0
                p.x /= p.z;
                p.y /= p.z;
            }
            box = {std::min(box.x0, p.x), std::min(box.y0, p.y), std::max(box.x1, p.x), std::max(box.y1, p.y)};
        }
    return box;
}

}  // namespace scrim
