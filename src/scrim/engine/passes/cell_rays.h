// SPDX-License-Identifier: Apache-2.0
// The sources that light passes cells from, and what looks at it.
#pragma once

#include <scrim/base/real.h>
#include <scrim/engine/passes/cell_slices.h>
#include <scrim/geometry/spaces.h>
#include <scrim/scene/classified.h>
#include <scrim/scene/medium.h>
#include <scrim/scene/phase_over_caps.h>

#include <cstddef>
#include <functional>
#include <optional>
#include <tuple>
#include <vector>

namespace scrim {

/// A source of light without extent, in the axes of CellSlices and in cells.
struct CellRays {
    bool parallel = true;
    Vec3 way{0, 0, 1};                   ///< parallel: direction of travel, unit; otherwise the normal of an element
    Vec3 from{0};                        ///< the place of a source that is not parallel
    double radius2 = 0, decayScale = 0;  ///< irradiance is weight / max(r2, radius2) * decayScale; 0: no decay
    bool lamp = false;                   ///< a point of a lamp, of which only the transmittance is asked
    bool oneSided = false;               ///< an element: irradiance has the cosine to its normal as factor
    double spreadTangent = 0, spreadScale = 0;                   ///< of an element (see Spread); scale 0: none
    std::optional<std::tuple<double, Vec3, Mat3>> pattern = {};  ///< of a part of a mesh: CellSlices::seriesOf
    bool attenuated = true;                                      ///< false: only surfaces hold the light back
    double extinction = 1;                                       ///< factor on that of the cells
    bool blocked = false;                                        ///< surfaces hold the light back
    const Real* phaseRow = nullptr;  ///< in place of CellView's phase function (PhaseRow); null: that one
    /// Of a part of a surface: its means in place of the phase function; null: that one.
    const PhaseOverCaps* caps = nullptr;
    double capRadius = 0;  ///< of the disk that the part stands for
    /// The light is for cells of a finer level, between these: no ray is needed that none of the wanted cells asks for,
    /// but cells beside a face of the cube around a point are lit with it, too.
    bool forFiner = false;
    Real weight[3] = {0, 0, 0};
};

/// What all sources of a sweep share.
struct CellView {
    Phase phase;  ///< towards the eye
    /// Phong's model in place of the phase function: the diffuse part and, if it has one, the
    /// mirrored one, which has as many sums behind those of the diffuse one.
    const Classified* surface = nullptr;
    bool parallelEye = true;
    Vec3 eye{0};  ///< its place, in the axes of CellSlices and in cells; parallel: the direction towards it
    std::size_t colours = 1;
    /// The number of steps after which the ray from + steps perStep (cells of the box) is dark, because it has met a
    /// surface; infinity where it meets none. Parallel rays begin at minus infinity, others at 0.
    std::function<double(const Vec3& from, const Vec3& perStep, bool parallel)> darkFrom;
};

/// How sources pass the cells: they are all parallel and have the slices' axis as their main one, or are points.
struct Passage {
    const CellView& view;
    CellSlices& box;                         ///< gets their light
    const std::vector<CellSlices>& coarser;  ///< the media of coarser levels, along the same axis (CoarserLight)
    const std::function<void()>& checkpoint;
    bool parallel, down;  ///< down: only rays that pass the slices in descending order
};

}  // namespace scrim
