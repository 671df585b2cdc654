// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/transport/ordinates.h>

#include <scrim/base/error.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <glm/geometric.hpp>

namespace scrim {
namespace {

constexpr double kPi = std::numbers::pi;

struct Node {
    double cosine, weight;  // weights sum to 2
};

// Gauss-Legendre quadrature on [-1, 1]: roots of Legendre's polynomial by Newton's method, descending.
std::vector<Node> gaussLegendre(int n) {
    std::vector<Node> nodes;
    for (int i = 0; i < n; ++i) {
        double x = std::cos(kPi * (i + 0.75) / (n + 0.5)), slope = 1;
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
        nodes.push_back({x, 2 / ((1 - x * x) * slope * slope)});
    }
    return nodes;
}

// The number of angles in a quarter turn at each level, from the pole to the equator.
std::vector<int> anglesOf(int count) {
    switch (count) {
        case 64:
            return {2, 3, 3};
        case 128:
            return {2, 4, 5, 5};
        case 256:
            return {2, 5, 7, 8, 10};
        default:
            throw Error(ErrorKind::usage, fmt::format("{} ordinates: there are sets of 64, 128 and 256", count));
    }
}

double meanCosine(const Phase& phase) {
    switch (phase.type) {
        case PhaseType::twoLobe:
            return (1 - phase.blend) * phase.g + phase.blend * phase.g2;
        case PhaseType::rayleigh:
            return 0;
        default:
            return phase.g;
    }
}

}  // namespace

Ordinates ordinates(int count) {
    const std::vector<int> angles = anglesOf(count);
    const std::vector<Node> levels = gaussLegendre(2 * static_cast<int>(angles.size()));
    Ordinates out;
    out.perOctant = count / 8;
    for (int octant = 0; octant < 8; ++octant)
        for (std::size_t level = 0; level < angles.size(); ++level)
            for (int a = 0; a < angles[level]; ++a) {
                const double z = levels[level].cosine, across = std::sqrt(1 - z * z);
                const double angle = kPi / 2 * (a + 0.5) / angles[level];
                Vec3 direction(across * std::cos(angle), across * std::sin(angle), z);
                for (int axis = 0; axis < 3; ++axis)
                    if (octant >> axis & 1) direction[axis] = -direction[axis];
                out.directions.push_back(direction);
                out.weights.push_back(levels[level].weight * (kPi / 2) / angles[level]);
                for (int axis = 0; axis < 3; ++axis) out.axes[axis].push_back(static_cast<Real>(direction[axis]));
                out.weightRow.push_back(static_cast<Real>(out.weights.back()));
            }
    return out;
}

int nearestOrdinate(const Ordinates& ordinates, const Vec3& direction) {
    int best = 0;
    for (int m = 1; m < ordinates.count(); ++m)
        if (glm::dot(ordinates.directions[std::size_t(m)], direction) >
            glm::dot(ordinates.directions[std::size_t(best)], direction))
            best = m;
    return best;
}

std::vector<Real> scatteringMatrix(const Ordinates& ordinates, const Phase& phase) {
    const auto count = std::size_t(ordinates.count());
    const double g = meanCosine(phase);
    // The matrix has the phase function's values for other ordinates, scaled by d_n d_m. Straight on, where the value
    // is least certain, it has whatever gives the right mean cosine.
    std::vector<double> p(count * count), straight(count), scale(count, 1.0);
    for (std::size_t n = 0; n < count; ++n) {
        double sum = 0, along = 0;
        for (std::size_t m = 0; m < count; ++m) {
            if (m == n) continue;
            const double cosine = glm::dot(ordinates.directions[n], ordinates.directions[m]);
            p[n * count + m] = phaseValue(phase, cosine);
            sum += ordinates.weights[m] * p[n * count + m];
            along += ordinates.weights[m] * p[n * count + m] * cosine;
        }
        along /= sum;
        straight[n] = std::clamp((g - along) / (1 - along), 0.0, 1.0);
    }
    // Sinkhorn's iteration, in its symmetric form.
    for (int step = 0; step < 100; ++step)
        for (std::size_t n = 0; n < count; ++n) {
            double sum = 0;
            for (std::size_t m = 0; m < count; ++m)
                if (m != n) sum += ordinates.weights[m] * scale[m] * p[n * count + m];
            scale[n] = std::sqrt(scale[n] * (1 - straight[n]) / sum);
        }
    std::vector<Real> out(count * count);
    for (std::size_t n = 0; n < count; ++n)
        for (std::size_t m = 0; m < count; ++m)
            out[n * count + m] =
                static_cast<Real>(m == n ? straight[n] : ordinates.weights[n] * scale[n] * scale[m] * p[n * count + m]);
    return out;
}

}  // namespace scrim
