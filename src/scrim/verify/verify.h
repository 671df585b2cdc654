// SPDX-License-Identifier: Apache-2.0
// Checks a finished picture against the brute-force reference at random pixels.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/image/image.h>
#include <scrim/scene/view_scene.h>

#include <array>
#include <cstddef>
#include <functional>
#include <limits>
#include <span>
#include <vector>

namespace scrim {

/// One pixel, rendered and true: premultiplied RGBA.
struct VerifiedPixel {
    int x = 0, y = 0;
    std::array<double, 4> rendered{}, reference{};
    std::array<double, 3> variance{};  ///< of the reference, where that is a mean of random numbers
};

/// Relative RMSE over the pixels that count: those where the reference or the picture has an alpha above 1e-3, or light
/// above a thousandth of the reference's brightest. The error is the RMS of the difference over R, G and B, divided by
/// the mean of the reference; that of alpha is alike. Where the reference is black, alpha decides: the error is that of
/// alpha, or that of colour in units of the reference's alpha where it is larger. A value that is not finite makes it
/// infinite.
struct Verification {
    int pixels = 0;          ///< that counted
    std::size_t looked = 0;  ///< pixels whose reference was evaluated
    bool complete = false;   ///< no pixel that may show something was left out: the error is known exactly
    double error = 0;        ///< 0 where no pixel counted
    double lower = 0;        ///< confidence interval of it: bootstrap-t over the pixels, of the logarithm;
                             ///< where the reference is noisy, bootstrap of the square
    double upper = 0;
    double alphaError = 0, alphaUpper = 0;
    double mean = 0;   ///< of the reference over R, G and B: what the error of colour is relative to
    double bias = 0;   ///< mean difference over mean reference, of colour
    double worst = 0;  ///< largest RMS difference of one pixel over the mean reference, of colour
    int worstX = 0, worstY = 0;
};

/// What a verification has looked at.
struct PixelSample {
    std::vector<VerifiedPixel> pixels;  ///< in the order of being drawn; also those that do not count
    std::size_t candidates = 0;         ///< pixels there were to draw from; 0: endlessly many
    bool outOfTime = false;             ///< fewer than asked for, since time was up
};

/// As many pixels as there are.
constexpr int kAllPixels = std::numeric_limits<int>::max();

struct SampleOptions {
    int count = 0;       ///< of pixels that count; kAllPixels: every pixel that may show something
    unsigned seed = 1;   ///< the first pixels are the same for every `count`
    double seconds = 0;  ///< stop after this time; 0: never
    ProgressSink progress = {};
    /// Called once, half a second after the start, with the seconds that are expected in all.
    std::function<void(double)> announce = {};
    /// Called between steps: is what there is so far enough? Then no more are drawn.
    std::function<bool(const PixelSample&)> enough = {};
};

/// Draws pixels (see verificationOrder) until `count` of them count, and evaluates their references. Fewer where there
/// are fewer. `image` is in the working space; `truth` is its scene with all volumes, those too that a render leaves
/// out. Throws Error(interrupted) where `progress` wishes it.
PixelSample samplePixels(const ViewScene& truth, const Image& image, const SampleOptions& options);
PixelSample samplePixels(const ViewScene& truth, const Image& image, int count, unsigned seed,
                         const ProgressSink& progress = {});

/// Fills in the references. Throws Error(interrupted) where `progress` wishes it.
void evaluateReferences(const ViewScene& truth, std::span<VerifiedPixel> pixels, const ProgressSink& progress = {});

/// Fills in what `image` has there: another rendering of the same region.
void setRendered(std::span<VerifiedPixel> pixels, const Image& image);

/// `confidence` of the interval, split evenly between its ends.
Verification summarise(const PixelSample& sample, double confidence = 0.95);
/// Of pixels that are few among many.
Verification summarise(std::span<const VerifiedPixel> pixels, double confidence = 0.95);

}  // namespace scrim
