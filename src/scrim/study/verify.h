// SPDX-License-Identifier: Apache-2.0
// Checks a finished picture against the brute-force reference at random pixels.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/image/image.h>
#include <scrim/render/view_scene.h>

#include <array>
#include <span>
#include <vector>

namespace scrim {

/// One pixel, rendered and true: premultiplied RGBA.
struct VerifiedPixel {
    int x = 0, y = 0;
    std::array<double, 4> rendered{}, reference{};
};

/// Relative RMSE: RMS of the difference over R, G and B, over the pixels whose reference alpha exceeds 1e-3,
/// divided by the mean of the reference there.
struct Verification {
    int pixels = 0;    ///< that counted
    double error = 0;  ///< relative RMSE, 0 where no pixel counted
    double lower = 0;  ///< 95 % confidence interval of it, by bootstrap over the pixels
    double upper = 0;
    double bias = 0;   ///< mean difference over mean reference
    double worst = 0;  ///< largest RMS difference of one pixel over the mean reference
    int worstX = 0, worstY = 0;
};

/// Draws `count` pixels at random with `seed` from those of `image` that are not empty; fewer where it has fewer. The
/// first of them are the same for every `count`. Their references are still to be evaluated.
std::vector<VerifiedPixel> drawPixels(const Image& image, int count, unsigned seed);

/// Fills in the references. Throws Error(interrupted) where `progress` wishes it.
void evaluateReferences(const ViewScene& scene, std::span<VerifiedPixel> pixels, const ProgressSink& progress = {});

/// Fills in what `image` has there: another rendering of the same region.
void setRendered(std::span<VerifiedPixel> pixels, const Image& image);

/// Both: evaluates `count` pixels, drawn at random with `seed` from those of `image` that are not empty, both ways.
/// Fewer where the picture has fewer. `image` is in the working space, as rendered from `scene`.
std::vector<VerifiedPixel> samplePixels(const ViewScene& scene, const Image& image, int count, unsigned seed,
                                        const ProgressSink& progress = {});

Verification summarise(const std::vector<VerifiedPixel>& pixels);

}  // namespace scrim
