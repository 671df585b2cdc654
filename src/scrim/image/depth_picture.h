// SPDX-License-Identifier: Apache-2.0
// What a depth or deep picture of another renderer hides: of every pixel how much is seen of what lies at a depth. Flat
// depths are surfaces that hide all behind them; a deep picture's samples hide a part.
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
    /// Something that hides. Within it optical depth grows evenly, as OpenEXR's "Interpreting Deep Pixels" has it; a
    /// surface has its end where it begins.
    struct Piece {
        float begin = 0, end = 0;
        float tau = 0;     ///< optical depth; infinite: nothing is seen behind it
        float before = 0;  ///< of all pieces in front of it
    };
    using Pieces = std::span<const Piece>;

    PixelWindow window;                ///< in pixels of the picture that is rendered; beyond it nothing hides
    bool alongRay = false;             ///< depths are distances along the pixel's ray, and not along the viewing axis
    bool thin = false;                 ///< does anything hide a part only?
    std::vector<std::uint32_t> first;  ///< of each pixel's pieces, in rows from top to bottom; and one more
    std::vector<Piece> pieces;         ///< of a pixel from front to back; they do not overlap

    Pieces at(int x, int y) const;
    std::size_t bytes() const { return first.size() * sizeof(first[0]) + pieces.size() * sizeof(Piece); }
};

/// The depth from which on nothing is seen; infinity where there is none.
double opaqueFrom(DepthPicture::Pieces pieces);

/// What part of the opacity of something even, of optical depth `tau` over [near, far], is seen past the pieces: the
/// mean of their transmittance over it, weighted by what of it is left there.
double seenShare(DepthPicture::Pieces pieces, double near, double far, double tau);

/// How the numbers of a file are meant.
struct DepthMeaning {
    bool alongRay = false;
    /// From here on nothing is there. So it is at 0, below it, and where there is no number.
    double background = std::numeric_limits<double>::infinity();
};

/// Samples of a deep file may come in any order, and overlap. `file` holds a picture.
DepthPicture depthPictureOf(const FileDepth& file, const DepthMeaning& meaning);

}  // namespace scrim
