// SPDX-License-Identifier: Apache-2.0
// The number type of the engine, from footprints to pixels: float. The CMake option SCRIM_DOUBLE makes it double, for a
// build that measures how much of a picture is rounding (tests/truth/precision/run.sh) and is not meant for rendering.
// Inputs of a render (voxels, pixels of slides) and its results are float either way.
#pragma once

#include <cstdint>

namespace scrim {

#ifdef SCRIM_DOUBLE
using Real = double;
using RealIndex = std::int64_t;  ///< an integer as wide, as vectors of indices have them
static_assert(sizeof(Real) == 8);
#else
using Real = float;
using RealIndex = std::int32_t;  ///< an integer as wide, as vectors of indices have them
#endif
static_assert(sizeof(Real) == sizeof(RealIndex));

}  // namespace scrim
