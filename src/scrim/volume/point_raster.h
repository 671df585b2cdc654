// SPDX-License-Identifier: Apache-2.0
// Turns points into voxels. Each point is a ball; where its ball is smaller than voxels, the
// nearest of these share its weight so that its sum and its centre stay. The sum over all voxels,
// times their volume, does not depend on their edge. Only blocks that a ball touches exist.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/geometry/bounds.h>
#include <scrim/volume/block_memory.h>
#include <scrim/volume/field_builder.h>
#include <scrim/volume/grid_request.h>
#include <scrim/volume/point_cloud.h>

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

namespace scrim {

/// A ball in index space.
struct PointStamp {
    Vec3 is{0};
    float radius = 0;         ///< in voxels
    float norm = 1;           ///< one over the sum of its voxels' parts
    std::uint32_t point = 0;  ///< index into the cloud
};

/// Stamps by the blocks that they touch.
struct PointBlocks {
    std::vector<PointStamp> stamps;
    std::vector<Int3> origins;            ///< in ascending order
    std::vector<std::uint32_t> touching;  ///< indices of stamps, block by block, ascending in each
    std::vector<std::size_t> first;       ///< into `touching`: of each block, and of the end
};

/// The attribute that holds the radii of points, and the factor on it: `pscale`, `radius`, or half
/// of `width`. No value where they have none.
struct PointRadii {
    const PointAttribute* attribute;
    double scale;
};
std::optional<PointRadii> ownRadii(const PointCloud& cloud);

class PointRaster {
  public:
    /// `where` (the file) starts every message and error. Points whose numbers are not finite are left out with a
    /// warning. Throws Error(input) where voxels are too small for the places or the number of points.
    /// `listed`: lists of the points are wanted, too. Voxels then need not show points that are far apart.
    PointRaster(PointCloud cloud, const PointLook& look, const std::string& where, const MessageSink& messages,
                bool listed = false);

    const PointCloud& cloud() const { return m_cloud; }
    /// True if the eye sees the points themselves, so that lists of them are not empty.
    bool sharp() const { return m_sharp; }
    const Mat4& wsFromIs() const { return m_wsFromIs; }

    /// The points as they are; or as wide as needed by a velocity, which must be known wherever
    /// they pass between PointLook::open and close (null: they do not move).
    PointBlocks blocks() const;
    PointBlocks blocksOnWay(const PointAttribute* velocity) const;

    /// Sums over the points that touch a voxel.
    struct Sums {
        std::array<float, kBlockVoxels> density;
        std::array<std::array<float, kBlockVoxels>, 3> means;  ///< of the attribute; 0 where no point is
    };
    /// `attribute` may be null.
    void fill(const PointBlocks& blocks, std::size_t block, const PointAttribute* attribute, Sums& out) const;

    /// A field that somebody wants: the density, or a part of the mean of an attribute.
    struct Wanted {
        std::string name;
        int component = 0;
        GridPart part = GridPart::whole;
    };
    /// Fields of the density (null attribute) or of one attribute, in the order of `wanted`; values lie in `memory`.
    std::vector<SparseField> fields(const PointBlocks& blocks, const PointAttribute* attribute,
                                    const std::vector<Wanted>& wanted, BlockMemory& memory) const;

    /// Which number of each point a list holds: an attribute's component, the density within a
    /// point, a coordinate of its place, or its radius.
    struct Listed {
        std::string name;
        GridPart part = GridPart::ofPoints;
        int component = 0;
        const PointAttribute* attribute = nullptr;
    };
    /// One number of each point in the form of a field, so that all that maps fields voxel by voxel maps points, too:
    /// block i, at index (8 i, 0, 0), holds points 512 i and following, and blocks of zeros are left out. All lists of
    /// the same points have one lattice, whose map to the world is that of the places: these are in units of the box
    /// around all points, so that floats keep a sixteen-millionth of it. Radii are in world units, 0 beyond the last
    /// point. The density is 1, or that of the attribute. Empty unless sharp().
    SparseField list(const Listed& wanted, BlockMemory& memory) const;

  private:
    void keepSound(const MessageSink& messages);
    void chooseVoxel(const MessageSink& messages);
    void setVoxel(double voxel);
    bool spans(double voxel) const;
    bool areFarApart(double voxel);
    void chooseForLight(double usual, const MessageSink& messages);
    Bounds wsBounds() const;
    std::size_t countBlocks(std::size_t most) const;
    PointStamp stampAt(std::size_t point, const Vec3& ws, float wider) const;

    PointCloud m_cloud;
    PointLook m_look;
    std::string m_where;
    std::vector<float> m_radii;    ///< of each point, in world units
    std::vector<float> m_weights;  ///< of each point: the sum over voxels, times their volume
    double m_voxel = 0;
    bool m_sharp = false;
    Mat4 m_wsFromIs{1.0};
};

}  // namespace scrim
