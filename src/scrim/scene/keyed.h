// SPDX-License-Identifier: Apache-2.0
// Values that change over frames: keys, and what lies between them.
#pragma once

#include <scrim/geometry/spaces.h>

#include <utility>
#include <vector>

namespace scrim {

enum class Interpolation {
    linear,
    /// Monotone cubic: continuous in its first derivative everywhere (it comes to rest at the first and last
    /// key, outside of which the value is constant), and never beyond the two keys around it.
    smooth,
};

/// `T` is double or Vec3 (each component by itself).
template <typename T>
struct Keyed {
    std::vector<std::pair<double, T>> keys;  ///< frame and value; at least one, frames ascending
    Interpolation interpolation = Interpolation::linear;

    /// The value at `frame`: that of the nearest key outside of the keys' range.
    T at(double frame) const;
};

extern template struct Keyed<double>;
extern template struct Keyed<Vec3>;

}  // namespace scrim
