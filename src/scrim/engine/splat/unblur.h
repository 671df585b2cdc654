// SPDX-License-Identifier: Apache-2.0
// Makes up for the blur of the look-ups to come.
//
// Views look sheets up between texels, bilinearly. Over all positions between texels that adds, on average, a
// twelfth of the second difference along each axis: a blur that every view sees and that does not average out. Taking
// it away beforehand leaves an error that changes sign from texel to texel and sheet to sheet, and does average out
// along a ray (quasi-interpolation; compare T. Blu, P. Thevenaz, M. Unser, "Linear Interpolation Revitalized", IEEE
// Transactions on Image Processing, 2004). Constant and linear fields stay as they are.
#pragma once

#include <scrim/engine/splat/plane_stack.h>

namespace scrim {

/// Sharpens plane p (of one channel, finished) in place: f - 1/12 (second differences along u and v), but not below 0.
void unblur(PlaneStack& planes, int p);

}  // namespace scrim
