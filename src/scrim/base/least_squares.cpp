// SPDX-License-Identifier: Apache-2.0
#include <scrim/base/least_squares.h>

#include <cmath>
#include <cstddef>

namespace scrim {

std::vector<double> leastSquares(std::vector<std::vector<double>> a, std::vector<double> b) {
    const std::size_t n = b.size();
    for (std::size_t i = 0; i < n; ++i) {
        if (!(std::abs(a[i][i]) > 0)) continue;
        for (std::size_t j = i + 1; j < n; ++j) {
            const double factor = a[j][i] / a[i][i];
            for (std::size_t k = i; k < n; ++k) a[j][k] -= factor * a[i][k];
            b[j] -= factor * b[i];
        }
    }
    for (std::size_t i = n; i-- > 0;) {
        for (std::size_t k = i + 1; k < n; ++k) b[i] -= a[i][k] * b[k];
        b[i] = std::abs(a[i][i]) > 0 ? b[i] / a[i][i] : 0;
    }
    return b;
}

}  // namespace scrim
