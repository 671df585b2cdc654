// SPDX-License-Identifier: Apache-2.0
// Light through one sheet, in closed form (algorithm, section 6).
//
// Over the segment of an eye ray inside a sheet, extinction and albedo are constant. Light enters the sheet
// having passed tau_in, loses another tau_l on its way through; the eye's ray loses tau_e. The in-scattered
// radiance is rho E p times tau_e times
//
//     transmit = e^-tau_in * phi,   phi = integral over x in [0, 1] of e^-(tau_l x) e^-(tau_e y) dx,
//
// where x runs with the light and y = x where eye and light enter on the same side, y = 1 - x otherwise.
// phi = psi(tau_e + tau_l) in the first case and e^-min(tau_e, tau_l) psi(|tau_e - tau_l|) in the second, with
// psi(t) = (1 - e^-t) / t: no difference of nearly equal exponentials is ever taken. Exact for slabs at any tau.
//
// This header is the plain double version, for tests and for the reference; the engine's is vectorised.
#pragma once

#include <algorithm>
#include <cmath>

namespace scrim {

/// (1 - e^-t) / t for t >= 0; 1 at 0.
inline double psi(double t) {
    return t > 0 ? -std::expm1(-t) / t : 1.0;
}

/// phi of the text above. `sameSide`: the eye meets the light's near side of the sheet first.
inline double sheetTransmit(double tauEye, double tauLight, bool sameSide) {
    if (sameSide) return psi(tauEye + tauLight);
    return std::exp(-std::min(tauEye, tauLight)) * psi(std::abs(tauEye - tauLight));
}

}  // namespace scrim
