// SPDX-License-Identifier: Apache-2.0
#include <scrim/study/convergence_order.h>

#include <cmath>
#include <limits>

namespace scrim {

std::optional<double> convergenceOrder(const std::vector<DialDistance>& distances, double finest) {
    constexpr double kLeast = 0.1, kMost = 6, kStep = 0.01;
    std::vector<DialDistance> used;
    for (const DialDistance& d : distances)
        if (d.size > finest && d.distance > 0) used.push_back(d);
    if (used.size() < 2) return std::nullopt;

    // There is one unknown besides the factor, so trying all of its values is the simplest way to find the best.
    double best = 0, leastScatter = std::numeric_limits<double>::infinity();
    for (double p = kLeast; p <= kMost; p += kStep) {
        double sum = 0, squares = 0;
        for (const DialDistance& d : used) {
            const double log = std::log(d.distance / (std::pow(d.size, p) - std::pow(finest, p)));
            sum += log;
            squares += log * log;
        }
        const auto n = static_cast<double>(used.size());
        const double scatter = squares / n - sum * sum / (n * n);
        if (scatter < leastScatter) {
            leastScatter = scatter;
            best = p;
        }
    }
    return best;
}

}  // namespace scrim
