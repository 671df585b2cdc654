// SPDX-License-Identifier: Apache-2.0
// The settings that a study tries: every dial alone around the scene's own setting, the presets,
// and sheets and texels jointly.
#pragma once

#include <scrim/study/trial.h>

#include <string>
#include <vector>

namespace scrim {

/// The values of one dial, from the finest to the coarsest.
struct DialSweep {
    std::string dial;
    std::vector<std::string> values;
    std::vector<double> sizes;        ///< the quantity that shrinks as the dial gets finer; empty: the values have none
    std::vector<std::size_t> trials;  ///< index into the study's list of trials, for each value
    /// RMS distance from the finest value that was rendered, relative to the mean, for each value; 0: unknown
    std::vector<double> distances;
    std::optional<double> order;  ///< the measured order, see convergenceOrder
};

/// Sweeps for all dials that a study varies, still without trials. `scattering`: also for those of
/// light that scatters more than once.
std::vector<DialSweep> dialSweeps(bool scattering);

/// The index of `dials` in `trials`, to which they are added if they are missing.
std::size_t addTrial(std::vector<Trial>& trials, const std::string& name, const Dials& dials);

/// Adds a trial for every value of every sweep, each varied alone, and fills in the sweeps' trials.
void addSweeps(std::vector<Trial>& trials, std::vector<DialSweep>& sweeps, const Dials& base);

/// Adds trials that vary texels and sheets together, since these cost most of the time.
void addJoint(std::vector<Trial>& trials, const Dials& base);

/// Adds, for each trial of the front, variants with every other dial one value finer and one coarser.
void addNeighbours(std::vector<Trial>& trials, const std::vector<DialSweep>& sweeps,
                   const std::vector<std::size_t>& front);

}  // namespace scrim
