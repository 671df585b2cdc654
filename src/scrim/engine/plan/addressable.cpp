// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/plan/addressable.h>

#include <scrim/base/error.h>

#include <cmath>

#include <fmt/format.h>

namespace scrim {

int addressable(double count, const std::string& what) {
    if (count <= kMostAddressed) return static_cast<int>(std::ceil(count));  // a NaN is refused
    throw Error(
        ErrorKind::render,
        fmt::format("a sweep would have {:.3g} {}, at most {} can be addressed; texel and sheet_thickness are in units "
                    "of the smallest voxel edge: raise them, or stretch the volumes less",
                    count, what, kMostAddressed));
}

}  // namespace scrim
