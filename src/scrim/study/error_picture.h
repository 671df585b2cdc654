// SPDX-License-Identifier: Apache-2.0
// Errors as pictures: blue where a picture is too dark, orange where it is too bright, all on one scale.
#pragma once

#include <scrim/image/colour.h>
#include <scrim/image/image.h>

namespace scrim {

/// The mean of R, G and B of `difference`, divided by `scale` and clamped to [-1, 1], as a colour;
/// white is no error. Only every `stride`-th pixel in both directions is used.
DisplayImage errorPicture(const Image& difference, double scale, int stride);

/// The scale for errorPicture: the largest mean after leaving out the worst thousandth of the
/// pixels that are not empty.
double errorScale(const Image& difference);

/// Every `stride`-th pixel of `picture`.
DisplayImage thinned(const DisplayImage& picture, int stride);

}  // namespace scrim
