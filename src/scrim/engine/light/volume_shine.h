// SPDX-License-Identifier: Apache-2.0
// The light that volumes send to surfaces: what they emit, and what they scatter. A fire lights its hearth, and a cloud
// the ground. Surfaces see it without sharp shadows, so that coarse cells are enough, over which each surface point
// looks along cones (C. Crassin and others, Interactive Indirect Illumination Using Voxel Cone Tracing, 2011).
#pragma once

#include <scrim/base/messages.h>
#include <scrim/engine/model/plan.h>
#include <scrim/geometry/bounds.h>
#include <scrim/scene/view_scene.h>

#include <array>
#include <cstddef>
#include <vector>

namespace scrim {

/// May be used from many threads at once. What it leaves out: volumes that are classified hold light back, and send
/// none; light from several sides counts as that from their mean direction and as light from all sides, and a phase
/// function as Henyey and Greenstein's of its mean cosine; light that has scattered before counts as even over all
/// directions. Cells are a 62nd of the longest edge of all volumes, and what is dense within one is smoothed.
class VolumeShine {
  public:
    /// `scene` must outlive this object. Solves `again`, the plan of light that scatters more than once in
    /// withScatteredApart(scene). Calls `checkpoint` now and then. Throws as scatteredMoments does.
    VolumeShine(const ViewScene& scene, const TransportPlan& again, const Checkpoint& checkpoint);

    /// The irradiance on a surface at `ws` whose normal is `normal` (unit), through all volumes and
    /// past the solids that cast shadows.
    Rgb irradiance(const Vec3& ws, const Vec3& normal) const;

    /// The memory that cells take while they are made.
    static std::size_t bytes();

  private:
    // Of a cell, per world unit: extinction, and radiance evenly to all sides. Each has three colours.
    struct Cell {
        std::array<float, 4> extinction{}, source{};
    };
    // Per world unit, for each colour the part of the source that comes in a beam along x, y and z,
    // and its length times the mean cosine by which it is scattered.
    using Flow = std::array<std::array<float, 4>, 3>;
    // Cells of one size in the cube around all volumes, x fastest, with a border of empty ones.
    struct Level {
        int along = 1;  // without the border
        double edge = 0;
        std::vector<Cell> cells;
        std::vector<Flow> flows;  // empty: all light is sent evenly

        std::size_t indexOf(const Int3& cell) const {
            const auto row = std::size_t(along) + 2;
            return (std::size_t(cell.z + 1) * row + std::size_t(cell.y + 1)) * row + std::size_t(cell.x + 1);
        }
        void resize(bool withFlows);
    };
    struct Making;
    // Directions around an axis, evenly over a cap of the unit sphere.
    struct Cap {
        Vec3 axis;
        double solidAngle;
    };
    Rgb irradiance(const Vec3& ws, const Vec3& normal, const Cap& cap) const;
    template <bool withFlows>
    Rgb radiance(const Vec3& ws, const Vec3& direction, double spread, double most) const;

    const ViewScene& m_scene;
    Bounds m_wsBounds;
    double m_radius = 0;          // of the sphere around the cube, world units
    std::vector<Level> m_levels;  // each half as fine as the one before; the last is one cell
};

/// True if the scene has volumes that send light.
bool anyShines(const ViewScene& scene);

/// The scene whose solve keeps what has scattered apart from what has not, and from ambient light.
ViewScene withScatteredApart(const ViewScene& scene);

}  // namespace scrim
