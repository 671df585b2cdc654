// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/shade/screen_motion.h>

#include <algorithm>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

// The map to homogeneous raster positions: w is 1 for an orthographic camera, and depth for a perspective one.
Mat4 rasterFromWs(const Camera& camera) {
    const RayFamily rays = wsRays(camera);
    const bool parallel = camera.type == CameraType::orthographic;
    const Mat3 ways = parallel ? Mat3(rays.originX, rays.originY, rays.direction0)
                               : Mat3(rays.directionX, rays.directionY, rays.direction0);
    const Mat3 toRaster = glm::inverse(ways);
    const Vec3 shift = -(toRaster * rays.origin0);
    Mat4 out(0.0);
    for (int column = 0; column < 4; ++column) {
        const Vec3 own = column < 3 ? toRaster[column] : shift;
        out[column] = {own.x, own.y, 0, parallel ? (column == 3 ? 1.0 : 0.0) : own.z};
    }
    return out;
}

Mat4 wsFromTs(const Sheets& sheets) {
    return glm::inverse(sheets.tsFrom(Mat4(1.0)));
}

}  // namespace

struct ScreenMotion::Volume {
    Mat4 rasterFromTs;    // at the next frame
    Mat4 rasterFromFlow;  // change for each unit of velocity
    Vec3 least, most;     // range of the velocity grid
};

ScreenMotion::~ScreenMotion() = default;

ScreenMotion::ScreenMotion(const ViewScene& scene, const Sheets& sheets) {
    const Mat4 fromTs = wsFromTs(sheets);
    const Mat4 now = rasterFromWs(scene.camera), next = rasterFromWs(scene.nextCamera.value_or(scene.camera));
    m_rasterFromTs = now * fromTs;
    for (const ViewVolume& volume : scene.volumes) {
        const VolumeMotion still;
        const VolumeMotion& motion = volume.motion ? *volume.motion : still;
        Volume& out = m_volumes.emplace_back();
        out.rasterFromTs = next * motion.wsNextFromWs * fromTs;
        out.rasterFromFlow = Mat4(0.0);
        for (int axis = 0; axis < 3; ++axis)
            out.rasterFromFlow[axis] = next * glm::dvec4(motion.wsPerVelocity[axis], 0.0);
        out.least = motion.least;
        out.most = motion.most;
    }
}

void ScreenMotion::fill(double middle, const SampleTile& samples, std::span<const Part> parts, Real* right,
                        Real* up) const {
    for (int k = 0; k < kTileSize; ++k) {
        const glm::dvec4 ts(samples.u[k], samples.v[k], middle, 1);
        const glm::dvec4 now = m_rasterFromTs * ts;
        double x = 0, y = 0, weight = 0;
        for (const Part& part : parts) {
            const double extinction = part.extinction[k];
            if (!(extinction > 0) || !(now.w > 0)) continue;
            const Volume& volume = m_volumes[std::size_t(part.sceneVolume)];
            glm::dvec4 next = volume.rasterFromTs * ts;
            for (int axis = 0; axis < 3 && part.flow[0]; ++axis) {
                // The planes were sharpened, so their quotient may slightly exceed the range of the grid.
                const double more = part.flow[std::size_t(axis)][k] / extinction;
                next += std::clamp(volume.least[axis] + more, volume.least[axis], volume.most[axis]) *
                        volume.rasterFromFlow[axis];
            }
            for (int axis = 0; axis < 3 && part.velocity[0]; ++axis)
                next += double(part.velocity[std::size_t(axis)][k]) * volume.rasterFromFlow[axis];
            if (!(next.w > 0)) continue;
            x += extinction * (next.x / next.w - now.x / now.w);
            y += extinction * (next.y / next.w - now.y / now.w);
            weight += extinction;
        }
        // Raster rows count downwards.
        right[k] = static_cast<Real>(weight > 0 ? x / weight : 0);
        up[k] = static_cast<Real>(weight > 0 ? -y / weight : 0);
    }
}

}  // namespace scrim
