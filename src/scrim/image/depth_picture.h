// SPDX-License-Identifier: Apache-2.0
// The depth or deep picture of another renderer, and how much it hides: for every pixel, the visible fraction of what
// lies at a depth. Flat depths are surfaces that hide everything behind them; a deep picture's samples hide a part.
#pragma once

#include <scrim/image/image.h>
#include <scrim/image/picture_module.h>

#include <cstddef>
#include <cstdint>
#include <limits>
#include <span>
#include <vector>

namespace scrim {

struct DepthPicture {
    /// An object that hides. Within it optical depth grows linearly, as OpenEXR's "Interpreting
    /// Deep Pixels" defines it; a surface ends where it begins.
    struct Piece {
        float begin = 0, end = 0;
        float tau = 0;     ///< optical depth; infinite: nothing is visible behind it
        float before = 0;  ///< optical depth of all pieces in front of it
    };
    using Pieces = std::span<const Piece>;

    PixelWindow window;     ///< in pixels of the rendered picture; nothing is hidden outside of it
    bool alongRay = false;  ///< depths are distances along the pixel's ray instead of along the viewing axis
    bool thin = false;      ///< something hides only in part
    /// Index of each pixel's first piece, in rows from top to bottom; one more than there are pixels.
    std::vector<std::uint32_t> first;
    std::vector<Piece> pieces;  ///< of each pixel from front to back, without overlaps

    Pieces at(int x, int y) const;
    std::size_t bytes() const { return first.size() * sizeof(first[0]) + pieces.size() * sizeof(Piece); }
};

/// The depth from which on nothing is visible; infinity where there is none.
double opaqueFrom(DepthPicture::Pieces pieces);

/// The fraction of the opacity of a homogeneous segment, of optical depth `tau` over [near, far], that is visible past
/// the pieces: their mean transmittance over the segment, weighted by the segment's own transmittance.
double seenShare(DepthPicture::Pieces pieces, double near, double far, double tau);

/// The meaning of a file's numbers.
struct DepthMeaning {
    bool alongRay = false;
    /// Depths from this one on mean "nothing there", and so do depths <= 0 and NaN.
    double background = std::numeric_limits<double>::infinity();
};

/// Samples of a deep file may come in any order, and overlap. `file` must hold a picture.
DepthPicture depthPictureOf(const FileDepth& file, const DepthMeaning& meaning);

}  // namespace scrim
