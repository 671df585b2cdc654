// SPDX-License-Identifier: Apache-2.0
// One setting of the dials, tried on a scene: what it costs, and how far it is from the truth.
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
    std::string
        name;  ///< what differs from the scene's own setting: "texel 0.5, sheet_thickness 2"; or a preset's name
    Dials dials;
    bool run = false;
    std::string skipped;          ///< why it was not run
    Verification error;           ///< against the reference with the same kernel
    std::vector<double> seconds;  ///< of plan and render, one a repeat
    RenderWork work;
    std::vector<VerifiedPixel> seen;  ///< at the reference's pixels
    bool onFront = false;             ///< no trial with the scene's kernel is both faster and more accurate

    /// Median of the repeats.
    double time() const;
};

/// Whether two settings would render the same.
bool sameDials(const Dials& a, const Dials& b);

/// Settings that did the same work, to the last count, take the same time: whatever their clocks said. Gives each of
/// them all repeats of all.
void shareTimes(std::vector<Trial>& trials);

/// Is `a` slower than `b` by more than noise: by a tenth in the median, and in every repeat than in any of `b`?
bool isSlower(const Trial& a, const Trial& b);

/// Marks the trials that no other is both faster and more accurate than, among those of `kernel` that were run;
/// returns their places from fast to accurate.
std::vector<std::size_t> markFront(std::vector<Trial>& trials, Kernel kernel);

/// The place of the fastest trial whose error is at most `tolerance`, among those of `kernel` that were run; of those
/// whose times do not differ the first one.
std::optional<std::size_t> cheapestWithin(const std::vector<Trial>& trials, Kernel kernel, double tolerance);

}  // namespace scrim
