// SPDX-License-Identifier: Apache-2.0
// What the eye sees of a spectrum: the CIE 1931 2-degree observer, and its XYZ in the working space.
#pragma once

#include <scrim/geometry/spaces.h>
#include <scrim/image/colour.h>

#include <span>

namespace scrim {

inline constexpr double kFirstWavelength = 380, kWavelengthStep = 10;  ///< of the observer, nm

/// The CIE's colour-matching functions x, y and z, from kFirstWavelength to 780 nm.
std::span<const Vec3> observer();

/// The matrix from CIE XYZ (the white of D65 becomes [1, 1, 1]) to the working space. Throws Error(input) where the
/// config has neither linear Rec.709 nor ACES2065-1, from which the conversion is known.
Mat3 workingFromXyz(const ColourConfig& config);

}  // namespace scrim
