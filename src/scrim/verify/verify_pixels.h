// SPDX-License-Identifier: Apache-2.0
// Chooses the pixels that a verification examines. This is separate from judging them, because the choice is where a
// check can go blind: pixels drawn from what a picture shows never find what the picture lost.
#pragma once

#include <scrim/scene/view_scene.h>

#include <vector>

namespace scrim {

/// Every pixel of `truth.region` that may show something, once each, in the order in which they are examined. These are
/// the pixels whose rays meet the box of a volume's field (known from fields and camera alone, not from a plan) and
/// those where `image` is not 0. `truth` holds all volumes of the scene, including those that a plan would leave out.
///
/// Every prefix of the list is spread evenly over the picture, and every pixel is equally likely to
/// be in it: the order is a van der Corput sequence scrambled with `seed` (A. Owen, 1995), along a
/// Z-shaped curve through the pixels. Therefore the probability that the first N pixels contain
/// none of a set that is a fraction f of all is at most about (1 - f)^N.
///
/// If `edge` is above 1, squares of `edge` x `edge` pixels take the place of pixels. They cover the
/// picture, and each is given by its corner, whose coordinates are multiples of `edge`.
std::vector<Int2> verificationOrder(const ViewScene& truth, const Image& image, unsigned seed, int edge = 1);

}  // namespace scrim
