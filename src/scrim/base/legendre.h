// SPDX-License-Identifier: Apache-2.0
// Legendre polynomials P_l and their quadrature.
#pragma once

#include <cstddef>
#include <vector>

namespace scrim {

/// Calls term(l, P_l(x)) for the first `count` polynomials.
template <class Term>
void forLegendre(std::size_t count, double x, const Term& term) {
    double before = 0, polynomial = 1;
    for (std::size_t l = 0; l < count; ++l) {
        term(l, polynomial);
        const auto n = static_cast<double>(l);
        const double next = ((2 * n + 1) * x * polynomial - n * before) / (n + 1);
        before = polynomial;
        polynomial = next;
    }
}

struct QuadraturePoint {
    double x, weight;
};

/// Gauss-Legendre quadrature on [-1, 1] with n points, descending; weights sum to 2.
std::vector<QuadraturePoint> gaussLegendre(int n);

}  // namespace scrim
