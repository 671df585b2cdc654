// SPDX-License-Identifier: Apache-2.0
// Scattering between ordinates, the dearest part of media that are not isotropic: from all into all, and from or into a
// direction that is none of them.
#pragma once

#include <scrim/base/real.h>
#include <scrim/base/simd.h>
#include <scrim/engine/transport/ordinates.h>

#include <cstddef>
#include <vector>

namespace scrim {

/// Rows [begin, end) of `rows`, `count` values each, times the matrices (see scatteringMatrix), mixed as `shares` says:
/// shares[k][row] of matrix k; empty: there is one matrix.
void mixOrdinates(const std::vector<std::vector<Real>>& matrices, const std::vector<std::vector<Real>>& shares,
                  std::size_t begin, std::size_t end, std::size_t count, Real* rows, Simd simd);

/// What of light that travels along `travel` (unit) is scattered into each ordinate: the phase function there, scaled
/// so that with the weights it sums to one. As p is even in its two directions, these times the weights are also what a
/// ray gathers of all ordinates that carries light along `travel`.
void scatteringRow(const Ordinates& ordinates, const Phase& phase, const Vec3& travel, Real* row, Simd simd);

/// Weighted sum of an ordinates' row of radiance.
Real gathered(const Ordinates& ordinates, const Real* scattering, const Real* radiance, Simd simd);

}  // namespace scrim
