// SPDX-License-Identifier: Apache-2.0
// Discrete ordinates (S_N): the directions that carry scattered light, and the scattering between them by a phase
// function (E. E. Lewis and W. F. Miller, Computational Methods of Neutron Transport, 1984).
#pragma once

#include <scrim/base/real.h>
#include <scrim/base/simd.h>
#include <scrim/geometry/spaces.h>
#include <scrim/scene/split_phase.h>

#include <cstddef>
#include <vector>

namespace scrim {

/// Unit directions of travel in world space, with the same number in every octant; weights are solid angles and sum to
/// 4 pi. Those of octant o (bit a: axis a is negative) are [o perOctant, (o + 1) perOctant). They are a product of
/// Gauss quadrature over the cosine to z and of equally spaced angles around z, with fewer near the poles.
struct Ordinates {
    int perOctant = 0;
    std::vector<Vec3> directions;
    std::vector<double> weights;

    /// The same for vectors: x, y, z and weight, one value for each ordinate.
    std::vector<Real> axes[3], weightRow;
    int parts = 1;  ///< of these this is one; weights of all parts together sum to 4 pi

    int count() const { return static_cast<int>(directions.size()); }
};

/// The possible numbers of ordinates: multiples of 64, which fill vectors of 8 lanes.
inline constexpr int kOrdinateCounts[] = {64, 128, 256};
inline constexpr std::size_t kMostOrdinates = kOrdinateCounts[2];

/// Throws Error(usage) for any other count.
Ordinates ordinates(int count);

/// Divides ordinates into `parts` sets, which have the same number in every octant, too.
std::vector<Ordinates> divided(const Ordinates& all, int parts);

/// The index of the ordinate closest to a unit vector.
int nearestOrdinate(const Ordinates& ordinates, const Vec3& direction);

/// The number of moments that ordinates resolve: products of two Legendre series of so many terms
/// are integrated exactly.
int resolvedMoments(int ordinates);

/// The radiance scattered into each ordinate m of `to` from unit radiance along each ordinate n of `from`, of which
/// there are as many, times that one's weight: w_n p(n -> m), where p has Legendre moments `moments`, at most
/// resolvedMoments() of `from`. The quadrature integrates it exactly, so columns sum to one, and rows if both sets are
/// one: energy is conserved, and uniform radiance stays uniform. All moments are those of the phase function.
///
/// Octants are mirror images of each other, so the matrix depends on the pair of octants only by the axes in which they
/// differ. Sums of a row over octants, with signs, are therefore scattered apart from each other. Kept are the eight
/// blocks for these sums, perOctant^2 values each, n before m, times 1/8: an eighth of the whole matrix.
std::vector<Real> scatteringMatrix(const Ordinates& from, const Ordinates& to, const std::vector<double>& moments);

/// The rows that are scattered together, because they share loads of a matrix.
inline constexpr std::size_t kRowsTogether = 4;

// Scattering between ordinates is the most expensive part of media that are not isotropic: from all
// ordinates to all, and from or to a direction that is not an ordinate.

/// Multiplies rows [begin, end) of `rows`, `count` values each, by the matrices (see scatteringMatrix), mixed by
/// `shares`: shares[k][row] is the weight of matrix k; empty: there is one matrix.
void mixOrdinates(const std::vector<std::vector<Real>>& matrices, const std::vector<std::vector<Real>>& shares,
                  std::size_t begin, std::size_t end, std::size_t count, Real* rows, Simd simd);

/// The phase function with Legendre moments `moments` for light that travels along `travel` (unit)
/// and is scattered into each ordinate; the sum with the ordinates' weights is one. Since p is
/// symmetric in its two directions, these values times the weights are also what a ray along
/// `travel` gathers from all ordinates. A series may go below zero. `part`: a factor on all values.
void scatteringRow(const Ordinates& ordinates, const std::vector<double>& moments, const Vec3& travel, Real* row,
                   Simd simd, double part = 1);

/// The weighted sum of a row of radiance along ordinates.
Real gathered(const Ordinates& ordinates, const Real* scattering, const Real* radiance, Simd simd);

/// Ordinates by which an eye, which light reaches along `travel`, sees the light that continues straight on
/// (SplitPhase): a lobe around `travel`, to be divided by its sum with the weights of all parts of a set. Legendre's
/// series of light along `travel`, cut off after `moments` moments, would oscillate in all directions: of ten moments,
/// this series and SplitPhase::first() for g = 0.9 add up to -6 times the phase function in the backward direction.
/// With the lobe and SplitPhase::first(), the differences to 1,024 ordinates, in smoke of g = 0.9 lit from the eye's
/// side, from aside and from behind, became 1.5, 1.3 and 2.3 % with 256 ordinates (before: 7.1, 2.6 and 2.4 %), and for
/// g = 0.75 0.8, 1.3 and 1.6 % with 64 (1.3, 1.7 and 1.7 %).
void lobeRow(const Ordinates& ordinates, std::size_t moments, const Vec3& travel, Real* row, Simd simd);

}  // namespace scrim
