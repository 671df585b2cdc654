// SPDX-License-Identifier: Apache-2.0
// Which pixels a verification looks at. Apart from how it judges them, because this is where a check goes blind: pixels
// that are drawn from what a picture shows never find what the picture lost.
#pragma once

#include <scrim/scene/view_scene.h>

#include <vector>

namespace scrim {

/// Every pixel of `truth.region` that may show something, each once, in the order in which they are looked at: those
/// whose rays meet the box of a volume's fields (from fields and camera alone, not from a plan), and those where
/// `image` is not 0. `truth` holds all volumes of the scene, those too that a plan would leave out.
///
/// Every beginning of the list is spread evenly over the picture, and every pixel is as likely as any other to be in
/// it: a sequence of van der Corput, scrambled with `seed` (A. Owen, 1995), along a Z-shaped curve through the pixels.
/// So the chance that the first N pixels of it hold none of a set that is a share f of all is at most about (1 - f)^N.
std::vector<Int2> verificationOrder(const ViewScene& truth, const Image& image, unsigned seed);

}  // namespace scrim
