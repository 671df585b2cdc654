// SPDX-License-Identifier: Apache-2.0
// Writes small .vdb files of every kind that tests need, including bad ones. OpenVDB's headers stay behind
// the .cpp, so that tests compile fast.
#pragma once

#include <scrim/geometry/spaces.h>

#include <string>
#include <vector>

namespace scrim::test {

struct MadeVoxel {
    Int3 at{0};
    double value = 1;
};

struct MadeTile {
    Int3 at{0};    ///< any voxel in the tile
    int edge = 8;  ///< 8, 128 or 4096
    double value = 1;
};

struct MadeColour {
    Int3 at{0};
    Vec3 value{1};
};

struct MadeGrid {
    std::string name = "density";
    /// float, half, double, int32, int64, bool, mask, vec3s, vec3d, vec3half, vec3i, points, or sphere: a level set of
    /// radius 10 voxels
    /// (makeNvdb: float, double, int32, bool, mask, vec3s, sphere, Fp4, Fp8, Fp16 or FpN)
    std::string type = "float";
    std::string gridClass = "fog volume";  ///< as OpenVDB spells it; "" for unknown
    std::vector<MadeVoxel> voxels{};
    std::vector<MadeColour> colours{};  ///< more voxels, of vec3 grids
    std::vector<MadeTile> tiles{};      ///< of float and double grids, and of vec3 ones
    std::vector<MadeVoxel> inactive{};  ///< values stored in voxels that are not active; float and double
    double background = 0;
    double voxelSize = 1;
    Vec3 translate{0};     ///< world position of voxel (0, 0, 0)
    bool frustum = false;  ///< instead: the transform of a camera's frustum over voxels 0 .. 16
    std::string map{};     ///< instead: some transform that OpenVDB keeps as a map of this kind, "AffineMap", ...
};

/// World volume that voxels `lower` to `upper` of a frustum grid fill, with the half voxel around them.
double frustumVolume(const MadeGrid& grid, const Int3& lower, const Int3& upper);

/// All voxels of the box [lower, upper], with one value.
std::vector<MadeVoxel> box(const Int3& lower, const Int3& upper, double value);

enum class Container { file, stream };  ///< a stream has no offsets: the outer structure cannot be checked

/// How a file is compressed.
struct Packing {
    std::string codec = "blosc";  ///< or "zip", "none"
    bool activeMask = true;       ///< most values of inactive voxels are left out
};

void makeVdb(const std::string& path, const std::vector<MadeGrid>& grids, Container container = Container::file,
             const Packing& packing = {});

/// Two grids, "density" and "copy", that share one tree, the second at another place: a file says so with an instance.
void makeVdbWithInstance(const std::string& path, const MadeGrid& density);

/// The same as a NanoVDB file, as NanoVDB's own functions make it: all in one segment, or each in its own.
enum class NanoCodec { none, zip, blosc };
enum class NanoSegments { one, each };
void makeNvdb(const std::string& path, const std::vector<MadeGrid>& grids, NanoCodec codec = NanoCodec::none,
              NanoSegments segments = NanoSegments::one);

/// A file's bytes; throws std::runtime_error.
std::string readBytes(const std::string& path);
void writeBytes(const std::string& path, const std::string& bytes);

}  // namespace scrim::test
