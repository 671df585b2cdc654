// SPDX-License-Identifier: Apache-2.0
// Pictures of any format into textures: the one place that reads through OpenImageIO.
#include <scrim/image/texture.h>

#include <scrim/base/error.h>

#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>
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

/// Places of red, green, blue and alpha among a file's channels; alpha -1: none.
struct Channels {
    int rgb[3] = {0, 0, 0};
    int alpha = -1;
};

Channels channelsOf(const OIIO::ImageSpec& spec) {
    Channels channels;
    const int r = spec.channelindex("R"), g = spec.channelindex("G"), b = spec.channelindex("B");
    if (r >= 0 && g >= 0 && b >= 0) {
        channels = {{r, g, b}, spec.alpha_channel};
    } else if (spec.nchannels >= 3) {
        channels = {{0, 1, 2}, spec.alpha_channel};
    } else {
        channels.alpha = spec.nchannels == 2 ? 1 : -1;  // grey, or grey and alpha
    }
    if (channels.alpha < 0) channels.alpha = spec.channelindex("A");
    if (spec.nchannels == 1) channels.alpha = -1;
    return channels;
}

struct FilePixels {
    OIIO::ImageBuf buffer;    ///< all channels as floats, upright, over the file's full window; beyond its data 0
    bool integers = false;    ///< as the file has them
    bool alphaApart = false;  ///< colour is not multiplied by alpha
    double pixelAspect = 1;
};

FilePixels readPixels(const std::string& path) {
    // Colour must be converted before alpha is multiplied in, so it must come as the file has it.
    OIIO::ImageSpec wishes;
    wishes.attribute("oiio:UnassociatedAlpha", 1);
    const auto in = OIIO::ImageInput::open(path, &wishes);
    if (!in) refuse(path, shortened(OIIO::geterror()));
    const OIIO::ImageSpec& spec = in->spec();
    const int fullWidth = spec.full_width > 0 ? spec.full_width : spec.width;
    const int fullHeight = spec.full_height > 0 ? spec.full_height : spec.height;
    if (spec.depth > 1 || spec.deep || spec.nchannels < 1 || spec.width < 1 || spec.height < 1)
        refuse(path, "it holds no flat picture");
    const auto pixels = [](int width, int height) { return static_cast<double>(width) * height; };
    if (std::max(pixels(spec.width, spec.height), pixels(fullWidth, fullHeight)) > double(kMostTexturePixels) ||
        spec.nchannels > 64)
        refuse(path, fmt::format("it has {} x {} pixels of {} channels; expected at most {} million pixels of 64",
                                 fullWidth, fullHeight, spec.nchannels, kMostTexturePixels / 1000000));

    OIIO::ImageSpec stored = spec;
    stored.set_format(OIIO::TypeDesc::FLOAT);
    stored.channelformats.clear();
    OIIO::ImageBuf data(stored);
    if (!in->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, data.localpixels()) || in->has_error())
        refuse(path, shortened(in->geterror()));
    FilePixels out;
    out.integers = !spec.format.is_floating_point();
    out.alphaApart = spec.get_int_attribute("oiio:UnassociatedAlpha", 0) != 0;
    const double aspect = spec.get_float_attribute("PixelAspectRatio", 1.0f);
    if (aspect > 1e-3 && aspect < 1e3) out.pixelAspect = aspect;
    // Orientations from 5 on lay the picture on its side, and with it its pixels.
    if (spec.get_int_attribute("Orientation", 1) >= 5) out.pixelAspect = 1 / out.pixelAspect;

    const OIIO::ROI full(spec.full_x, spec.full_x + fullWidth, spec.full_y, spec.full_y + fullHeight, 0, 1, 0,
                         spec.nchannels);
    if (data.roi() != full) data = OIIO::ImageBufAlgo::cut(data, full);
    out.buffer = OIIO::ImageBufAlgo::reorient(data);
    if (out.buffer.has_error() || !out.buffer.localpixels()) refuse(path, shortened(out.buffer.geterror()));
    return out;
}

/// The file's channels as RGBA; alpha is not multiplied in yet where the file has it apart.
Image arranged(const OIIO::ImageBuf& pixels) {
    const OIIO::ImageSpec& spec = pixels.spec();
    const Channels channels = channelsOf(spec);
    Image image = emptyImage({0, 0, spec.width, spec.height});
    const auto* from = static_cast<const float*>(pixels.localpixels());
    const auto stride = std::size_t(spec.nchannels);
    for (std::size_t p = 0; p < image.window.pixelCount(); ++p, from += stride) {
        for (std::size_t c = 0; c < 3; ++c) image.rgba[4 * p + c] = from[channels.rgb[c]];
        image.rgba[4 * p + 3] = channels.alpha < 0 ? 1.0f : from[channels.alpha];
    }
    return image;
}

/// Number of values that were not finite or less than 0, and are 0 now.
std::size_t sanitize(Image& image) {
    std::size_t bad = 0;
    for (float& value : image.rgba)
        if (!std::isfinite(value) || value < 0) {
            value = 0;
            ++bad;
        }
    return bad;
}

/// From the file's space to premultiplied values in the working space. An encoded space means the colour itself, not
/// its product with alpha.
void convertPixels(Image& image, bool multiplied, const std::string& space, const ColourConfig& colour) {
    // Multiplied files may shine where they are transparent: there, and where they are opaque, colour is as it is.
    const auto apart = [&](float alpha) { return multiplied && (alpha <= 0 || alpha >= 1); };
    for (std::size_t i = 0; multiplied && i < image.rgba.size(); i += 4)
        if (const float alpha = image.rgba[i + 3]; !apart(alpha))
            for (std::size_t c = 0; c < 3; ++c) image.rgba[i + c] /= alpha;
    colour.convert(image, space, colour.workingSpace());
    // Colours that the working space cannot hold have a negative part; no light has.
    for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
        const float alpha = apart(image.rgba[i + 3]) ? 1.0f : std::min(image.rgba[i + 3], 1.0f);
        for (std::size_t c = 0; c < 3; ++c) image.rgba[i + c] = std::max(0.0f, image.rgba[i + c] * alpha);
    }
}

}  // namespace

std::shared_ptr<const Texture> readTexture(const std::string& path, const std::string& colorspace,
                                           const ColourConfig& colour, const MessageSink& messages) {
    // Whatever is not a regular file may hang (a pipe) or read as nothing (a folder).
    std::error_code error;
    const auto status = std::filesystem::status(path, error);
    if (!std::filesystem::exists(status)) throw Error(ErrorKind::input, fmt::format("there is no file '{}'", path));
    if (!std::filesystem::is_regular_file(status)) refuse(path, "it is not a regular file; expected a picture");

    const FilePixels pixels = readPixels(path);
    Image image = arranged(pixels.buffer);
    if (const std::size_t bad = sanitize(image); bad > 0)
        notify(messages, Severity::warning,
               fmt::format("{}: {} values that are not finite or less than 0 count as 0", path, bad));
    const std::string space = !colorspace.empty() ? colorspace : pixels.integers ? "sRGB" : colour.workingSpace();
    convertPixels(image, !pixels.alphaApart, space, colour);
    return std::make_shared<Texture>(image, pixels.pixelAspect);
}

}  // namespace scrim
