// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/preview.h>

#include <scrim/base/error.h>
#include <scrim/base/atomic_file.h>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <filesystem>
#include <memory>

namespace scrim {

namespace {

std::vector<std::uint8_t> withoutAlpha(const DisplayImage& picture) {
    std::vector<std::uint8_t> rgb(3 * picture.window.pixelCount());
    for (std::size_t i = 0; i < picture.window.pixelCount(); ++i)
        for (std::size_t c = 0; c < 3; ++c) rgb[3 * i + c] = picture.rgba[4 * i + c];
    return rgb;
}

}  // namespace

// In memory, since on a full disk OpenImageIO's PNG writer reports success and libjpeg ends the process.
std::vector<unsigned char> pictureBytes(const std::string& name, const DisplayImage& picture) {
    const auto refuse = [&name](const std::string& why) {
        throw Error(ErrorKind::output, fmt::format("cannot write '{}': {}", name, why));
    };
    const std::string extension = std::filesystem::path(name).extension().string();
    const std::unique_ptr<OIIO::ImageOutput> out = extension.empty() ? nullptr : OIIO::ImageOutput::create(name);
    if (!out || !out->supports("ioproxy")) {
        OIIO::geterror();  // forgotten: the text below says more
        refuse("its extension must name a picture format, such as '.png' or '.jpg'");
    }
    std::vector<unsigned char> bytes;
    OIIO::Filesystem::IOVecOutput memory(bytes);
    out->set_ioproxy(&memory);
    const OIIO::ImageSpec spec(picture.window.width(), picture.window.height(), 3, OIIO::TypeDesc::UINT8);
    const std::vector<std::uint8_t> rgb = withoutAlpha(picture);
    if (!out->open(name, spec) || !out->write_image(OIIO::TypeDesc::UINT8, rgb.data()) || !out->close())
        refuse(shortened(out->geterror()));
    return bytes;
}

void writePreview(const std::string& path, const Image& working, const PixelWindow& displayWindow,
                  const ColourConfig& colour, const std::string& display, const std::string& view) {
    if (displayWindow.empty())
        throw Error(ErrorKind::usage, fmt::format("cannot write '{}': the display window is empty", path));
    const std::vector<unsigned char> bytes =
        pictureBytes(path, colour.displayImage(reframed(working, displayWindow), display, view));
    writeWholeFile(path, {reinterpret_cast<const char*>(bytes.data()), bytes.size()});
}

}  // namespace scrim
