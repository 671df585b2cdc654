// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/shade/surface.h>

#include <scrim/engine/splat/plane_sampling.h>

#include <algorithm>
#include <cmath>

#include <glm/matrix.hpp>

namespace scrim {
namespace {

// Values at the samples, moved by (du, dv) texels.
void sampleMoved(const float* plane, const ValuePlanes& planes, const SampleTile& samples, float du, float dv,
                 float* out) {
    alignas(64) float u[kTileSize], v[kTileSize];
    for (int k = 0; k < kTileSize; ++k) {
        u[k] = samples.u[k] + du;
        v[k] = samples.v[k] + dv;
    }
    samplePoints({plane, planes.width, planes.height, 0, 0, planes.simd}, u, v, false, kTileSize, out);
}

// Values where the eye's rays cross a plane `steps` sheets away.
void sampleAlongRays(const float* plane, const ValuePlanes& planes, const SampleTile& samples, float steps,
                     float* out) {
    alignas(64) float u[kTileSize], v[kTileSize];
    for (int k = 0; k < kTileSize; ++k) {
        u[k] = samples.u[k] + steps * samples.eyeA[k];
        v[k] = samples.v[k] + steps * samples.eyeB[k];
    }
    samplePoints({plane, planes.width, planes.height, 0, 0, planes.simd}, u, v, false, kTileSize, out);
}

void sampleRun(const ValuePlanes& planes, const SampleTile& samples, const Sheets& sheets, ClassifiedTile& run) {
    const auto texelsPerSlope = static_cast<float>(sheets.thickness / sheets.texel);
    sampleAlongRays(planes.at(-1), planes, samples, -texelsPerSlope, run.front);
    sampleAlongRays(planes.at(0), planes, samples, 0, run.middle);
    sampleAlongRays(planes.at(1), planes, samples, texelsPerSlope, run.back);
    for (int k = 0; k < kTileSize; ++k) {
        const SheetRun through = runThroughSheet(run.front[k], run.middle[k], run.back[k]);
        run.front[k] = through.front;
        run.middle[k] = through.middle;
        run.back[k] = through.back;
    }
}

// Values at the samples moved by `tsOffset`: between planes, linearly.
void sampleBetween(const ValuePlanes& planes, const SampleTile& samples, const Vec3& tsOffset, float* out) {
    const auto du = static_cast<float>(tsOffset.x), dv = static_cast<float>(tsOffset.y);
    const int whole = static_cast<int>(std::floor(tsOffset.z));
    const auto fraction = static_cast<float>(tsOffset.z - whole);
    sampleMoved(planes.at(whole), planes, samples, du, dv, out);
    if (fraction == 0) return;
    alignas(64) float further[kTileSize];
    sampleMoved(planes.at(whole + 1), planes, samples, du, dv, further);
    for (int k = 0; k < kTileSize; ++k) out[k] += fraction * (further[k] - out[k]);
}

}  // namespace

GradientStep gradientStep(const Mat4& rsFromIs, const Mat3& ssFromWs, const Mat4& wsFromIs) {
    GradientStep step;
    for (int axis = 0; axis < 3; ++axis) {
        step.rsVoxel[axis] = Vec3(rsFromIs[axis]);
        step.reach = std::max(step.reach, static_cast<int>(std::ceil(std::abs(rsFromIs[axis].z))));
    }
    // A gradient is a covector: differences go with the inverse transpose.
    step.ssFromDifference = ssFromWs * (0.5 * glm::transpose(glm::inverse(Mat3(wsFromIs))));
    return step;
}

bool classifyExtinction(const ValuePlanes& planes, const SampleTile& samples, const Sheets& sheets,
                        const TransferTable& table, ClassifiedTile& out) {
    sampleRun(planes, samples, sheets, out);
    float low = out.front[0], high = low;
    for (const float* values : {out.front, out.middle, out.back})
        for (int k = 0; k < kTileSize; ++k) {
            low = std::min(low, values[k]);
            high = std::max(high, values[k]);
        }
    if (!table.anyBetween(low, high)) {
        std::fill(out.extinction, out.extinction + kTileSize, 0.0f);
        return false;
    }
    table.meanExtinction(out.front, out.middle, out.back, kTileSize, out.extinction, planes.simd);
    return std::any_of(out.extinction, out.extinction + kTileSize, [](float sigma) { return sigma > 0; });
}

void classifySurface(const ValuePlanes& planes, const SampleTile& samples, const GradientStep& step,
                     double vagueGradient, const TransferTable& table, ClassifiedTile& out) {
    for (int c = 0; c < 3; ++c)
        table.meanEmission(c, out.front, out.middle, out.back, kTileSize, out.emission[c], planes.simd);

    alignas(64) float lower[kTileSize], upper[kTileSize];
    for (float* axis : out.normal) std::fill(axis, axis + kTileSize, 0.0f);
    for (int axis = 0; axis < 3; ++axis) {
        sampleBetween(planes, samples, -step.rsVoxel[axis], lower);
        sampleBetween(planes, samples, step.rsVoxel[axis], upper);
        for (int c = 0; c < 3; ++c) {
            // Out of the denser side: down the gradient. In units of the vague one: squares of gradients neither
            // overflow nor vanish, whatever the units of the field and the size of its voxels.
            const auto part = static_cast<float>(-step.ssFromDifference[axis][c] / vagueGradient);
            for (int k = 0; k < kTileSize; ++k) out.normal[c][k] += part * (upper[k] - lower[k]);
        }
    }
    for (int k = 0; k < kTileSize; ++k) {
        float *x = out.normal[0] + k, *y = out.normal[1] + k, *z = out.normal[2] + k;
        const float g2 = *x * *x + *y * *y + *z * *z;
        out.weight[k] = g2 / (g2 + 1);
        const float inverse = 1 / std::sqrt(std::max(g2, 1e-30f));  // a gradient of 0 has no weight
        *x *= inverse;
        *y *= inverse;
        *z *= inverse;
    }
}

}  // namespace scrim
