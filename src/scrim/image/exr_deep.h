// SPDX-License-Identifier: Apache-2.0
// Writes deep OpenEXR files. They are scanline files, since not every compositing program reads tiles, and tidy, so
// that readers need not sort or split. Channels are R, G, B, A (premultiplied), Z and ZBack (depths along the viewing
// axis, world units, always 32-bit); a sample is a volume over [Z, ZBack).
#pragma once

#include <scrim/image/deep_image.h>
#include <scrim/image/exr.h>

#include <cstddef>
#include <span>
#include <string>
#include <vector>

namespace scrim {

struct DeepSample {
    float z = 0, zBack = 0;
    std::array<float, 4> rgba{};  ///< premultiplied, of the sample alone
};

/// The samples of a pixel. A piece with transmittance T0 and colour C0 in front of it, T1 and C1 behind it, gets the
/// alpha 1 - T1/T0 and the colour (C1 - C0)/T0. T0 and C0 are computed from the preceding samples as rounded (to half
/// floats if `half`), so that rounding errors do not add up and flattening is as exact as the last sample. Alphas are
/// in [0, 1]. `clamped` is increased by the number of values beyond the range of half floats.
std::vector<DeepSample> deepSamples(std::span<const DeepPiece> curve, bool half, std::size_t& clamped);

/// Writes the samples of `image`, with the data window cropped to the pixels that have any. The
/// compression is ZIPS whatever `options.compression` says, and an ACES container, which is flat,
/// is not possible. Returns the number of clamped values, and throws as writeExr does.
std::size_t writeDeepExr(const std::string& path, const DeepImage& image, const ExrOptions& options,
                         const ExrAttributes& attributes = {});

}  // namespace scrim
