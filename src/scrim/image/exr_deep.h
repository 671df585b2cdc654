// SPDX-License-Identifier: Apache-2.0
// Deep OpenEXR files out: scanlines, since not every compositing program reads tiles, and tidy, so that readers need
// not sort or split. Channels R, G, B, A (premultiplied), Z and ZBack (depths along the viewing axis, world units,
// always 32-bit); a sample is a volume over [Z, ZBack).
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

/// The samples of a pixel: alpha 1 - T1/T0 and colours (C1 - C0)/T0 of a piece before which there are T0 and C0, and
/// behind which T1 and C1. T0 and C0 are what the samples before leave as they were rounded, to half floats where
/// `half` says so; thus rounding does not add up, and flattening is as exact as the last sample. Alphas are in [0, 1].
/// `clamped` is increased by the number of values beyond the range of half floats.
std::vector<DeepSample> deepSamples(std::span<const DeepPiece> curve, bool half, std::size_t& clamped);

/// Writes the samples of `image`, whose data window is cropped to the pixels that have any. ZIPS whatever
/// `options.compression` says, and no ACES container, which is flat. Returns the number of clamped values, and throws
/// as writeExr does.
std::size_t writeDeepExr(const std::string& path, const DeepImage& image, const ExrOptions& options,
                         const ExrAttributes& attributes = {});

}  // namespace scrim
