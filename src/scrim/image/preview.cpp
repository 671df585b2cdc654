// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/preview.h>

#include <scrim/base/error.h>
#include <scrim/base/atomic_file.h>
#include <scrim/image/picture_module.h>

#include <fmt/format.h>

#include <cmath>
#include <utility>

namespace scrim {

namespace {

std::vector<std::uint8_t> withoutAlpha(const DisplayImage& picture) {
    std::vector<std::uint8_t> rgb(3 * picture.window.pixelCount());
    for (std::size_t i = 0; i < picture.window.pixelCount(); ++i)
        for (std::size_t c = 0; c < 3; ++c) rgb[3 * i + c] = picture.rgba[4 * i + c];
    return rgb;
}

}  // namespace

std::vector<unsigned char> pictureBytes(const std::string& name, const DisplayImage& picture) {
    FileBytes file =
        pictureModule().encode(name, {picture.window.width(), picture.window.height(), withoutAlpha(picture)});
    if (!file.problem.empty())
        throw Error(ErrorKind::output, fmt::format("cannot write '{}': {}", name, shortened(file.problem)));
    return std::move(file.bytes);
}

void writePreview(const std::string& path, const Image& working, const PixelWindow& displayWindow,
                  const ColourConfig& colour, const PreviewLook& look) {
    if (displayWindow.empty())
        throw Error(ErrorKind::usage, fmt::format("cannot write '{}': the display window is empty", path));
    Image shown = reframed(working, displayWindow);
    if (look.exposure != 0) {
        const auto gain = static_cast<float>(std::exp2(look.exposure));
        for (std::size_t i = 0; i < shown.rgba.size(); ++i)
            if (i % 4 != 3) shown.rgba[i] *= gain;
    }
    DisplayImage picture = colour.displayImage(shown, look.display, look.view);
    if (look.marks) drawMarks(picture, *look.marks);
    const std::vector<unsigned char> bytes = pictureBytes(path, picture);
    writeWholeFile(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace scrim
