// SPDX-License-Identifier: Apache-2.0
// Deep pictures in memory. A pixel is a curve over depth: what it shows of all that lies before a depth. Samples of a
// file (exr_deep.h) are made of it last, so that sums, means and merging work on curves, and flattening yields the end
// of the curve whatever was merged.
#pragma once

#include <scrim/image/image.h>

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace scrim {

/// A stretch of a curve on which something is: [begin, end) with end > begin.
struct DeepPiece {
    float begin = 0, end = 0;
    std::array<float, 4> shown{};  ///< premultiplied RGBA of all that lies before `end`, nearer pieces included
};

/// Pieces from front to back that do not overlap; between them nothing is. Within a piece the extinction is constant,
/// and colour goes with opacity, as deep compositing takes it (OpenEXR, "Interpreting OpenEXR Deep Pixels").
using DeepCurve = std::vector<DeepPiece>;

/// Premultiplied RGBA of what lies before `depth`; a piece that `depth` lies in counts in part.
std::array<double, 4> shownBefore(std::span<const DeepPiece> curve, double depth);

/// A curve as a part of a sum.
struct DeepTerm {
    std::span<const DeepPiece> curve;
    double colour = 1, alpha = 1;  ///< weights
};

/// The weighted sum, on the union of all pieces' ends: there it is exact.
DeepCurve sumOf(const std::vector<DeepTerm>& terms);

/// The same curve of fewer pieces: at every end of a piece of `curve` alpha deviates from it by at most `tolerance`,
/// and colours by at most that part of the curve's largest colour. Ends of pieces that are left, and with them what the
/// whole curve shows, stay exactly as they were. Of tolerance 0: the curve itself.
DeepCurve merged(const DeepCurve& curve, double tolerance);

/// Pieces of a curve whose depths rounding has let collapse, and those behind next to nothing of transmittance, give
/// what they hold to the piece before them.
DeepCurve tidied(const DeepCurve& curve);

/// A curve for every pixel of a window.
struct DeepImage {
    struct Row {
        std::vector<std::uint32_t> first;  ///< of each pixel's pieces; one more than there are pixels
        DeepCurve pieces;                  ///< of all pixels, from left to right
    };
    PixelWindow window;
    std::vector<Row> rows;  ///< of the window, from top to bottom

    /// Of a pixel of the window.
    std::span<const DeepPiece> curve(int x, int y) const;
    std::size_t pieceCount() const;
    std::size_t bytes() const;
};

}  // namespace scrim
