// SPDX-License-Identifier: Apache-2.0
// Sizes of sheets and rasters, checked before they become whole numbers: a transform that squeezes one axis to a
// millionth asks for millions of sheets, or for more than an int holds.
#pragma once

#include <string>

namespace scrim {

/// Sheets in a sweep, or texels along a raster's side, at most.
constexpr int kMostAddressed = 1 << 20;

/// `count`, rounded up. Throws Error(render) where it is more than kMostAddressed, naming `what` it counts.
int addressable(double count, const std::string& what);

}  // namespace scrim
