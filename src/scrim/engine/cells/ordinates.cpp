// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/cells/ordinates.h>

#include <scrim/base/error.h>
#include <scrim/base/legendre.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <utility>

#include <fmt/format.h>
#include <glm/geometric.hpp>

#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "scrim/engine/cells/ordinates.cpp"
#include <hwy/foreach_target.h>
#include <scrim/engine/simd-inl.h>
#include <scrim/base/parallel.h>

HWY_BEFORE_NAMESPACE();
namespace scrim {
namespace HWY_NAMESPACE {

// The sums of a row over octants with signs, all eight of them: the value at octant `o` of the result is the sum over
// octants p of (-1)^(bits in both o and p) times that at p. Twice applied, this gives the row times 8.
HWY_ATTR void signedSums(const Real* row, std::size_t perOctant, Real* to) {
    const D8 d;
    for (std::size_t m = 0; m < perOctant; m += hn::Lanes(d)) {
        const auto at = [&](std::size_t octant) HWY_ATTR { return hn::LoadU(d, row + octant * perOctant + m); };
        for (std::size_t half = 0; half < 2; ++half) {
            const auto pair = [&](std::size_t octant) HWY_ATTR {
                const auto a = at(octant), b = at(octant + 1);
                return half == 0 ? hn::Add(a, b) : hn::Sub(a, b);
            };
            const auto p0 = pair(0), p1 = pair(2), p2 = pair(4), p3 = pair(6);
            const auto a = hn::Add(p0, p1), b = hn::Add(p2, p3), e = hn::Sub(p0, p1), f = hn::Sub(p2, p3);
            Real* out = to + half * perOctant + m;
            hn::StoreU(hn::Add(a, b), d, out);
            hn::StoreU(hn::Add(e, f), d, out + 2 * perOctant);
            hn::StoreU(hn::Sub(a, b), d, out + 4 * perOctant);
            hn::StoreU(hn::Sub(e, f), d, out + 6 * perOctant);
        }
    }
}

// Adds factor times the product of one octant's block and of the rows' values there, `kVectors` vectors of each row.
template <std::size_t kVectors>
HWY_ATTR HWY_INLINE void addProduct(const Real* column, std::size_t perOctant, const Real* from, const Real* factors,
                                    std::size_t stride, Real* to) {
    const D8 d;
    const std::size_t lanes = hn::Lanes(d);
    hn::Vec<D8> sums[kRowsTogether][kVectors];
    for (auto& row : sums)
        for (auto& sum : row) sum = hn::Zero(d);
    for (std::size_t n = 0; n < perOctant; ++n, column += perOctant) {
        hn::Vec<D8> weights[kVectors];
        for (std::size_t v = 0; v < kVectors; ++v) weights[v] = hn::LoadU(d, column + v * lanes);
        for (std::size_t r = 0; r < kRowsTogether; ++r) {
            const auto value = hn::Set(d, from[r * stride + n]);
            for (std::size_t v = 0; v < kVectors; ++v) sums[r][v] = hn::MulAdd(weights[v], value, sums[r][v]);
        }
    }
    for (std::size_t r = 0; r < kRowsTogether; ++r)
        for (std::size_t v = 0; v < kVectors; ++v) {
            Real* out = to + r * stride + v * lanes;
            hn::StoreU(hn::MulAdd(hn::Set(d, factors[r]), sums[r][v], hn::LoadU(d, out)), d, out);
        }
}

HWY_ATTR void multiplyRows(const Real* matrix, std::size_t count, const Real* from, const Real* factors, Real* to) {
    const std::size_t lanes = hn::Lanes(D8()), perOctant = count / 8;
    for (std::size_t first = 0; first < count; first += perOctant, matrix += perOctant * perOctant) {
        if (perOctant == lanes) {
            addProduct<1>(matrix, perOctant, from + first, factors, count, to + first);
            continue;
        }
        for (std::size_t m = 0; m < perOctant; m += 2 * lanes)
            addProduct<2>(matrix + m, perOctant, from + first, factors, count, to + first + m);
    }
}

// Fills a row with a Legendre series times 4 pi.
HWY_ATTR void fillRow(const Ordinates& ordinates, const Real* moments, std::size_t count, const Vec3& travel,
                      Real* row) {
    const D8 d;
    const auto x = hn::Set(d, static_cast<Real>(travel.x)), y = hn::Set(d, static_cast<Real>(travel.y));
    const auto z = hn::Set(d, static_cast<Real>(travel.z));
    for (std::size_t m = 0; m < std::size_t(ordinates.count()); m += hn::Lanes(d)) {
        const auto cosine = hn::MulAdd(x, hn::LoadU(d, ordinates.axes[0].data() + m),
                                       hn::MulAdd(y, hn::LoadU(d, ordinates.axes[1].data() + m),
                                                  hn::Mul(z, hn::LoadU(d, ordinates.axes[2].data() + m))));
        auto value = hn::Zero(d), before = hn::Zero(d), polynomial = hn::Set(d, Real(1));
        for (std::size_t l = 0; l < count; ++l) {
            value = hn::MulAdd(hn::Set(d, static_cast<Real>(2 * l + 1) * moments[l]), polynomial, value);
            const auto n = static_cast<Real>(l);
            const auto next = hn::Mul(hn::Set(d, 1 / (n + 1)), hn::MulSub(hn::Mul(hn::Set(d, 2 * n + 1), cosine),
                                                                          polynomial, hn::Mul(hn::Set(d, n), before)));
            before = polynomial;
            polynomial = next;
        }
        hn::StoreU(value, d, row + m);
    }
}

// Fills a row with a lobe around `travel`: the series that is a line with ever more terms, times a power of (1 +
// cosine) / 2. That takes away its waves far from the line, and leaves its low moments.
HWY_ATTR void fillLobe(const Ordinates& ordinates, const Real* ones, std::size_t count, const Vec3& travel, Real* row) {
    const D8 d;
    fillRow(ordinates, ones, count, travel, row);
    const auto x = hn::Set(d, static_cast<Real>(0.5 * travel.x)), y = hn::Set(d, static_cast<Real>(0.5 * travel.y));
    const auto z = hn::Set(d, static_cast<Real>(0.5 * travel.z)), half = hn::Set(d, Real(0.5));
    for (std::size_t m = 0; m < std::size_t(ordinates.count()); m += hn::Lanes(d)) {
        auto window = hn::MulAdd(x, hn::LoadU(d, ordinates.axes[0].data() + m),
                                 hn::MulAdd(y, hn::LoadU(d, ordinates.axes[1].data() + m),
                                            hn::MulAdd(z, hn::LoadU(d, ordinates.axes[2].data() + m), half)));
        for (int power = 1; power < ordinates.parts * ordinates.count() / 16; power *= 2)
            window = hn::Mul(window, window);
        hn::StoreU(hn::Mul(window, hn::LoadU(d, row + m)), d, row + m);
    }
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

HWY_EXPORT(signedSums);
HWY_EXPORT(multiplyRows);
HWY_EXPORT(fillRow);
HWY_EXPORT(fillLobe);
HWY_EXPORT(weightedSum);

namespace {

constexpr double kPi = std::numbers::pi;
constexpr std::size_t kMostResolved = 32;  // moments

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

}  // namespace

Ordinates ordinates(int count) {
    const std::vector<int> angles = anglesOf(count);
    const std::vector<QuadraturePoint> levels = gaussLegendre(2 * static_cast<int>(angles.size()));
    Ordinates out;
    out.perOctant = count / 8;
    for (int octant = 0; octant < 8; ++octant)
        for (std::size_t level = 0; level < angles.size(); ++level)
            for (int a = 0; a < angles[level]; ++a) {
                const double z = levels[level].x, across = std::sqrt(1 - z * z);
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

std::vector<Ordinates> divided(const Ordinates& all, int parts) {
    std::vector<Ordinates> sets(static_cast<std::size_t>(parts));
    for (Ordinates& set : sets) {
        set.perOctant = all.perOctant / parts;
        set.parts = parts;
    }
    for (std::size_t m = 0; m < all.directions.size(); ++m) {
        Ordinates& set = sets[m % std::size_t(parts)];  // an octant has a multiple of `parts`
        set.directions.push_back(all.directions[m]);
        set.weights.push_back(all.weights[m]);
        for (int axis = 0; axis < 3; ++axis) set.axes[axis].push_back(all.axes[axis][m]);
        set.weightRow.push_back(all.weightRow[m]);
    }
    return sets;
}

int nearestOrdinate(const Ordinates& ordinates, const Vec3& direction) {
    int best = 0;
    for (int m = 1; m < ordinates.count(); ++m)
        if (glm::dot(ordinates.directions[std::size_t(m)], direction) >
            glm::dot(ordinates.directions[std::size_t(best)], direction))
            best = m;
    return best;
}

int resolvedMoments(int ordinates) {
    return 2 * static_cast<int>(anglesOf(ordinates).size());
}

std::vector<Real> scatteringMatrix(const Ordinates& from, const Ordinates& to, const std::vector<double>& moments) {
    const auto perOctant = std::size_t(from.perOctant);
    std::vector<Real> out(8 * perOctant * perOctant);
    parallelFor(perOctant, [&](std::size_t n) {
        for (std::size_t m = 0; m < perOctant; ++m) {
            double values[8];  // from the first octant to each
            for (std::size_t octant = 0; octant < 8; ++octant) {
                values[octant] = 0;
                const double cosine = glm::dot(from.directions[n], to.directions[octant * perOctant + m]);
                forLegendre(moments.size(), cosine, [&](std::size_t l, double p) {
                    values[octant] += from.weights[n] * (2 * double(l) + 1) * moments[l] * p / (4 * kPi);
                });
            }
            for (unsigned signs = 0; signs < 8; ++signs) {
                double sum = 0;
                for (unsigned octant = 0; octant < 8; ++octant)
                    sum += (std::popcount(signs & octant) % 2 == 0 ? 1 : -1) * values[octant];
                out[(signs * perOctant + n) * perOctant + m] = static_cast<Real>(sum / 8);
            }
        }
    });
    return out;
}

void mixOrdinates(const std::vector<std::vector<Real>>& matrices, const std::vector<std::vector<Real>>& shares,
                  std::size_t begin, std::size_t end, std::size_t count, Real* rows, Simd simd) {
    const auto multiply = SCRIM_ON_TARGET(simd, multiplyRows);
    const auto sums = SCRIM_ON_TARGET(simd, signedSums);
    std::array<Real, kRowsTogether * kMostOrdinates> turned, scattered;
    for (std::size_t row = begin; row < end; row += kRowsTogether) {
        const std::size_t here = std::min(kRowsTogether, end - row);
        for (std::size_t r = 0; r < kRowsTogether; ++r)
            sums(rows + (row + std::min(r, here - 1)) * count, count / 8, turned.data() + r * count);
        std::fill_n(scattered.data(), kRowsTogether * count, Real(0));
        for (std::size_t k = 0; k < matrices.size(); ++k) {
            Real factors[kRowsTogether];
            for (std::size_t r = 0; r < kRowsTogether; ++r)
                factors[r] = shares.empty() ? Real(1) : shares[k][row + std::min(r, here - 1)];
            multiply(matrices[k].data(), count, turned.data(), factors, scattered.data());
        }
        for (std::size_t r = 0; r < here; ++r) sums(scattered.data() + r * count, count / 8, rows + (row + r) * count);
    }
}

void scatteringRow(const Ordinates& ordinates, const std::vector<double>& moments, const Vec3& travel, Real* row,
                   Simd simd, double part) {
    std::array<Real, kMostResolved> scaled;
    for (std::size_t l = 0; l < moments.size(); ++l) scaled[l] = static_cast<Real>(moments[l] * part / (4 * kPi));
    SCRIM_ON_TARGET(simd, fillRow)(ordinates, scaled.data(), moments.size(), travel, row);
}

void lobeRow(const Ordinates& ordinates, std::size_t moments, const Vec3& travel, Real* row, Simd simd) {
    static constexpr std::array<Real, kMostResolved> kOnes = [] {
        std::array<Real, kMostResolved> ones{};
        ones.fill(1);
        return ones;
    }();
    SCRIM_ON_TARGET(simd, fillLobe)(ordinates, kOnes.data(), moments, travel, row);
}

Real gathered(const Ordinates& ordinates, const Real* scattering, const Real* radiance, Simd simd) {
    return SCRIM_ON_TARGET(simd, weightedSum)(ordinates, scattering, radiance);
}

}  // namespace scrim
#endif
