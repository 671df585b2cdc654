// SPDX-License-Identifier: Apache-2.0
// Volume source `noise`: procedural smoke, fog and clouds, so that there is something to render without a file.
//
// It is not a simulation. An envelope (a rising plume, a ball or a slab) gives a signed depth below the surface of
// the smoke; turbulence lifts and dents that surface, and density grows from 0 at the surface to its full value one
// `softness` below. Turbulence is a sum of octaves of gradient noise (Perlin 1985, with the quintic fade and the
// gradients of Perlin 2002), each `lacunarity` times finer and `gain` times weaker than the last:
//   billow(p) = sum_o gain^o (1 - |noise(p lacunarity^o)|) / sum_o gain^o,
// whose creases between round bulges are what one takes for convection; a smooth fBm of the same octaves thins the
// inside. Positions are displaced beforehand by a vector of two octaves of noise (domain warping), which curls the
// bulges. The plume widens with height as an entraining plume does (radius proportional to height above a virtual
// source below it; Morton, Taylor and Turner 1956), wanders sideways, roughens as it rises, and thins out at the top.
//
// Two shapes are made otherwise. A box is haze: full density, thinned by the billows of `turbulence` (0: even), with
// soft faces. A hypertexture (Perlin and Hoffert 1989) is a soft ball, full up to an inner radius ri, from where
// density falls with the square of the distance to 0 at the outer one, ro:
//   D(p) = (ro^2 - |p|^2) / (ro^2 - ri^2), clamped to [0, 1],
// looked up at p (1 + turbulence billow(p)): creases reach into the ball, and nothing ever reaches out of it.
//
// Parameters (lengths in world units; the volume is centred on the origin, y is up):
//   resolution  voxels along the longest axis
//   size        length of that axis
//   shape       plume, ball, slab, box or hypertexture
//   density     largest value
//   frequency   bulges of the coarsest octave along size
//   octaves     number of octaves; those finer than voxels are left out
//   lacunarity  how much finer the next octave is
//   gain        how much weaker the next octave is
//   turbulence  height of bulges, in parts of the radius; how much a box lacks, how deep a hypertexture's creases are
//   warp        how far positions are displaced, in bulges
//   coverage    0.5: as described; 1 fills the envelope, 0 leaves only the strongest bulges (not for hypertextures)
//   softness    depth over which density grows, in parts of the radius (of a box: of half its least edge)
//   seed        seed of the random numbers
//   proportions of a box: its edges, the longest of which is `size`
//
// Every voxel is a pure function of its place and the parameters (smoke.h), so the bytes are the same on each run and
// machine with IEEE arithmetic, whatever its vectors and the number of threads; blocks whose whole extent lies outside
// the highest possible bulge are never evaluated.
#include "smoke.h"

#include <scrim/volume/scrim_source.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <exception>
#include <iterator>
#include <string_view>
#include <vector>

#include <tbb/parallel_for.h>

namespace {

using noise_source::kBlockVoxels;
using noise_source::kEdge;
using noise_source::Settings;
using noise_source::Shape;

constexpr std::size_t kBatch = 1024;  // number of blocks that all threads fill at a time: 2 MB

struct Block {
    std::int32_t origin[3];
    bool filled;
    float values[kBlockVoxels];
};

/// Fills blocks in parallel and passes them to the host in order. Returns the host's error.
int flush(const scrim_host* host, int grid, const Settings& s, std::vector<Block>& blocks) {
    tbb::parallel_for(std::size_t{0}, blocks.size(), [&](std::size_t i) {
        blocks[i].filled = noise_source::fillBlock(s, blocks[i].origin, blocks[i].values);
    });
    for (const Block& b : blocks) {
        if (!b.filled) continue;
        // Constant blocks of haze become tiles; other shapes keep the form that they have always had.
        const bool even = s.shape == Shape::box && std::all_of(std::begin(b.values), std::end(b.values),
                                                               [&](float v) { return v == b.values[0]; });
        const int error = even ? host->add_tile(host, grid, b.origin, kEdge, b.values[0])
                               : host->add_block(host, grid, b.origin, b.values);
        if (error != 0) return error;
    }
    blocks.clear();
    return 0;
}

int emit(const scrim_host* host, const Settings& s) {
    const double voxel = s.size / static_cast<double>(s.resolution);
    const double shift = 0.5 * voxel;
    const double worldFromIndex[16] = {voxel, 0, 0, shift, 0, voxel, 0, shift, 0, 0, voxel, shift, 0, 0, 0, 1};
    const int grid = host->add_grid(host, "density", worldFromIndex);
    if (grid < 0) return grid;

    const std::array<double, 3> half = noise_source::halfExtent(s);
    const auto blocksOf = [&](double length) {
        return static_cast<std::int32_t>(std::ceil(length * static_cast<double>(s.resolution) / kEdge));
    };
    const std::int32_t nx = blocksOf(half[0]), ny = blocksOf(half[1]), nz = blocksOf(half[2]);
    std::vector<Block> blocks;
    blocks.reserve(kBatch);
    for (std::int32_t bx = -nx; bx < nx; ++bx) {
        for (std::int32_t by = -ny; by < ny; ++by)
            for (std::int32_t bz = -nz; bz < nz; ++bz) {
                Block& b = blocks.emplace_back();
                b.origin[0] = kEdge * bx;
                b.origin[1] = kEdge * by;
                b.origin[2] = kEdge * bz;
                if (blocks.size() < kBatch) continue;
                if (const int error = flush(host, grid, s, blocks); error != 0) return error;
            }
        if (const int stop = host->progress(host, double(bx + nx + 1) / (2 * nx)); stop != 0) return stop;
    }
    return flush(host, grid, s, blocks);
}

// `kParameters` and the reads in `generate` have the same order.
constexpr scrim_parameter kParameters[] = {
    {"resolution", SCRIM_INTEGER, "128", 8, 4096, nullptr, "voxels along the longest axis"},
    {"size", SCRIM_NUMBER, "2", 1e-6, 1e9, nullptr, "length of the longest axis, in world units"},
    {"shape", SCRIM_STRING, "plume", 0, 0, "plume|ball|slab|box|hypertexture", "shape that the smoke fills"},
    {"frequency", SCRIM_NUMBER, "5", 0.1, 1000, nullptr, "number of bulges of the coarsest octave along the size"},
    {"octaves", SCRIM_INTEGER, "5", 1, 16, nullptr, "octaves of turbulence"},
    {"lacunarity", SCRIM_NUMBER, "2.1", 1, 10, nullptr, "how much finer each octave is than the last"},
    {"gain", SCRIM_NUMBER, "0.5", 0, 1, nullptr, "how much weaker each octave is than the last"},
    {"turbulence", SCRIM_NUMBER, "1.6", 0, 10, nullptr, "height of bulges, in parts of the radius"},
    {"warp", SCRIM_NUMBER, "0.35", 0, 2, nullptr, "how far positions are displaced, in bulges"},
    {"coverage", SCRIM_NUMBER, "0.5", 0, 1, nullptr, "1 fills the envelope, 0 leaves the strongest bulges"},
    {"softness", SCRIM_NUMBER, "0.35", 1e-3, 10, nullptr, "depth over which density grows, in parts of the radius"},
    {"density", SCRIM_NUMBER, "1", 0, 1e6, nullptr, "largest value"},
    {"seed", SCRIM_INTEGER, "1", 0, 1e9, nullptr, "seed of the random numbers"},
    {"proportions", SCRIM_VEC3, "1, 1, 1", 1e-3, 1e3, nullptr, "of a box: its edges, the longest of which is size"},
};

Settings read(const scrim_value* v) {
    Settings s{};
    s.resolution = v[0].integer;
    s.size = v[1].number[0];
    const std::string_view shape = v[2].text;  // one of the words below, in the order of the enumeration
    constexpr std::array<std::string_view, 5> kShapes{"plume", "ball", "slab", "box", "hypertexture"};
    s.shape = static_cast<Shape>(std::find(kShapes.begin(), kShapes.end(), shape) - kShapes.begin());
    s.frequency = v[3].number[0];
    s.octaves = v[4].integer;
    s.lacunarity = v[5].number[0];
    s.gain = v[6].number[0];
    s.turbulence = v[7].number[0];
    s.warp = v[8].number[0];
    s.coverage = v[9].number[0];
    s.softness = v[10].number[0];
    s.density = v[11].number[0];
    s.seed = static_cast<std::uint32_t>(v[12].integer);
    const double* edges = v[13].number;
    const double scale = 0.5 / std::max({edges[0], edges[1], edges[2]});
    s.boxHalf = {scale * edges[0], scale * edges[1], scale * edges[2]};
    return s;
}

int generate(const scrim_host* host, const scrim_value* values) {
    try {
        return emit(host, read(values));
    } catch (const std::exception& error) {
        host->fail(host, error.what());
    } catch (...) {
        host->fail(host, "unknown exception");
    }
    return 1;
}

constexpr scrim_source kSource = {SCRIM_SOURCE_ABI,
                                  sizeof(scrim_source),
                                  "noise",
                                  "procedural smoke and haze: plume, ball, slab, box or hypertexture",
                                  kParameters,
                                  sizeof kParameters / sizeof kParameters[0],
                                  sizeof(scrim_parameter),
                                  generate};

}  // namespace

extern "C" SCRIM_SOURCE_EXPORT const scrim_source* scrim_source_v1(void) {
    return &kSource;
}
