// SPDX-License-Identifier: Apache-2.0
// Volume source `mesh`: fog in the shape of a triangle mesh.
//
//     scrim make mesh file=bunny.ply resolution=256 density=4 -o bunny.vdb
//
// Parameters (lengths in the mesh's units, which become world units):
//   file        a .obj or .ply file (text or binary); in a scene it is relative to the scene, with ${NAME} and frames
//               as in other paths. Polygons are divided into triangles; materials and everything else are left out
//   voxel       edge of a voxel; 0: the longest extent of the mesh divided by `resolution`
//   resolution  voxels along the longest extent of the mesh, where `voxel` is 0
//   density     value inside
//   soft        width of the edge, over which density falls from its full value to 0; 0: one voxel
//   fill        true: fills the inside of closed surfaces, with the edge half inside and half outside; false: shows the
//               surfaces only, as sheets that are densest in the middle and extend by `soft` to either side. An open
//               surface has no inside, and is refused where it should be filled
//
// The grid is called "density". Time and memory are proportional to the surface, since the inside consists of tiles.
#include "mesh.h"

#include <scrim/volume/scrim_source.h>

#include <algorithm>
#include <exception>
#include <new>
#include <stdexcept>

namespace mesh {
namespace {

enum { kFile, kVoxel, kResolution, kDensity, kSoft, kFill, kCount };
constexpr scrim_parameter kParameters[kCount] = {
    {"file", SCRIM_STRING, "", 0, 0, nullptr, "path of a .obj or .ply file"},
    {"voxel", SCRIM_NUMBER, "0", 0, 1e9, nullptr, "edge of a voxel, in world units; 0: from resolution"},
    {"resolution", SCRIM_INTEGER, "128", 8, 8192, nullptr, "voxels along the longest extent, where voxel is 0"},
    {"density", SCRIM_NUMBER, "1", 0, 1e6, nullptr, "value inside"},
    {"soft", SCRIM_NUMBER, "0", 0, 1e9, nullptr, "width of the edge, in world units; 0: one voxel"},
    {"fill", SCRIM_BOOL, "true", 0, 0, nullptr, "fill closed surfaces; false: only the surfaces"},
};

double longestExtent(const Mesh& mesh) {
    double longest = 0;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto [least, most] =
            std::minmax_element(mesh.points.begin(), mesh.points.end(),
                                [axis](const Point& a, const Point& b) { return a[axis] < b[axis]; });
        longest = std::max(longest, (*most)[axis] - (*least)[axis]);
    }
    return longest;
}

int run(const scrim_host* host, const scrim_value* values) {
    const std::string path = values[kFile].text;
    if (path.empty()) throw std::runtime_error("expected 'file', a .obj or .ply file");
    const bool alone = host->struct_size >= sizeof(scrim_host) && host->alone != 0;
    const Mesh mesh = readMesh(path, alone);
    if (const int stop = host->progress(host, 0.2); stop != 0) return stop;

    Fog fog;
    fog.voxel = values[kVoxel].number[0];
    if (fog.voxel <= 0) fog.voxel = longestExtent(mesh) / static_cast<double>(values[kResolution].integer);
    if (!(fog.voxel > 0)) throw std::runtime_error(path + ": all of its vertices are one point");
    fog.density = values[kDensity].number[0];
    fog.soft = values[kSoft].number[0] > 0 ? values[kSoft].number[0] : fog.voxel;
    fog.fill = values[kFill].boolean != 0;
    return emitFog(host, mesh, fog);
}

int generate(const scrim_host* host, const scrim_value* values) {
    try {
        return run(host, values);
    } catch (const std::bad_alloc&) {
        host->fail(host, "not enough memory for the mesh");
    } catch (const std::exception& error) {
        host->fail(host, error.what());
    } catch (...) {
        host->fail(host, "unknown exception");
    }
    return 1;
}

constexpr scrim_source kSource = {
    SCRIM_SOURCE_ABI, sizeof(scrim_source),    "mesh",  "fog in the shape of a triangle mesh (OBJ or PLY)", kParameters,
    kCount,           sizeof(scrim_parameter), generate};

}  // namespace
}  // namespace mesh

extern "C" SCRIM_SOURCE_EXPORT const scrim_source* scrim_source_v1(void) {
    return &mesh::kSource;
}
