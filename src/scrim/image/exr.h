// SPDX-License-Identifier: Apache-2.0
// Writes flat OpenEXR files: the beauty, further layers, and metadata for a pipeline. OpenEXR stays
// behind this header. Reading is in exr_read.h, for tests, tools, and the merge of crops.
#pragma once

#include <scrim/image/image.h>
#include <scrim/image/known_spaces.h>

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <glm/mat4x4.hpp>

namespace scrim {

struct ExrOptions {
    bool half = true;                 ///< 16-bit channels, else 32-bit
    std::string compression = "zip";  ///< one of exrCompressions(); an ACES container is never compressed
    PixelWindow displayWindow;        ///< the whole picture; must not be empty
    double pixelAspect = 1.0;         ///< width / height of a pixel
    std::string colorInteropId;       ///< value of the attribute colorInteropID; empty: no attribute
    /// Value of the attribute chromaticities: of red, green, blue and white; none: no attribute.
    std::optional<Chromaticities> chromaticities;
    /// Writes an ACES container (SMPTE ST 2065-4): RGBA in ACES2065-1, half, without compression whatever `compression`
    /// says, with acesImageContainerFlag; its chromaticities must be those of AP0. It takes no layers.
    bool acesContainer = false;
    bool picture = true;  ///< the image is written; false: the layers alone, and the image tells where they are empty
    /// The data window is the whole image, even where it is empty: for layers that are not 0 in empty space.
    bool wholeWindow = false;
};

/// A rational number of frames per second.
struct FrameRate {
    int numerator = 24;
    unsigned denominator = 1;
    bool operator==(const FrameRate&) const = default;
};

/// The exact rate behind a rounded one: 23.976 is 24000/1001.
FrameRate exactFrameRate(double framesPerSecond);

/// The values that an attribute may hold: text, a float (doubles are rounded, as readers expect floats), an integer, a
/// 4x4 matrix in GLM's convention for column vectors (the file gets EXR's, for row vectors), a frame rate.
using ExrAttribute = std::variant<std::string, double, int, glm::dmat4, FrameRate>;
using ExrAttributes = std::vector<std::pair<std::string, ExrAttribute>>;

/// Further channels with the same window as the image.
struct ExrLayer {
    std::vector<std::string> channels;  ///< full names, "light.key.R" or "Z"
    std::vector<float> data;            ///< channels.size() floats per pixel, interleaved, rows from top to bottom
    bool always32bit = false;           ///< 32-bit even in files of half (depth)
};

/// The values that `ExrOptions::compression` may have: zip, zips, piz, dwaa (level 45), none.
const std::vector<std::string>& exrCompressions();

/// Writes a scanline file with the channels R, G, B, A and those of `layers`. The data window is the smallest one
/// around everything that is not empty in `image` (nonEmptyWindow). Layers are cropped to it, and readers see 0 in all
/// channels outside of it. In half channels, values beyond +-65504, including infinities, are clamped to that; NaN
/// stays NaN. Compresses on up to threadCount() threads of OpenEXR's pool (see setExrThreads). The file appears
/// completely or not at all. Returns the number of clamped values, which a caller should warn about. Throws an Error,
/// of kind `usage` where the arguments contradict each other, of kind `output` where the file cannot be written.
std::size_t writeExr(const std::string& path, const Image& image, const ExrOptions& options,
                     const ExrAttributes& attributes = {}, const std::vector<ExrLayer>& layers = {});

/// Sets the size of OpenEXR's process-wide thread pool. It starts with no threads, and files are then compressed on the
/// calling thread. For programs: a library should not decide this for its host.
void setExrThreads(int threads);

}  // namespace scrim
