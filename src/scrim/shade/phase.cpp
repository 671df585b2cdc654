// SPDX-License-Identifier: Apache-2.0
#include <scrim/shade/phase.h>

#include <cmath>

namespace scrim {

double phaseValue(const Phase& phase, double cosTheta) {
    const double fourPi = 4 * std::acos(-1.0);
    const double g = phase.g;
    return (1 - g * g) / (fourPi * std::pow(1 + g * g - 2 * g * cosTheta, 1.5));
}

}  // namespace scrim
