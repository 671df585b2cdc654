// SPDX-License-Identifier: Apache-2.0
// Phase functions beside light that comes from a solid angle. A sub-light of a sky, of a sun's disk or of a surface
// stands for all directions nearby. Where a lobe is narrower than that, its value in one direction says little: it
// shows the sub-lights as dots, and even light as too bright or too dark.
#pragma once

#include <scrim/base/real.h>
#include <scrim/scene/medium.h>

#include <vector>

namespace scrim {

/// The angle, radians, that the narrowest lobe of a phase function is about as wide as: 1 - |g|; pi if it has none.
double lobeWidth(const Phase& phase);

/// True if the mean of a phase function over a cap of this half angle (radians) differs from its value in the middle.
bool needsCaps(const Phase& phase, double halfAngle);
/// Points of surfaces serve lobes that are about as wide as what they stand for; directions of
/// skies do not. For surfaces this part of the half angle is to be asked.
inline constexpr double kCapsOfSurfaces = 0.4;

/// A function of the angle t between two directions, tabulated over the fourth root of (1 - cos t)
/// / 2, which is dense where lobes are. It is linear between entries.
inline constexpr int kPhaseAngles = 512;
using PhaseRow = std::vector<Real>;  ///< kPhaseAngles values, and one more for vectors to read

/// The mean of a phase function over caps of the unit sphere, by the angle of their middle and their half angle.
class PhaseOverCaps {
  public:
    static constexpr int kCaps = 16;

    /// For half angles up to `most`, in (0, pi/2].
    PhaseOverCaps(const Phase& phase, double most);

    double most() const { return m_most; }
    double at(double cosine, double halfAngle) const;
    /// That of all caps of one half angle.
    PhaseRow row(double halfAngle) const;
    /// [cap][angle]: rows of kPhaseAngles + 1; cap c has the half angle most (c / (kCaps - 1))^2.
    const Real* values() const { return m_values.data(); }

  private:
    std::pair<int, double> capOf(double halfAngle) const;

    double m_most;
    std::vector<Real> m_values;
};

/// A ring of directions around straight on or straight back.
struct PeakRing {
    double depth = 0;  ///< 1 - cos of its angle; 0: the middle alone
    double part = 0;   ///< of the peak
};

/// A phase function whose peaks, straight on and straight back, are cut off where they are narrower than directions
/// that are `spacing` radians apart resolve. What is cut off counts as light from there.
struct CutPhase {
    CutPhase(const Phase& phase, double spacing);

    struct Peak {
        double part = 0;              ///< of the scattered light: what is cut off
        std::vector<PeakRing> rings;  ///< what stands for it, from the middle outwards; their parts sum to 1
    };

    PhaseRow row;  ///< the rest, whose integral over the sphere is 1 less the parts of both peaks
    Peak onwards, backwards;
};

/// The value of a row at an angle with this cosine.
double phaseIn(const PhaseRow& row, double cosine);

}  // namespace scrim
