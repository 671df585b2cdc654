// SPDX-License-Identifier: Apache-2.0
// What is done to a scan between its file and its grid: parts cut out, axes halved, values mapped.
#pragma once

#include "scan.h"

#include <optional>

namespace scan {

/// The samples `from` .. `to` - 1 alone. Both must lie in the scan.
Scan cropped(const Scan& scan, const Size& from, const Size& to);

/// Half as many samples along `axis`, each the mean of two; the last of an odd number stays as it is.
Scan halved(const Scan& scan, int axis);

/// How a file's values become densities.
struct Mapping {
    double threshold = 0;                         ///< values up to this are empty
    std::optional<std::array<double, 2>> window;  ///< these become 0 and 1; values beyond are clamped
    bool keepsUnits = false;                      ///< they are clamped only; values up to the window's begin are empty
    double scale = 1;                             ///< at last
};

/// Applies `mapping`. What is not a number stays so.
void map(Scan& scan, const Mapping& mapping);

/// The least and the largest finite value; 0 and 0 where there is none.
std::array<double, 2> range(const Scan& scan);

}  // namespace scan
