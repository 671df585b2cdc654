// SPDX-License-Identifier: Apache-2.0
// The module `scrim_images`: the one place that reads and writes through OpenImageIO.
#include <scrim/image/picture_module.h>

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <memory>

namespace {

using scrim::FileBytes;
using scrim::FilePicture;
using scrim::PictureHeader;
using scrim::RgbPicture;

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
    // Some formats name an alpha that their pictures do not have.
    if (spec.nchannels == 1 || channels.alpha >= spec.nchannels) channels.alpha = -1;
    return channels;
}

/// Never empty, since that means that there is none.
std::string problemText(const std::string& ofOpenImageIo) {
    return ofOpenImageIo.empty() ? "OpenImageIO does not say why" : ofOpenImageIo;
}

FilePicture refused(const std::string& problem) {
    FilePicture out;
    out.problem = problemText(problem);
    return out;
}

/// The file's channels as RGBA.
void arrange(const OIIO::ImageBuf& pixels, FilePicture& out) {
    const OIIO::ImageSpec& spec = pixels.spec();
    const Channels channels = channelsOf(spec);
    out.width = spec.width;
    out.height = spec.height;
    const std::size_t count = std::size_t(spec.width) * std::size_t(spec.height);
    out.rgba.resize(4 * count);
    const auto* from = static_cast<const float*>(pixels.localpixels());
    const auto stride = std::size_t(spec.nchannels);
    for (std::size_t p = 0; p < count; ++p, from += stride) {
        for (std::size_t c = 0; c < 3; ++c) out.rgba[4 * p + c] = from[channels.rgb[c]];
        out.rgba[4 * p + 3] = channels.alpha < 0 ? 1.0f : from[channels.alpha];
    }
}

FilePicture readPixels(const std::string& path) {
    // Colour must be converted before alpha is multiplied in, so it must come as the file has it.
    OIIO::ImageSpec wishes;
    wishes.attribute("oiio:UnassociatedAlpha", 1);
    const auto in = OIIO::ImageInput::open(path, &wishes);
    if (!in) return refused(OIIO::geterror());
    const OIIO::ImageSpec& spec = in->spec();
    const int fullWidth = spec.full_width > 0 ? spec.full_width : spec.width;
    const int fullHeight = spec.full_height > 0 ? spec.full_height : spec.height;
    if (spec.depth > 1 || spec.deep || spec.nchannels < 1 || spec.width < 1 || spec.height < 1)
        return refused("it holds no flat picture");
    const auto pixels = [](int width, int height) { return static_cast<double>(width) * height; };
    const auto most = static_cast<double>(scrim::kMostTexturePixels);
    if (std::max(pixels(spec.width, spec.height), pixels(fullWidth, fullHeight)) > most || spec.nchannels > 64)
        return refused(fmt::format("it has {} x {} pixels of {} channels; expected at most {} million pixels of 64",
                                   fullWidth, fullHeight, spec.nchannels, scrim::kMostTexturePixels / 1000000));

    OIIO::ImageSpec stored = spec;
    stored.set_format(OIIO::TypeDesc::FLOAT);
    stored.channelformats.clear();
    // Some formats name no channels, and OpenImageIO ends the process where one asks for them by name.
    if (stored.channelnames.size() != std::size_t(stored.nchannels)) stored.default_channel_names();
    OIIO::ImageBuf data(stored);
    if (!in->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, data.localpixels()) || in->has_error())
        return refused(in->geterror());
    FilePicture out;
    out.integers = !spec.format.is_floating_point();
    out.alphaApart = spec.get_int_attribute("oiio:UnassociatedAlpha", 0) != 0;
    const double aspect = spec.get_float_attribute("PixelAspectRatio", 1.0f);
    if (aspect > 1e-3 && aspect < 1e3) out.pixelAspect = aspect;
    // Orientations from 5 on lay the picture on its side, and with it its pixels.
    if (spec.get_int_attribute("Orientation", 1) >= 5) out.pixelAspect = 1 / out.pixelAspect;

    const OIIO::ROI full(spec.full_x, spec.full_x + fullWidth, spec.full_y, spec.full_y + fullHeight, 0, 1, 0,
                         spec.nchannels);
    if (data.roi() != full) data = OIIO::ImageBufAlgo::cut(data, full);
    const OIIO::ImageBuf upright = OIIO::ImageBufAlgo::reorient(data);
    if (upright.has_error() || !upright.localpixels()) return refused(upright.geterror());
    arrange(upright, out);
    return out;
}

std::vector<float> matrixOf(const OIIO::ImageSpec& spec, const char* name) {
    const OIIO::ParamValue* value = spec.find_attribute(name, OIIO::TypeDesc::TypeMatrix);
    if (value == nullptr) return {};
    const auto* numbers = static_cast<const float*>(value->data());
    return {numbers, numbers + 16};
}

PictureHeader readHeader(const std::string& path) {
    PictureHeader out;
    const auto in = OIIO::ImageInput::open(path);
    if (!in) {
        out.problem = problemText(OIIO::geterror());
        return out;
    }
    const OIIO::ImageSpec& spec = in->spec();
    out.width = spec.full_width > 0 ? spec.full_width : spec.width;
    out.height = spec.full_height > 0 ? spec.full_height : spec.height;
    const double aspect = spec.get_float_attribute("PixelAspectRatio", 1.0f);
    if (aspect > 1e-3 && aspect < 1e3) out.pixelAspect = aspect;
    out.camera = spec.get_string_attribute("scrim:camera");
    out.worldToCamera = matrixOf(spec, "worldtocamera");  // what OpenImageIO calls OpenEXR's worldToCamera
    out.worldToNdc = matrixOf(spec, "worldToNDC");
    return out;
}

// In memory, since on a full disk OpenImageIO's PNG writer reports success and libjpeg ends the process.
FileBytes encoded(const std::string& name, const RgbPicture& picture) {
    const std::string extension = std::filesystem::path(name).extension().string();
    const std::unique_ptr<OIIO::ImageOutput> out = extension.empty() ? nullptr : OIIO::ImageOutput::create(name);
    if (!out || !out->supports("ioproxy")) {
        OIIO::geterror();  // forgotten: the text below says more
        return {{}, "its extension must name a picture format, such as '.png' or '.jpg'"};
    }
    FileBytes file;
    OIIO::Filesystem::IOVecOutput memory(file.bytes);
    out->set_ioproxy(&memory);
    const OIIO::ImageSpec spec(picture.width, picture.height, 3, OIIO::TypeDesc::UINT8);
    if (!out->open(name, spec) || !out->write_image(OIIO::TypeDesc::UINT8, picture.rgb.data()) || !out->close())
        return {{}, problemText(out->geterror())};
    return file;
}

/// Lists the formats, of which some set up tables of their own.
void prepare() {
    OIIO::attribute("threads", 1);
    OIIO::attribute("exr_threads", -1);  // none, where 0 would mean one a core
    (void)OIIO::get_string_attribute("extension_list");
}

}  // namespace

extern "C" __attribute__((visibility("default"))) const scrim::PictureModule* scrim_picture_module_3() {
    static const scrim::PictureModule module{prepare, readPixels, readHeader, encoded};
    return &module;
}
