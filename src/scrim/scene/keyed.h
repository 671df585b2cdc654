// SPDX-License-Identifier: Apache-2.0
// Values that change over frames: keys and the interpolation between them.
#pragma once

#include <scrim/geometry/spaces.h>

#include <utility>
#include <vector>

namespace scrim {

enum class Interpolation {
    linear,
    /// Monotone cubic interpolation with a continuous first derivative, which is 0 at the first and last key; outside
    /// of them the value is constant. It never overshoots the two keys around a frame.
    smooth,
};

/// `T` is double or Vec3, whose components are interpolated separately.
template <typename T>
struct Keyed {
    std::vector<std::pair<double, T>> keys;  ///< frame and value; at least one, frames ascending
    Interpolation interpolation = Interpolation::linear;

    /// The value at `frame`. Outside of the keys' range it is that of the nearest key.
    T at(double frame) const;
};

extern template struct Keyed<double>;
extern template struct Keyed<Vec3>;

}  // namespace scrim
