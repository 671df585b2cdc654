// SPDX-License-Identifier: Apache-2.0
// A render and its error against the brute-force reference.
#pragma once

#include "support/fields.h"

#include <scrim/study/verify.h>

namespace scrim::test {

/// Relative RMSE of `frame` at `pixels` random pixels, always the same ones for equal pictures' shapes.
inline Verification verified(const ViewScene& scene, const Frame& frame, int pixels) {
    return summarise(samplePixels(scene, frame.image, pixels, 7));
}

inline double errorOf(const ViewScene& scene, int pixels) {
    return verified(scene, renderScene(scene), pixels).error;
}

}  // namespace scrim::test
