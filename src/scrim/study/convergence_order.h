// SPDX-License-Identifier: Apache-2.0
// Measures how fast a dial's error falls, from renders of one scene.
#pragma once

#include <optional>
#include <vector>

namespace scrim {

/// A dial's size, and the distance (RMS, any unit) of its picture from that of the finest size.
struct DialDistance {
    double size = 0;
    double distance = 0;
};

/// The order p for which the distances fit C (size^p - finest^p) best, by least squares of
/// logarithms. `finest` is in the formula because the finest picture is not the limit itself. No
/// value where fewer than two distances differ from 0.
std::optional<double> convergenceOrder(const std::vector<DialDistance>& distances, double finest);

}  // namespace scrim
