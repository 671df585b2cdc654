// SPDX-License-Identifier: Apache-2.0
// Operations on a scan between its file and its grid: cropping, halving of axes, mapping of values.
#pragma once

#include "scan.h"

#include <optional>

namespace scan {

/// The samples `from` .. `to` - 1 only. Both must lie in the scan.
Scan cropped(const Scan& scan, const Size& from, const Size& to);

/// The scan with half as many samples along `axis`, each the mean of two; the last of an odd number stays unchanged.
Scan halved(const Scan& scan, int axis);

/// How a file's values become densities.
struct Mapping {
    double threshold = 0;                         ///< values up to this are empty
    std::optional<std::array<double, 2>> window;  ///< these values become 0 and 1; values beyond are clamped
    /// Values are only clamped to the window and keep their units; those up to its begin are empty.
    bool keepsUnits = false;
    double offset = 0;  ///< is added to values that keep their units
    double scale = 1;   ///< applied last
};

/// Applies `mapping`. NaN stays NaN.
void map(Scan& scan, const Mapping& mapping);

/// The least and the largest finite value; 0 and 0 where there is none.
std::array<double, 2> range(const Scan& scan);

}  // namespace scan
