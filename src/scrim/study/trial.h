// SPDX-License-Identifier: Apache-2.0
// One setting of the dials, tried on a scene: its cost, and its error.
#pragma once

#include <scrim/engine/model/frame.h>
#include <scrim/scene/dials.h>
#include <scrim/verify/verify.h>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace scrim {

struct Trial {
    /// The differences from the scene's own setting, "texel 0.5, sheet_thickness 2", or a preset's name.
    std::string name;
    Dials dials;
    bool run = false;
    std::string skipped;          ///< why it was not run
    Verification error;           ///< against the reference with the same kernel
    std::vector<double> seconds;  ///< of plan and render, one for each repeat
    RenderWork work;
    std::vector<VerifiedPixel> seen;  ///< at the reference's pixels
    bool onFront = false;             ///< no trial with the scene's kernel is both faster and more accurate

    /// Median of the repeats, seconds.
    double time() const;
};

/// True if two settings would render the same picture.
bool sameDials(const Dials& a, const Dials& b);

/// Trials with exactly the same counts of work take the same time, whatever was measured. Gives
/// each of them the repeats of all.
void shareTimes(std::vector<Trial>& trials);

/// True if `a` is slower than `b` by more than noise: its median is larger by a tenth, and each of
/// its repeats is slower than every repeat of `b`.
bool isSlower(const Trial& a, const Trial& b);

/// Marks the trials that no other trial beats in both speed and accuracy, among those of `kernel`
/// that were run; returns their indices from fast to accurate.
std::vector<std::size_t> markFront(std::vector<Trial>& trials, Kernel kernel);

/// The index of the fastest trial whose error is at most `tolerance`, among those of `kernel` that
/// were run; of trials with equal times, the first.
std::optional<std::size_t> cheapestWithin(const std::vector<Trial>& trials, Kernel kernel, double tolerance);

}  // namespace scrim
