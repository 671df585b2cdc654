// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/noise_blocks.h>

#include <scrim/base/split_mix.h>
#include <scrim/volume/sparse_field.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "scrim/scene/noise_blocks.cpp"
#include <hwy/foreach_target.h>
#include <gradient_noise-inl.h>

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

using namespace noise_source::HWY_NAMESPACE;

HWY_ATTR void fillNoise(const NoiseOctave* octaves, std::size_t count, const Vec3& first, const Mat3& steps,
                        float* values) {
    const D d;
    const auto lanes = static_cast<int>(hn::Lanes(d));  // a power of two, at most 8
    const V ramp = hn::Iota(d, 0.0);
    for (int row = 0; row < kBlockEdge * kBlockEdge; ++row) {
        const Vec3 begin = first + steps[0] * double(row / kBlockEdge) + steps[1] * double(row % kBlockEdge);
        for (int z = 0; z < kBlockEdge; z += lanes) {
            const V along = ramp + constant(z);
            const Points place{constant(begin.x) + along * constant(steps[2].x),
                               constant(begin.y) + along * constant(steps[2].y),
                               constant(begin.z) + along * constant(steps[2].z)};
            V sum = constant(0);
            for (std::size_t i = 0; i < count; ++i) {
                const NoiseOctave& o = octaves[i];
                const V f = constant(o.frequency);
                const Cells cells = cellsAt({f * place.x, f * place.y, f * place.z});
                sum = sum + constant(o.weights[0]) * gradientNoise(cells, o.seeds[0]);
                if (o.weights[1] != 0) sum = sum + constant(o.weights[1]) * gradientNoise(cells, o.seeds[1]);
            }
            HWY_ALIGN double out[kBlockEdge];
            hn::Store(sum, d, out);
            for (int i = 0; i < lanes; ++i) values[row * kBlockEdge + z + i] = static_cast<float>(out[i]);
        }
    }
}

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scrim {
namespace {

HWY_EXPORT(fillNoise);

/// Seeds that have nothing in common.
std::uint32_t mixedSeed(std::uint64_t v) {
    return static_cast<std::uint32_t>(splitMix(v));
}

}  // namespace

NoiseBlocks::NoiseBlocks(const Noise& noise, const Mat4& placeFromIs, std::uint32_t part)
    : m_first(Vec3(placeFromIs[3]) - noise.offset), m_steps(placeFromIs) {
    const double step = std::floor(noise.evolution), fade = 0.5 * std::numbers::pi * (noise.evolution - step);
    const auto seed = [&](int octave, double at) {
        const auto k = static_cast<std::int64_t>(at);
        return mixedSeed(mixedSeed(static_cast<std::uint64_t>(k)) ^
                         (std::uint64_t(std::uint32_t(noise.seed)) << 32 | part << 8 | std::uint32_t(octave)));
    };
    double frequency = noise.frequency, amplitude = 1, all = 0;
    for (int i = 0; i < noise.octaves; ++i) {
        all += amplitude;
        m_octaves.push_back(
            {frequency, {seed(i, step), seed(i, step + 1)}, {amplitude * std::cos(fade), amplitude * std::sin(fade)}});
        amplitude *= noise.roughness;
        frequency *= noise.lacunarity;
    }
    for (NoiseOctave& octave : m_octaves)
        for (double& weight : octave.weights) weight /= all;
}

void NoiseBlocks::fill(const Int3& origin, float* values) const {
    HWY_DYNAMIC_DISPATCH(fillNoise)
    (m_octaves.data(), m_octaves.size(), m_first + m_steps * Vec3(origin), m_steps, values);
}

}  // namespace scrim
#endif
