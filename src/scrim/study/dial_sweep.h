// SPDX-License-Identifier: Apache-2.0
// What a study tries: every dial alone around the scene's own setting, the presets, and sheets and texels jointly.
#pragma once

#include <scrim/study/trial.h>

#include <string>
#include <vector>

namespace scrim {

/// One dial, from its finest value to its coarsest.
struct DialSweep {
    std::string dial;
    std::vector<std::string> values;
    std::vector<double> sizes;        ///< what shrinks as the dial gets finer; empty: the values have no size
    std::vector<std::size_t> trials;  ///< one a value: places in the study's list
    std::vector<double> distances;    ///< RMS from the finest that was run, over the mean; one a value, 0: not known
    std::optional<double> order;      ///< measured, see convergenceOrder
};

/// All dials that a study turns, without trials.
std::vector<DialSweep> dialSweeps();

/// The place of `dials` in `trials`, where they are put if they are not there yet.
std::size_t addTrial(std::vector<Trial>& trials, const std::string& name, const Dials& dials);

/// Every value of every sweep, alone: fills in the sweeps' trials.
void addSweeps(std::vector<Trial>& trials, std::vector<DialSweep>& sweeps, const Dials& base);

/// Texels and sheets together, which is where the time goes.
void addJoint(std::vector<Trial>& trials, const Dials& base);

/// Each trial of the front with every other dial one value finer and one coarser.
void addNeighbours(std::vector<Trial>& trials, const std::vector<DialSweep>& sweeps,
                   const std::vector<std::size_t>& front);

}  // namespace scrim
