// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/phase_over_caps.h>

#include <scrim/base/legendre.h>
#include <scrim/base/parallel.h>
#include <scrim/scene/split_phase.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace scrim {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr int kRow = kPhaseAngles + 1;

// The cosine at entry i, and the entry at a cosine.
double cosineAt(int i) {
    const double root = double(i) / (kPhaseAngles - 1), sine = root * root;
    return 1 - 2 * sine * sine;
}
double entryAt(double cosine) {
    return std::sqrt(std::sqrt(std::clamp(0.5 * (1 - cosine), 0.0, 1.0))) * (kPhaseAngles - 1);
}

double between(const Real* row, double cosine) {
    const double at = entryAt(cosine);
    const int i = std::min(static_cast<int>(at), kPhaseAngles - 2);
    return double(row[i]) + (at - i) * double(row[i + 1] - row[i]);
}

// The Legendre moments of an even distribution over a cap: the mean of P_l over it.
std::vector<double> capMoments(double halfAngle, std::size_t count) {
    std::vector<double> moments(count, 1.0), polynomials(count + 1);
    const double cosine = std::cos(halfAngle), depth = 2 * std::pow(std::sin(0.5 * halfAngle), 2);
    forLegendre(count + 1, cosine, [&](std::size_t l, double p) { polynomials[l] = p; });
    for (std::size_t l = 1; l < count; ++l)
        moments[l] = (polynomials[l - 1] - polynomials[l + 1]) / (double(2 * l + 1) * depth);
    return moments;
}

// The rings that stand for a peak, of which is known how much light is how far from its middle: in the order of that.
std::vector<PeakRing> ringsOf(const std::vector<PeakRing>& peak) {
    constexpr double kMiddle = 0.15, kParts[] = {kMiddle, 0.45, 0.75, 1};  // what lies within each ring's outer border
    constexpr double kNarrow = 5e-4;                                       // 1 - cos of 1.8 degrees: the middle, too
    double all = 0;
    for (const PeakRing& some : peak) all += some.part;
    std::vector<PeakRing> rings(1);
    if (!(all > 0)) return rings;
    double within = 0;
    std::size_t i = 0;
    for (const double border : kParts) {
        PeakRing ring;
        double depths = 0;
        for (; i < peak.size() && (within < border * all || border == 1); ++i) {
            within += peak[i].part;
            ring.part += peak[i].part / all;
            depths += peak[i].part / all * peak[i].depth;
        }
        if (ring.part > 0) ring.depth = depths / ring.part;
        if (border == kMiddle || ring.depth < kNarrow)
            rings.front().part += ring.part;
        else
            rings.push_back(ring);
    }
    return rings;
}

}  // namespace

double lobeWidth(const Phase& phase) {
    if (phase.isotropic() || phase.type == PhaseType::rayleigh) return kPi;
    double g = phase.type == PhaseType::twoLobe && phase.blend == 1 ? 0 : std::abs(phase.g);
    if (phase.type == PhaseType::twoLobe && phase.blend > 0) g = std::max(g, std::abs(phase.g2));
    return g > 0 ? 1 - g : kPi;
}

bool needsCaps(const Phase& phase, double halfAngle) {
    // Skies of 130 directions, each with a cap of 10 degrees, leave 2 % at g = 0.6 and 0.1 % at 0.5.
    constexpr double kWide = 2.4;
    return lobeWidth(phase) < kWide * halfAngle;
}

PhaseOverCaps::PhaseOverCaps(const Phase& phase, double most) : m_most(most), m_values(std::size_t(kCaps) * kRow) {
    constexpr std::size_t kMostMoments = 4096;
    constexpr double kLittle = 1e-6;  // per steradian
    const std::vector<double> all = legendreMoments(phase, static_cast<int>(kMostMoments));
    std::vector<std::vector<double>> weights;
    for (int c = 1; c < kCaps; ++c) {
        const double half = most * std::pow(double(c) / (kCaps - 1), 2);
        std::vector<double> own = capMoments(half, kMostMoments);
        for (std::size_t l = 0; l < own.size(); ++l) own[l] *= double(2 * l + 1) / (4 * kPi) * all[l];
        while (own.size() > 1 && std::abs(own.back()) < kLittle) own.pop_back();
        weights.push_back(std::move(own));
    }
    std::size_t terms = 1;
    for (const std::vector<double>& own : weights) terms = std::max(terms, own.size());
    parallelFor(kPhaseAngles, [&](std::size_t i) {
        const double cosine = cosineAt(static_cast<int>(i));
        double sums[kCaps] = {phaseValue(phase, cosine)};
        forLegendre(terms, cosine, [&](std::size_t l, double p) {
            for (std::size_t c = 0; c < weights.size(); ++c)
                if (l < weights[c].size()) sums[c + 1] += weights[c][l] * p;
        });
        for (std::size_t c = 0; c < kCaps; ++c) m_values[c * kRow + i] = static_cast<Real>(std::max(sums[c], 0.0));
    });
    for (std::size_t c = 0; c < kCaps; ++c) m_values[c * kRow + kPhaseAngles] = m_values[c * kRow + kPhaseAngles - 1];
}

std::pair<int, double> PhaseOverCaps::capOf(double halfAngle) const {
    const double at = std::sqrt(std::clamp(halfAngle / m_most, 0.0, 1.0)) * (kCaps - 1);
    const int cap = std::min(static_cast<int>(at), kCaps - 2);
    return {cap, at - cap};
}

double PhaseOverCaps::at(double cosine, double halfAngle) const {
    const auto [cap, part] = capOf(halfAngle);
    const Real* row = m_values.data() + std::ptrdiff_t(cap) * kRow;
    const double near = between(row, cosine);
    return near + part * (between(row + kRow, cosine) - near);
}

PhaseRow PhaseOverCaps::row(double halfAngle) const {
    const auto [cap, part] = capOf(halfAngle);
    const Real* near = m_values.data() + std::ptrdiff_t(cap) * kRow;
    PhaseRow row(kRow);
    for (int i = 0; i < kRow; ++i) row[std::size_t(i)] = near[i] + static_cast<Real>(part) * (near[i + kRow] - near[i]);
    return row;
}

CutPhase::CutPhase(const Phase& phase, double spacing) : row(kRow) {
    // Up to this many spacings a peak is replaced by a parabola that goes on as the phase function does there.
    constexpr double kSpacings = 1.5;
    const double edge = std::min(kSpacings * spacing, 0.5 * kPi);
    const auto cut = [&](double angle, double from, int side) {  // side: 1 straight on, -1 straight back
        const double step = 1e-4, at = phaseValue(phase, side * std::cos(from));
        const double slope = (phaseValue(phase, side * std::cos(from + step)) - at) / step;
        const double t = angle / from;
        return std::min(phaseValue(phase, side * std::cos(angle)), at - 0.5 * slope * from * (1 - t * t));
    };
    for (int i = 0; i < kPhaseAngles; ++i) {
        const double cosine = cosineAt(i), angle = std::acos(std::clamp(cosine, -1.0, 1.0)), back = kPi - angle;
        row[std::size_t(i)] = static_cast<Real>(angle < edge  ? cut(angle, edge, 1)
                                                : back < edge ? cut(back, edge, -1)
                                                              : phaseValue(phase, cosine));
    }
    row.back() = row[kPhaseAngles - 1];
    // The integrals over both halves of the sphere, in the variable whose entries are evenly apart.
    double onFront = 0, onBack = 0;
    std::vector<PeakRing> cutFront, cutBack;  // what is cut off, by entry
    for (int i = 0; i + 1 < kPhaseAngles; ++i) {
        const double a = cosineAt(i), b = cosineAt(i + 1), middle = 0.5 * (a + b);
        const double part = kPi * (a - b) * double(row[std::size_t(i)] + row[std::size_t(i + 1)]);
        (middle > 0 ? onFront : onBack) += part;
        const double above = 2 * kPi * (a - b) * phaseValue(phase, middle) - part;
        if (above > 0) (middle > 0 ? cutFront : cutBack).push_back({1 - std::abs(middle), above});
    }
    std::ranges::reverse(cutBack);
    onwards.rings = ringsOf(cutFront);
    backwards.rings = ringsOf(cutBack);
    // Of the phase function itself by its moments: the mean of P_l over a half is known.
    const std::vector<double> moments = legendreMoments(phase, 4096), half = capMoments(0.5 * kPi, 4096);
    double front = 0;
    for (std::size_t l = 0; l < moments.size(); ++l) front += 0.5 * double(2 * l + 1) * moments[l] * half[l];
    onwards.part = std::max(front - onFront, 0.0);
    backwards.part = std::max(1 - front - onBack, 0.0);
    // What is left must be kept: rounding and trapezoids took a little.
    const double rest = onFront + onBack, whole = 1 - onwards.part - backwards.part;
    for (Real& value : row) value *= static_cast<Real>(whole / std::max(rest, 1e-30));
}

double phaseIn(const PhaseRow& row, double cosine) {
    return between(row.data(), cosine);
}

}  // namespace scrim
