// SPDX-License-Identifier: Apache-2.0
#include "dense_marcher.h"

#include <scrim/base/parallel.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim::bench {
namespace {

constexpr int kMargin = 2;
constexpr float kInverseFourPi = 0.0795774715f;
constexpr float kLeastTransmittance = 1e-3f;

// (1 - e^-t) / t without expm1, which is slow: its series where the quotient would lose digits.
float psi(float t) {
    return t < 1e-2f ? 1 - t * (0.5f - t * (1.0f / 6)) : (1 - std::exp(-t)) / t;
}

}  // namespace

DenseMarcher::DenseMarcher(const ViewScene& scene) : m_scene(scene) {
    const ViewVolume& volume = scene.volumes.front();
    const SparseField& field = *volume.field;
    const Bounds is = field.isBounds();
    m_isOrigin = is.lower - double(kMargin);
    for (int a = 0; a < 3; ++a) {
        m_size[a] = static_cast<int>(is.upper[a] - is.lower[a]) + 1 + 2 * kMargin;
        m_blocks[a] = (m_size[a] + 7) / 8;
    }
    const auto sizeX = static_cast<std::size_t>(m_size[0]), sizeY = static_cast<std::size_t>(m_size[1]),
               sizeZ = static_cast<std::size_t>(m_size[2]);
    m_values.assign(sizeX * sizeY * sizeZ, 0.0f);
    const float scale = static_cast<float>(volume.medium.densityScale * glm::length(Vec3(volume.wsFromIs[0])));
    for (std::size_t b = 0; b < field.blockCount(); ++b) {
        const Int3 at = field.blockOrigins[b] - Int3(m_isOrigin);
        for (int i = 0; i < kBlockVoxels; ++i) {
            const auto x = static_cast<std::size_t>(at.x + (i >> 6)), y = static_cast<std::size_t>(at.y + (i >> 3 & 7)),
                       z = static_cast<std::size_t>(at.z + (i & 7));
            m_values[(x * sizeY + y) * sizeZ + z] = field.block(b)[i] * scale;
        }
    }
    // A block is occupied where it or the voxel around it is not empty.
    m_occupied.assign(static_cast<std::size_t>(m_blocks[0]) * static_cast<std::size_t>(m_blocks[1]) *
                          static_cast<std::size_t>(m_blocks[2]),
                      0);
    for (int x = 0; x < m_size[0]; ++x)
        for (int y = 0; y < m_size[1]; ++y)
            for (int z = 0; z < m_size[2]; ++z) {
                if (m_values[(static_cast<std::size_t>(x) * sizeY + static_cast<std::size_t>(y)) * sizeZ +
                             static_cast<std::size_t>(z)] == 0)
                    continue;
                for (int bx = std::max(0, x - 1) / 8; bx <= (x + 1) / 8 && bx < m_blocks[0]; ++bx)
                    for (int by = std::max(0, y - 1) / 8; by <= (y + 1) / 8 && by < m_blocks[1]; ++by)
                        for (int bz = std::max(0, z - 1) / 8; bz <= (z + 1) / 8 && bz < m_blocks[2]; ++bz)
                            m_occupied[static_cast<std::size_t>((bx * m_blocks[1] + by) * m_blocks[2] + bz)] = 1;
            }
    const Vec3 light = glm::normalize(glm::inverse(Mat3(volume.wsFromIs)) * -scene.lights.front().wsDirection);
    for (int a = 0; a < 3; ++a) m_toLight[a] = static_cast<float>(light[a]);
}

// Trilinear; the position must lie inside of the array.
float DenseMarcher::value(float x, float y, float z) const {
    const int ix = static_cast<int>(x), iy = static_cast<int>(y), iz = static_cast<int>(z);
    const float fx = x - static_cast<float>(ix), fy = y - static_cast<float>(iy), fz = z - static_cast<float>(iz);
    const std::ptrdiff_t strideY = m_size[2], strideX = strideY * m_size[1];
    const float* v = m_values.data() + ix * strideX + iy * strideY + iz;
    const auto along = [&](const float* p) { return p[0] + fz * (p[1] - p[0]); };
    const float a = along(v), b = along(v + strideY), c = along(v + strideX), d = along(v + strideX + strideY);
    const float ab = a + fy * (b - a), cd = c + fy * (d - c);
    return ab + fx * (cd - ab);
}

bool DenseMarcher::occupied(float x, float y, float z) const {
    return m_occupied[static_cast<std::size_t>((static_cast<int>(x) / 8 * m_blocks[1] + static_cast<int>(y) / 8) *
                                                   m_blocks[2] +
                                               static_cast<int>(z) / 8)] != 0;
}

// Is a block occupied that lies within two voxels of this position?
bool DenseMarcher::occupiedAround(const float* p) const {
    for (int i = 0; i < 8; ++i) {
        float q[3];
        for (int a = 0; a < 3; ++a)
            q[a] = std::clamp(p[a] + (i >> a & 1 ? 2.0f : -2.0f), 0.0f, static_cast<float>(m_size[a]) - 1.001f);
        if (occupied(q[0], q[1], q[2])) return true;
    }
    return false;
}

float DenseMarcher::exitOfBlock(const float* p, const float* d) {
    float exit = 1e30f;
    for (int a = 0; a < 3; ++a) {
        if (d[a] == 0) continue;
        const float block = std::floor(p[a] / 8) * 8;
        exit = std::min(exit, ((d[a] > 0 ? block + 8 : block) - p[a]) / d[a]);
    }
    return std::max(exit, 0.0f) + 1e-3f;
}

float DenseMarcher::shadowTau(float x, float y, float z, float step) const {
    float p[3] = {x, y, z}, tau = 0;
    float t = 0.5f * step;
    const auto inside = [&] {
        return p[0] >= 0 && p[1] >= 0 && p[2] >= 0 && p[0] < static_cast<float>(m_size[0] - 1) &&
               p[1] < static_cast<float>(m_size[1] - 1) && p[2] < static_cast<float>(m_size[2] - 1);
    };
    for (;;) {
        p[0] = x + t * m_toLight[0];
        p[1] = y + t * m_toLight[1];
        p[2] = z + t * m_toLight[2];
        if (!inside() || tau > 12) return tau;
        if (!occupied(p[0], p[1], p[2])) {
            // Whole steps, so that samples stay where they would have been.
            t += std::ceil(exitOfBlock(p, m_toLight) / step) * step;
            continue;
        }
        tau += step * value(p[0], p[1], p[2]);
        t += step;
    }
}

template <class TauIn>
Image DenseMarcher::march(double stepSize, const TauIn& tauIn) const {
    Image image = emptyImage(m_scene.region);
    const RayFamily rays = wsRays(m_scene.camera);
    const ViewVolume& volume = m_scene.volumes.front();
    const Mat4 isFromWs = glm::inverse(volume.wsFromIs);
    const Light& light = m_scene.lights.front();
    const float step = static_cast<float>(stepSize);
    parallelFor(static_cast<std::size_t>(image.window.height()), [&](std::size_t row) {
        const int y = image.window.y0 + static_cast<int>(row);
        for (int x = image.window.x0; x < image.window.x1; ++x) {
            const Vec3 o = transformPoint(isFromWs, rays.origin(x + 0.5, y + 0.5)) - m_isOrigin;
            const Vec3 d = glm::normalize(transformVector(isFromWs, rays.direction(x + 0.5, y + 0.5)));
            double begin = 0, end = 1e30;
            for (int a = 0; a < 3; ++a) {
                const double t0 = (0.5 - o[a]) / d[a], t1 = (m_size[a] - 1.5 - o[a]) / d[a];
                begin = std::max(begin, std::min(t0, t1));
                end = std::min(end, std::max(t0, t1));
            }
            if (begin >= end) continue;
            const Vec3 entry = o + begin * d;
            const float e[3] = {static_cast<float>(entry.x), static_cast<float>(entry.y), static_cast<float>(entry.z)};
            const float dir[3] = {static_cast<float>(d.x), static_cast<float>(d.y), static_cast<float>(d.z)};
            const float length = static_cast<float>(end - begin);
            float transmittance = 1, radiance = 0;
            for (float t = 0.5f * step; t < length && transmittance > kLeastTransmittance;) {
                const float p[3] = {e[0] + t * dir[0], e[1] + t * dir[1], e[2] + t * dir[2]};
                if (!occupied(p[0], p[1], p[2])) {
                    t += std::ceil(exitOfBlock(p, dir) / step) * step;
                    continue;
                }
                const float sigma = value(p[0], p[1], p[2]);
                if (sigma > 0) {
                    const float tau = sigma * step;
                    radiance += transmittance * tau * psi(tau) * std::exp(-tauIn(p[0], p[1], p[2]));
                    transmittance *= std::exp(-tau);
                }
                t += step;
            }
            float* pixel = image.rgba.data() + image.indexOf(x, y);
            for (int c = 0; c < 3; ++c)
                pixel[c] = radiance * kInverseFourPi * static_cast<float>(light.intensity[c] * volume.medium.albedo[c]);
            pixel[3] = 1 - transmittance;
        }
    });
    return image;
}

Image DenseMarcher::withShadowRays(double step, double shadowStep) const {
    const float s = static_cast<float>(shadowStep);
    return march(step, [&](float x, float y, float z) { return shadowTau(x, y, z, s); });
}

// Optical depth towards the light at every cell's middle. (Carrying light from slice to slice is faster by far, but
// blurs shadows at each slice: sweep_marcher.h.)
struct DenseMarcher::LightVolume {
    int size[3];
    std::vector<float> tau;
    float perVoxel;  // cells

    float at(float x, float y, float z) const {
        const float p[3] = {x * perVoxel, y * perVoxel, z * perVoxel};
        int i[3];
        float f[3];
        for (int a = 0; a < 3; ++a) {
            const float c = std::clamp(p[a] + 0.5f * perVoxel - 0.5f, 0.0f, static_cast<float>(size[a]) - 1.001f);
            i[a] = static_cast<int>(c);
            f[a] = c - static_cast<float>(i[a]);
        }
        const std::ptrdiff_t strideY = size[2], strideX = strideY * size[1];
        const float* v = tau.data() + i[0] * strideX + i[1] * strideY + i[2];
        const auto along = [&](const float* q) { return q[0] + f[2] * (q[1] - q[0]); };
        const float a = along(v), b = along(v + strideY), c = along(v + strideX), d = along(v + strideX + strideY);
        const float ab = a + f[1] * (b - a), cd = c + f[1] * (d - c);
        return ab + f[0] * (cd - ab);
    }
};

DenseMarcher::LightVolume DenseMarcher::fillLight(int coarseness, float shadowStep) const {
    LightVolume light;
    light.perVoxel = 1.0f / static_cast<float>(coarseness);
    for (int a = 0; a < 3; ++a) light.size[a] = (m_size[a] + coarseness - 1) / coarseness + 1;
    const std::size_t strideY = static_cast<std::size_t>(light.size[2]);
    const std::size_t strideX = strideY * static_cast<std::size_t>(light.size[1]);
    light.tau.assign(strideX * static_cast<std::size_t>(light.size[0]), 0.0f);
    const auto limit = [&](int cell, int axis) {  // a cell's middle, in voxels, inside of the array
        const float middle = (static_cast<float>(cell) + 0.5f) * static_cast<float>(coarseness) - 0.5f;
        return std::clamp(middle, 0.0f, static_cast<float>(m_size[axis]) - 1.001f);
    };
    parallelFor(static_cast<std::size_t>(light.size[0]), [&](std::size_t x) {
        for (int y = 0; y < light.size[1]; ++y)
            for (int z = 0; z < light.size[2]; ++z) {
                const float p[3] = {limit(static_cast<int>(x), 0), limit(y, 1), limit(z, 2)};
                // Cells that no sample looks at are left out: those around which a block is empty.
                if (!occupied(p[0], p[1], p[2]) && !occupiedAround(p)) continue;
                light.tau[x * strideX + static_cast<std::size_t>(y) * strideY + static_cast<std::size_t>(z)] =
                    shadowTau(p[0], p[1], p[2], shadowStep);
            }
    });
    return light;
}

Image DenseMarcher::withLightVolume(double step, int coarseness, double shadowStep) const {
    const LightVolume light = fillLight(coarseness, static_cast<float>(shadowStep));
    return march(step, [&](float x, float y, float z) { return light.at(x, y, z); });
}

}  // namespace scrim::bench
