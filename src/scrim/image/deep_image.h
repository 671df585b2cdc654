// SPDX-License-Identifier: Apache-2.0
// Deep pictures in memory. A pixel is a curve over depth: the colour and alpha of everything that lies in front of a
// depth. The samples of a file (exr_deep.h) are made from the curves last, so that sums, means and merging work on
// curves, and flattening always yields the end of the curve, however pieces were merged.
#pragma once

#include <scrim/image/image.h>

#include <array>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace scrim {

/// A stretch of a curve in which something is visible: [begin, end) with end > begin.
struct DeepPiece {
    float begin = 0, end = 0;
    std::array<float, 4> shown{};  ///< premultiplied RGBA of everything in front of `end`, nearer pieces included
};

/// Pieces from front to back that do not overlap; space between them is empty. Within a piece the
/// extinction is constant, and colour accumulates in proportion to opacity, as deep compositing
/// assumes (OpenEXR, "Interpreting OpenEXR Deep Pixels").
using DeepCurve = std::vector<DeepPiece>;

/// Premultiplied RGBA of everything in front of `depth`; a piece that contains `depth` counts in part.
std::array<double, 4> shownBefore(std::span<const DeepPiece> curve, double depth);

/// A curve with its weights in a sum.
struct DeepTerm {
    std::span<const DeepPiece> curve;
    double colour = 1, alpha = 1;  ///< weights
};

/// The weighted sum on the union of all pieces' ends, where it is exact.
DeepCurve sumOf(const std::vector<DeepTerm>& terms);

/// The curve with fewer pieces. At every end of a piece of `curve`, alpha deviates by at most `tolerance`, and colours
/// by at most that fraction of the curve's largest colour. The remaining ends of pieces, and therefore the end of the
/// whole curve, keep their exact values. A tolerance of 0 returns the curve itself.
DeepCurve merged(const DeepCurve& curve, double tolerance);

/// Removes pieces whose depths coincide after rounding, and pieces behind almost no transmittance;
/// the piece in front of them takes over their contribution.
DeepCurve tidied(const DeepCurve& curve);

/// A curve for every pixel of a window.
struct DeepImage {
    struct Row {
        std::vector<std::uint32_t> first;  ///< index of each pixel's first piece; one more than there are pixels
        DeepCurve pieces;                  ///< the pieces of all pixels, from left to right
    };
    PixelWindow window;
    std::vector<Row> rows;  ///< the rows of the window, from top to bottom

    /// The curve of a pixel of the window.
    std::span<const DeepPiece> curve(int x, int y) const;
    std::size_t pieceCount() const;
    std::size_t bytes() const;
};

/// The picture with these curves. `curveAt` is called for several rows at a time.
DeepImage deepImage(const PixelWindow& window, const std::function<DeepCurve(int x, int y)>& curveAt);

}  // namespace scrim
