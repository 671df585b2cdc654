// SPDX-License-Identifier: Apache-2.0
// Discrete ordinates (S_N): the directions that scattered light is carried along, and what a phase function makes of
// light between them (E. E. Lewis and W. F. Miller, Computational Methods of Neutron Transport, 1984).
#pragma once

#include <scrim/base/real.h>
#include <scrim/geometry/spaces.h>
#include <scrim/scene/medium.h>

#include <vector>

namespace scrim {

/// Directions of travel, unit, world space, as many in every octant; weights are solid angles and sum to 4 pi. Those of
/// octant o (bit a: does axis a point down?) are [o perOctant, (o + 1) perOctant). A product of Gauss' quadrature over
/// the cosine to z and of even angles around it, fewer near the poles.
struct Ordinates {
    int perOctant = 0;
    std::vector<Vec3> directions;
    std::vector<double> weights;

    /// The same for vectors: x, y, z and weight, one value an ordinate each.
    std::vector<Real> axes[3], weightRow;

    int count() const { return static_cast<int>(directions.size()); }
};

/// The numbers of ordinates that there are: multiples of 64, which fill vectors of 8 lanes.
inline constexpr int kOrdinateCounts[] = {64, 128, 256};

/// Throws Error(usage) on another count than these.
Ordinates ordinates(int count);

/// The ordinate that is nearest to a unit vector.
int nearestOrdinate(const Ordinates& ordinates, const Vec3& direction);

/// What is scattered into each ordinate of unit radiance along each other one, times that one's weight: the value at
/// [n count + m] is w_n p(n -> m). Rows and columns sum to one, so that no energy drifts and an even glow stays one,
/// and the mean cosine is the phase function's: a lobe that is narrower than the ordinates are apart keeps its light
/// nearly straight on.
std::vector<Real> scatteringMatrix(const Ordinates& ordinates, const Phase& phase);

}  // namespace scrim
