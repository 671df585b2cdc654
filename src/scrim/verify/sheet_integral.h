// SPDX-License-Identifier: Apache-2.0
// Light through one sheet in closed form (algorithm, section 6).
//
// Over the segment of an eye ray inside a sheet, extinction and albedo are constant. Light enters
// the sheet after an optical depth tau_in and loses another tau_l on its way through the sheet; the
// eye ray loses tau_e. The in-scattered radiance is rho E p times tau_e times
//
//     transmit = e^-tau_in * phi,   phi = integral over x in [0, 1] of e^-(tau_l x) e^-(tau_e y) dx,
//
// where x runs with the light, and y = x where eye and light enter on the same side, else y = 1 - x. In the first case
// phi = psi(tau_e + tau_l), in the second phi = e^-min(tau_e, tau_l) psi(|tau_e - tau_l|), with psi(t) = (1 - e^-t) /
// t. No difference of nearly equal exponentials is ever taken. The result is exact for slabs at any tau.
//
// This header is the plain double version for tests and for the reference; the engine's is vectorised.
#pragma once

#include <algorithm>
#include <cmath>

namespace scrim {

/// (1 - e^-t) / t for t >= 0, and 1 at 0.
inline double psi(double t) {
    return t > 0 ? -std::expm1(-t) / t : 1.0;
}

/// phi as defined above. `sameSide`: the eye ray enters the sheet on the side where the light enters it.
inline double sheetTransmit(double tauEye, double tauLight, bool sameSide) {
    if (sameSide) return psi(tauEye + tauLight);
    return std::exp(-std::min(tauEye, tauLight)) * psi(std::abs(tauEye - tauLight));
}

}  // namespace scrim
