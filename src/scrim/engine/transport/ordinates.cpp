// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/transport/ordinates.h>

#include <scrim/base/error.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "scrim/engine/transport/ordinates.cpp"
#include <hwy/foreach_target.h>
#include <scrim/engine/simd-inl.h>
#include <scrim/base/parallel.h>

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

// Four vectors of outputs for two rows stay in registers while all inputs are read.
HWY_ATTR void multiplyRows(const Real* matrix, std::size_t count, const Real* a, const Real* b, Real* toA, Real* toB) {
    const hn::CappedTag<Real, 8> d;
    const std::size_t lanes = hn::Lanes(d), step = std::min(4 * lanes, count);
    for (std::size_t m = 0; m < count; m += step) {
        auto a0 = hn::Zero(d), a1 = a0, a2 = a0, a3 = a0, b0 = a0, b1 = a0, b2 = a0, b3 = a0;
        const Real* column = matrix + m;
        for (std::size_t n = 0; n < count; ++n, column += count) {
            const auto fromA = hn::Set(d, a[n]), fromB = hn::Set(d, b[n]);
            const auto m0 = hn::LoadU(d, column), m1 = hn::LoadU(d, column + lanes);
            const auto m2 = hn::LoadU(d, column + 2 * lanes), m3 = hn::LoadU(d, column + 3 * lanes);
            a0 = hn::MulAdd(m0, fromA, a0);
            a1 = hn::MulAdd(m1, fromA, a1);
            a2 = hn::MulAdd(m2, fromA, a2);
            a3 = hn::MulAdd(m3, fromA, a3);
            b0 = hn::MulAdd(m0, fromB, b0);
            b1 = hn::MulAdd(m1, fromB, b1);
            b2 = hn::MulAdd(m2, fromB, b2);
            b3 = hn::MulAdd(m3, fromB, b3);
        }
        hn::StoreU(a0, d, toA + m);
        hn::StoreU(a1, d, toA + m + lanes);
        hn::StoreU(a2, d, toA + m + 2 * lanes);
        hn::StoreU(a3, d, toA + m + 3 * lanes);
        hn::StoreU(b0, d, toB + m);
        hn::StoreU(b1, d, toB + m + lanes);
        hn::StoreU(b2, d, toB + m + 2 * lanes);
        hn::StoreU(b3, d, toB + m + 3 * lanes);
    }
}

using D8 = hn::CappedTag<Real, 8>;

// Fills a row with the phase function times 4 pi; returns the sum of the row times the weights.
HWY_ATTR Real fillRow(const Ordinates& ordinates, const Phase& phase, const Vec3& travel, Real* row) {
    const D8 d;
    const auto x = hn::Set(d, static_cast<Real>(travel.x)), y = hn::Set(d, static_cast<Real>(travel.y));
    const auto z = hn::Set(d, static_cast<Real>(travel.z));
    const Lobe lobe(phase.g), other(phase.g2);
    const auto blend = hn::Set(d, static_cast<Real>(phase.blend)),
               strength = hn::Set(d, static_cast<Real>(phase.strength));
    auto sum = hn::Zero(d);
    for (std::size_t m = 0; m < std::size_t(ordinates.count()); m += hn::Lanes(d)) {
        const auto cosine = hn::MulAdd(x, hn::LoadU(d, ordinates.axes[0].data() + m),
                                       hn::MulAdd(y, hn::LoadU(d, ordinates.axes[1].data() + m),
                                                  hn::Mul(z, hn::LoadU(d, ordinates.axes[2].data() + m))));
        auto value = hn::Set(d, Real(1));
        if (phase.type == PhaseType::rayleigh) {
            const auto directed = hn::MulAdd(hn::Set(d, Real(0.75)), hn::Mul(cosine, cosine), hn::Set(d, Real(-0.25)));
            value = hn::MulAdd(strength, directed, value);
        } else {
            value = henyeyGreenstein(d, cosine, lobe);
            if (phase.type == PhaseType::twoLobe)
                value = hn::MulAdd(blend, hn::Sub(henyeyGreenstein(d, cosine, other), value), value);
        }
        hn::StoreU(value, d, row + m);
        sum = hn::MulAdd(value, hn::LoadU(d, ordinates.weightRow.data() + m), sum);
    }
    return hn::GetLane(hn::SumOfLanes(d, sum));
}

HWY_ATTR Real weightedSum(const Ordinates& ordinates, const Real* a, const Real* b) {
    const D8 d;
    auto sum = hn::Zero(d);
    for (std::size_t m = 0; m < std::size_t(ordinates.count()); m += hn::Lanes(d))
        sum = hn::MulAdd(hn::Mul(hn::LoadU(d, a + m), hn::LoadU(d, b + m)),
                         hn::LoadU(d, ordinates.weightRow.data() + m), sum);
    return hn::GetLane(hn::SumOfLanes(d, sum));
}

}  // namespace HWY_NAMESPACE
}  // namespace scrim
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace scrim {

HWY_EXPORT(multiplyRows);
HWY_EXPORT(fillRow);
HWY_EXPORT(weightedSum);

namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::size_t kMost = 256;  // most ordinates

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

void mixOrdinates(const std::vector<std::vector<Real>>& matrices, const std::vector<std::vector<Real>>& shares,
                  std::size_t begin, std::size_t end, std::size_t count, Real* rows, Simd simd) {
    const auto multiply = SCRIM_ON_TARGET(simd, multiplyRows);
    std::array<Real, kMost> a, b, sumA, sumB;
    for (std::size_t row = begin; row < end; row += 2) {
        Real *first = rows + row * count, *second = row + 1 < end ? first + count : first;
        if (shares.empty()) {
            multiply(matrices.front().data(), count, first, second, a.data(), b.data());
            std::copy_n(a.data(), count, first);
            if (second != first) std::copy_n(b.data(), count, second);
            continue;
        }
        std::fill_n(sumA.data(), count, Real(0));
        std::fill_n(sumB.data(), count, Real(0));
        for (std::size_t k = 0; k < matrices.size(); ++k) {
            multiply(matrices[k].data(), count, first, second, a.data(), b.data());
            const Real shareA = shares[k][row], shareB = shares[k][std::min(row + 1, end - 1)];
            for (std::size_t m = 0; m < count; ++m) {
                sumA[m] += shareA * a[m];
                sumB[m] += shareB * b[m];
            }
        }
        std::copy_n(sumA.data(), count, first);
        if (second != first) std::copy_n(sumB.data(), count, second);
    }
}

void scatteringRow(const Ordinates& ordinates, const Phase& phase, const Vec3& travel, Real* row, Simd simd) {
    const Real sum = SCRIM_ON_TARGET(simd, fillRow)(ordinates, phase, travel, row);
    for (std::size_t m = 0; m < std::size_t(ordinates.count()); ++m) row[m] /= sum;
}

Real gathered(const Ordinates& ordinates, const Real* scattering, const Real* radiance, Simd simd) {
    return SCRIM_ON_TARGET(simd, weightedSum)(ordinates, scattering, radiance);
}

namespace {

// The table over depth / (1 + depth) and the sine of half the angle, both in [0, 1]; linear between entries.
constexpr int kDepths = 64, kAngles = 256;
constexpr double kLeastMoment = 1e-4;
constexpr int kMostMoments = 400;

// The mean cosine of the narrowest lobe that the ordinates must resolve. Measured on smoke lit from behind and from the
// side, g = 0.75 and 0.9: with narrower lobes, smoke is too bright where the eye looks near the light; with wider ones,
// which send more light straight on, light is carried too far.
double narrowestLobe(int ordinates) {
    return ordinates <= 64 ? 0.6 : ordinates <= 128 ? 0.7 : 0.85;
}

// The Legendre moments of a phase function: g^l for Henyey and Greenstein's.
struct Moments {
    const Phase& phase;
    double first = 1, second = 1;

    double value() const {
        return phase.type == PhaseType::twoLobe ? (1 - phase.blend) * first + phase.blend * second : first;
    }
    void next() {
        first *= phase.g;
        second *= phase.g2;
    }
};

// The phase function with its narrowest lobes widened. Narrower ones are like a line here, forwards and backwards, and
// would only cause divisions by zero.
Phase heldLobes(Phase phase) {
    constexpr double kNarrowest = 0.9999;
    phase.g = std::clamp(phase.g, -kNarrowest, kNarrowest);
    phase.g2 = std::clamp(phase.g2, -kNarrowest, kNarrowest);
    return phase;
}

}  // namespace

SplitPhase::SplitPhase(const Phase& given, int ordinates) : m_spread(heldLobes(given)) {
    const Phase phase = m_spread;
    if (phase.type == PhaseType::rayleigh) return;
    // For a lobe with mean cosine g, the fraction f goes straight on and the rest has w: f + (1 - f) w = g.
    const double w = narrowestLobe(ordinates);
    const auto straightOf = [&](double g) { return g > w ? (g - w) / (1 - w) : 0.0; };
    m_straight = straightOf(phase.g);
    m_spread.g = std::min(phase.g, w);
    if (phase.type == PhaseType::twoLobe) {
        const double second = straightOf(phase.g2);
        m_straight += phase.blend * (second - m_straight);
        m_spread.g2 = std::min(phase.g2, w);
        m_spread.blend = phase.blend * (1 - second) / (1 - m_straight);
    }
    if (m_straight == 0) return;
    m_table.resize(std::size_t(kDepths) * kAngles);
    parallelFor(kDepths, [&](std::size_t i) {
        const double part = double(i) / (kDepths - 1);
        const double depth = i + 1 < kDepths ? part / (1 - part) : 1e6;
        std::vector<double> weights;
        for (Moments all{phase}, wide{m_spread}; weights.size() < kMostMoments; all.next(), wide.next()) {
            const double narrow = (all.value() - (1 - m_straight) * wide.value()) / m_straight;
            const auto l = static_cast<double>(weights.size());
            weights.push_back((2 * l + 1) / (4 * std::numbers::pi) * all.value() *
                              (std::exp(depth * (narrow - 1)) - std::exp(-depth)));
            if (std::abs(all.value()) * (2 * l + 1) < kLeastMoment) break;
        }
        for (int a = 0; a < kAngles; ++a) {
            const double sine = double(a) / (kAngles - 1), cosine = 1 - 2 * sine * sine;
            double sum = 0, before = 0, polynomial = 1;
            for (std::size_t l = 0; l < weights.size(); ++l) {
                sum += weights[l] * polynomial;
                const auto n = static_cast<double>(l);
                const double next = ((2 * n + 1) * cosine * polynomial - n * before) / (n + 1);
                before = polynomial;
                polynomial = next;
            }
            m_table[i * kAngles + std::size_t(a)] = static_cast<float>(sum);
        }
    });
}

double SplitPhase::scatteredAgain(double depth, double cosTheta) const {
    if (m_table.empty()) return 0;
    const double i = depth / (1 + depth) * (kDepths - 1);
    const double a = std::sqrt(std::clamp(0.5 * (1 - cosTheta), 0.0, 1.0)) * (kAngles - 1);
    const auto row = std::min(static_cast<std::size_t>(i), std::size_t(kDepths - 2));
    const auto column = std::min(static_cast<std::size_t>(a), std::size_t(kAngles - 2));
    const double t = i - double(row), s = a - double(column);
    const float* p = m_table.data() + row * kAngles + column;
    const auto along = [&](const float* v) { return double(v[0]) + s * double(v[1] - v[0]); };
    return along(p) + t * (along(p + kAngles) - along(p));
}

}  // namespace scrim
#endif
