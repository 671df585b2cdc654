// SPDX-License-Identifier: Apache-2.0
// Scattering between ordinates, which is the most expensive part of media that are not isotropic: from all ordinates to
// all, and from or to a direction that is not an ordinate.
#pragma once

#include <scrim/base/real.h>
#include <scrim/base/simd.h>
#include <scrim/engine/transport/ordinates.h>

#include <cstddef>
#include <vector>

namespace scrim {

/// Multiplies rows [begin, end) of `rows`, `count` values each, by the matrices (see scatteringMatrix), mixed by
/// `shares`: shares[k][row] is the weight of matrix k; empty: there is one matrix.
void mixOrdinates(const std::vector<std::vector<Real>>& matrices, const std::vector<std::vector<Real>>& shares,
                  std::size_t begin, std::size_t end, std::size_t count, Real* rows, Simd simd);

/// The phase function for light that travels along `travel` (unit) and is scattered into each ordinate, scaled so that
/// its sum with the ordinates' weights is one. Since p is symmetric in its two directions, these values times the
/// weights are also what a ray along `travel` gathers from all ordinates.
void scatteringRow(const Ordinates& ordinates, const Phase& phase, const Vec3& travel, Real* row, Simd simd);

/// The weighted sum of a row of radiance along ordinates.
Real gathered(const Ordinates& ordinates, const Real* scattering, const Real* radiance, Simd simd);

}  // namespace scrim
