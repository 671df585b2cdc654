// SPDX-License-Identifier: Apache-2.0
// Makes textures from pictures of any format. The module that knows the formats does the reading.
#include <scrim/image/texture_read.h>

#include <scrim/base/error.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <system_error>
#include <utility>

namespace scrim {
namespace {

[[noreturn]] void refuse(const std::string& path, const std::string& problem) {
    throw Error(ErrorKind::input, fmt::format("cannot read '{}': {}", path, problem));
}

/// Sets values that are not finite or less than 0 to 0, and returns their number.
std::size_t sanitize(Image& image) {
    std::size_t bad = 0;
    for (float& value : image.rgba)
        if (!std::isfinite(value) || value < 0) {
            value = 0;
            ++bad;
        }
    return bad;
}

/// Converts from the file's space to premultiplied values in the working space. In an encoded
/// space, the values mean the colour itself, not its product with alpha.
void convertPixels(Image& image, bool multiplied, const std::string& space, const ColourConfig& colour) {
    // A premultiplied file may contain light where it is transparent. There, and where it is
    // opaque, the colour is used unchanged.
    const auto apart = [&](float alpha) { return multiplied && (alpha <= 0 || alpha >= 1); };
    for (std::size_t i = 0; multiplied && i < image.rgba.size(); i += 4)
        if (const float alpha = image.rgba[i + 3]; !apart(alpha))
            for (std::size_t c = 0; c < 3; ++c) image.rgba[i + c] /= alpha;
    colour.convert(image, space, colour.workingSpace());
    // Colours outside of the working space have a negative component; light has none.
    for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
        const float alpha = apart(image.rgba[i + 3]) ? 1.0f : std::min(image.rgba[i + 3], 1.0f);
        for (std::size_t c = 0; c < 3; ++c) image.rgba[i + c] = std::max(0.0f, image.rgba[i + c] * alpha);
    }
}

}  // namespace

void checkPictureFile(const std::string& path) {
    // A file that is not regular may hang (a pipe) or read as empty (a folder).
    std::error_code error;
    const auto status = std::filesystem::status(path, error);
    if (!std::filesystem::exists(status)) throw Error(ErrorKind::input, fmt::format("there is no file '{}'", path));
    if (!std::filesystem::is_regular_file(status)) refuse(path, "it is not a regular file; expected a picture");
}

std::shared_ptr<const Texture> textureOf(FilePicture pixels, const std::string& path, const std::string& colorspace,
                                         const ColourConfig& colour, const MessageSink& messages) {
    if (!pixels.problem.empty()) refuse(path, shortened(pixels.problem));
    Image image;
    image.window = {0, 0, pixels.width, pixels.height};
    image.rgba = std::move(pixels.rgba);
    if (const std::size_t bad = sanitize(image); bad > 0)
        notify(messages, Severity::warning,
               fmt::format("{}: {} values that are not finite or less than 0 count as 0", path, bad));
    const std::string space = !colorspace.empty() ? colorspace : pixels.integers ? "sRGB" : colour.workingSpace();
    convertPixels(image, !pixels.alphaApart, space, colour);
    return std::make_shared<Texture>(image, pixels.pixelAspect);
}

std::shared_ptr<const Texture> readTexture(const std::string& path, const std::string& colorspace,
                                           const ColourConfig& colour, const MessageSink& messages) {
    checkPictureFile(path);
    return textureOf(pictureModule().read(path), path, colorspace, colour, messages);
}

}  // namespace scrim
