// SPDX-License-Identifier: Apache-2.0
// The smoke of the source `noise`: its parameters, and its density in blocks of 8 x 8 x 8 voxels. It is separate from
// noise.cpp because it is compiled once for each instruction set.
#pragma once

#include <array>
#include <cstdint>

namespace noise_source {

constexpr int kEdge = 8;  // edge of a block, voxels
constexpr int kBlockVoxels = kEdge * kEdge * kEdge;

enum class Shape { plume, ball, slab, box, hypertexture };

/// The parameters, see noise.cpp. Lengths without a unit are fractions of `size`.
struct Settings {
    std::int64_t resolution;
    double size;  ///< world units
    Shape shape;
    double frequency;
    std::int64_t octaves;
    double lacunarity;
    double gain;
    double turbulence;
    double warp;
    double coverage;
    double softness;
    double density;
    std::uint32_t seed;
    std::array<double, 3> boxHalf;  ///< half the edges of a box
};

/// Half the extent of the box that contains the smoke.
std::array<double, 3> halfExtent(const Settings& settings);

/// Fills one block. Returns false where it is empty, and `values` is then meaningless. `origin`: its first voxel; voxel
/// centres lie at (index + 0.5) / resolution. `values`: 512 values, z fastest. Gives the same bits on every instruction
/// set, and may be called from several threads.
bool fillBlock(const Settings& settings, const std::int32_t origin[3], float* values);

}  // namespace noise_source
