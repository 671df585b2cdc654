// SPDX-License-Identifier: Apache-2.0
// How fast a dial's error falls, measured from renders of one scene.
#pragma once

#include <optional>
#include <vector>

namespace scrim {

/// A dial at `size`, and how far the picture is from that of the finest size (RMS, any unit).
struct DialDistance {
    double size = 0;
    double distance = 0;
};

/// The order p for which the distances fit C (size^p - finest^p) best, in the least squares of logarithms. The finest
/// picture is not the limit itself, which is why it stands in the formula. Nothing where fewer than two distances
/// are not 0.
std::optional<double> convergenceOrder(const std::vector<DialDistance>& distances, double finest);

}  // namespace scrim
