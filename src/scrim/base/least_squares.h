// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

namespace scrim {

/// The solution of normal equations, which need no pivots: `matrix` is symmetric and not negative.
/// Unknowns that the equations do not determine are 0.
std::vector<double> leastSquares(std::vector<std::vector<double>> matrix, std::vector<double> right);

}  // namespace scrim
