// SPDX-License-Identifier: Apache-2.0
#include <scrim/base/legendre.h>

#include <cmath>
#include <numbers>

namespace scrim {

// The points are the roots of P_n, found by Newton's method.
std::vector<QuadraturePoint> gaussLegendre(int n) {
    std::vector<QuadraturePoint> points;
    for (int i = 0; i < n; ++i) {
        double x = std::cos(std::numbers::pi * (i + 0.75) / (n + 0.5)), slope = 1;
        for (int step = 0; step < 20; ++step) {
            double value = 1, before = 0;
            for (int j = 0; j < n; ++j) {
                const double next = ((2 * j + 1) * x * value - j * before) / (j + 1);
                before = value;
                value = next;
            }
            slope = n * (x * value - before) / (x * x - 1);
            x -= value / slope;
        }
        points.push_back({x, 2 / ((1 - x * x) * slope * slope)});
    }
    return points;
}

}  // namespace scrim
