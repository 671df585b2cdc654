// SPDX-License-Identifier: Apache-2.0
// Checks a finished picture against the brute-force reference at random pixels.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/engine/model/frame.h>
#include <scrim/image/image.h>
#include <scrim/scene/view_scene.h>

#include <array>
#include <cstddef>
#include <functional>
#include <limits>
#include <span>
#include <vector>

namespace scrim {

/// One pixel, or the mean over a square of pixels, rendered and true: premultiplied RGBA.
struct VerifiedPixel {
    int x = 0, y = 0;  ///< of a square the corner with the least coordinates
    std::array<double, 4> rendered{}, reference{};
    std::array<double, 3> variance{};  ///< of the reference, where it is a mean of random numbers
    /// Pixels along an edge of the square. Pixels outside of the region do not belong to it.
    int edge = 1;
};

/// The edge of the squares that a verification of `truth` examines: kScatteringMean where light
/// scatters more than once, since such light is smooth and its reference is noisy; else 1.
int verifiedEdge(const ViewScene& truth);

/// Relative RMSE over the pixels that count: those where the reference or the picture has an alpha above 1e-3, or light
/// above a thousandth of the reference's brightest. The error is the RMS of the difference over R, G and B, divided by
/// the mean of the reference; the error of alpha is defined likewise. Where the reference is black, alpha decides: the
/// error is that of alpha, or that of colour in units of the reference's alpha, whichever is larger. A value that is
/// not finite makes the error infinite.
struct Verification {
    int pixels = 0;          ///< pixels that counted
    std::size_t looked = 0;  ///< pixels whose reference was evaluated
    bool complete = false;   ///< no pixel that may show something was left out, so the error is exact
    double error = 0;        ///< 0 if no pixel counted
    /// Confidence interval of the error, from `lower` to `upper`: bootstrap-t over the pixels, of
    /// the logarithm; where the reference is noisy, bootstrap of the square.
    double lower = 0;
    double upper = 0;
    double alphaError = 0, alphaUpper = 0;
    double mean = 0;   ///< mean of the reference over R, G and B, which the colour error is relative to
    double bias = 0;   ///< mean difference over mean reference, of colour
    double worst = 0;  ///< largest RMS difference of one pixel over the mean reference, of colour
    int worstX = 0, worstY = 0;
};

/// The pixels that a verification has examined.
struct PixelSample {
    std::vector<VerifiedPixel> pixels;  ///< in the order in which they were drawn, including pixels that do not count
    std::size_t candidates = 0;         ///< number of pixels that could be drawn; 0: unlimited
    bool outOfTime = false;             ///< fewer pixels than requested, because time ran out
};

/// Stands for all pixels.
constexpr int kAllPixels = std::numeric_limits<int>::max();

struct SampleOptions {
    int count = 0;      ///< number of pixels that must count; kAllPixels: every pixel that may show something
    unsigned seed = 1;  ///< the first pixels are the same for every `count`
    /// Stop after this time, and leave out the pixels that are not done then; 0: no limit.
    double seconds = 0;
    ProgressSink progress = {};
    /// Called once, half a second after the start, with the expected total of seconds.
    std::function<void(double)> announce = {};
    /// Called between steps with the sample so far; if it returns true, no more pixels are drawn.
    std::function<bool(const PixelSample&)> enough = {};
};

/// Draws pixels, or squares of verifiedEdge() (see verificationOrder) until `count` of them count or none is left, and
/// evaluates their references. `image` is in the working space; `truth` is its scene with all volumes, including those
/// that a render leaves out. Throws Error(interrupted) if `progress` returns false.
PixelSample samplePixels(const ViewScene& truth, const Image& image, const SampleOptions& options);
PixelSample samplePixels(const ViewScene& truth, const Image& image, int count, unsigned seed,
                         const ProgressSink& progress = {});

/// Fills in the references. Throws Error(interrupted) if `progress` returns false.
void evaluateReferences(const ViewScene& truth, std::span<VerifiedPixel> pixels, const ProgressSink& progress = {});

/// Fills in the values of `image`, another rendering of the same region.
void setRendered(std::span<VerifiedPixel> pixels, const Image& image);

/// How far the layers `shadow` of a frame are from brute force, at pixels that show solids which catch shadows.
struct CaughtDifference {
    int values = 0;             ///< of layers at pixels
    double rms = 0, worst = 0;  ///< of the differences; the values themselves are from 0 to 1
};

/// Looks at up to `pixels` such pixels, which are spread evenly.
CaughtDifference differenceOfCaught(const ViewScene& truth, const Frame& frame, int pixels);

/// The pixels of a sample that count (see Verification), in its order.
std::vector<VerifiedPixel> countedPixels(const PixelSample& sample);

/// `confidence` is that of the interval; its error is split evenly between both ends.
Verification summarise(const PixelSample& sample, double confidence = 0.95);
/// The same for pixels that are few among many.
Verification summarise(std::span<const VerifiedPixel> pixels, double confidence = 0.95);

}  // namespace scrim
