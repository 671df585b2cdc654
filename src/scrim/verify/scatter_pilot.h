// SPDX-License-Identifier: Apache-2.0
// Estimates the error of multiply scattered light before anything is rendered, and chooses its cells and directions.
// Two solves in coarse cells, one of them in cells twice as large, show a few rays how much light depends on cells, and
// one with twice as many directions how much on those. The moments of the phase functions tell how much light is
// scattered more narrowly than directions can resolve.
#pragma once

#include <scrim/scene/view_scene.h>

#include <array>
#include <limits>
#include <optional>
#include <string>

namespace scrim {

inline constexpr double kFinestScatterCell = 0.5;  ///< voxels; cells are never chosen finer

/// What the pilot saw. Errors are relative to the mean of all light, and those of means over
/// squares of pixels (kScatteringMean).
struct ScatterPilot {
    double edge = 0;        ///< the edge of the smaller cells, voxels
    double difference = 0;  ///< RMS over the rays of the difference between the solves with these cells and with larger
    double ofEach = 0;      ///< likewise, each ray relative to its own light, or to a tenth of the mean
    double rayEffects = 0;  ///< the same for the solves with 64 and with 128 directions
    double share = 0;       ///< the part of all light that has scattered more than once, or comes from skies
    double ofSkies = 0;     ///< the part of it that comes from skies and ambient light, which enter at the border
    bool surfaces = false;  ///< scattersInSurfaces
    /// The thinnest volume's extent along an axis of its grid, and the largest cells that should be
    /// chosen for it; both in shortest edges of its voxels.
    double layers = std::numeric_limits<double>::infinity(), thickest = layers;
    bool limited = false;  ///< finer cells would have told more, but the memory limit left no room for them
    /// For each of kOrdinateCounts the part of the scattered light that goes straight on, of the
    /// narrowest phase function (SplitPhase).
    std::array<double, 3> straight{};

    /// The error that cells of `cell` voxels are expected to leave; nine of ten scenes have less.
    /// It grows with their edge to the power of `order`.
    double ofCells(double cell) const;
    /// The same, but for what all cells miss that are too large for the thinnest volume.
    double byDifference(double cell) const;
    double order() const;
    /// Likewise for the i-th of kOrdinateCounts.
    double ofDirections(std::size_t i) const;
};

/// No value: no volume scatters light more than once, or the scene states both dials.
std::optional<ScatterPilot> scatterPilot(const ViewScene& scene);

struct ScatterChoice {
    double cell = 0;     ///< dial scatter_cell
    int directions = 0;  ///< dial scatter_directions
    double expected = 0;
    std::string why;       ///< a phrase for people, with numbers
    bool limited = false;  ///< as ScatterPilot::limited: without the limit another choice may be made
};

/// The largest cells and the fewest directions that should leave no more than `error`, or the
/// finest that are chosen. What `dials` states is kept.
ScatterChoice chooseScattering(const ScatterPilot& pilot, const Dials& dials, double error);

}  // namespace scrim
