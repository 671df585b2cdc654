// SPDX-License-Identifier: Apache-2.0
// Pixel windows in test output.
#pragma once

#include <scrim/image/image.h>

#include <ostream>

namespace scrim {

inline std::ostream& operator<<(std::ostream& out, const PixelWindow& w) {
    return out << "[" << w.x0 << ", " << w.x1 << ") x [" << w.y0 << ", " << w.y1 << ")";
}

}  // namespace scrim
