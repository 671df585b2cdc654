// SPDX-License-Identifier: Apache-2.0
// Errors as pictures: blue where a picture is too dark, orange where it is too bright, on one scale for all of them.
#pragma once

#include <scrim/image/colour.h>
#include <scrim/image/image.h>

namespace scrim {

/// Mean of R, G and B of `difference` over `scale`, in [-1, 1], as colour; white is no error. Every `stride`-th pixel
/// in both directions.
DisplayImage errorPicture(const Image& difference, double scale, int stride);

/// The scale: largest of the means but for the worst pixels, a thousandth of those that are not empty.
double errorScale(const Image& difference);

/// Every `stride`-th pixel of `picture`.
DisplayImage thinned(const DisplayImage& picture, int stride);

}  // namespace scrim
