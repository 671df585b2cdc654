// SPDX-License-Identifier: Apache-2.0
// Discrete ordinates (S_N): the directions that carry scattered light, and the scattering between them by a phase
// function (E. E. Lewis and W. F. Miller, Computational Methods of Neutron Transport, 1984).
#pragma once

#include <scrim/base/real.h>
#include <scrim/geometry/spaces.h>
#include <scrim/scene/medium.h>

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

    int count() const { return static_cast<int>(directions.size()); }
};

/// The possible numbers of ordinates: multiples of 64, which fill vectors of 8 lanes.
inline constexpr int kOrdinateCounts[] = {64, 128, 256};

/// Throws Error(usage) for any other count.
Ordinates ordinates(int count);

/// The index of the ordinate closest to a unit vector.
int nearestOrdinate(const Ordinates& ordinates, const Vec3& direction);

/// The radiance scattered into each ordinate from unit radiance along each other one, times that one's weight: the
/// value at [n count + m] is w_n p(n -> m). Rows and columns sum to one, so that energy is conserved and uniform
/// radiance stays uniform. The mean cosine is the phase function's: a lobe narrower than the spacing of ordinates keeps
/// its light nearly straight on.
std::vector<Real> scatteringMatrix(const Ordinates& ordinates, const Phase& phase);

}  // namespace scrim
