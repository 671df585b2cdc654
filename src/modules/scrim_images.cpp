// SPDX-License-Identifier: Apache-2.0
// The module `scrim_images`: the only code that reads and writes through OpenImageIO.
#include <scrim/image/picture_module.h>

#include <OpenImageIO/deepdata.h>
#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imagebuf.h>
#include <OpenImageIO/imagebufalgo.h>
#include <OpenImageIO/imageio.h>
#include <OpenImageIO/strutil.h>
#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <iterator>
#include <memory>
#include <utility>

namespace {

using scrim::FileBytes;
using scrim::FileDepth;
using scrim::FilePicture;
using scrim::PictureHeader;
using scrim::RgbPicture;

/// Indices of red, green, blue and alpha among a file's channels; alpha -1: none.
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
    // Some formats declare an alpha that their pictures do not have.
    if (spec.nchannels == 1 || channels.alpha >= spec.nchannels) channels.alpha = -1;
    return channels;
}

/// The problem's text; never empty, since an empty text means that there is no problem.
std::string problemText(const std::string& ofOpenImageIo) {
    return ofOpenImageIo.empty() ? "OpenImageIO gives no reason" : ofOpenImageIo;
}

FilePicture refused(const std::string& problem) {
    FilePicture out;
    out.problem = problemText(problem);
    return out;
}

/// Rearranges the file's channels as RGBA.
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
    // Colour must be converted before it is multiplied by alpha, so it is requested as the file has it.
    OIIO::ImageSpec wishes;
    wishes.attribute("oiio:UnassociatedAlpha", 1);
    const auto in = OIIO::ImageInput::open(path, &wishes);
    if (!in) return refused(OIIO::geterror());
    const OIIO::ImageSpec& spec = in->spec();
    const int fullWidth = spec.full_width > 0 ? spec.full_width : spec.width;
    const int fullHeight = spec.full_height > 0 ? spec.full_height : spec.height;
    if (spec.depth > 1 || spec.deep || spec.nchannels < 1 || spec.width < 1 || spec.height < 1)
        return refused("it has no flat picture");
    const auto pixels = [](int width, int height) { return static_cast<double>(width) * height; };
    const auto most = static_cast<double>(scrim::kMostTexturePixels);
    if (std::max(pixels(spec.width, spec.height), pixels(fullWidth, fullHeight)) > most || spec.nchannels > 64)
        return refused(fmt::format("it has {} x {} pixels of {} channels; expected at most {} million pixels of 64",
                                   fullWidth, fullHeight, spec.nchannels, scrim::kMostTexturePixels / 1000000));

    OIIO::ImageSpec stored = spec;
    stored.set_format(OIIO::TypeDesc::FLOAT);
    stored.channelformats.clear();
    // Some formats do not name their channels, and OpenImageIO ends the process if one asks for them by name.
    if (stored.channelnames.size() != std::size_t(stored.nchannels)) stored.default_channel_names();
    OIIO::ImageBuf data(stored);
    if (!in->read_image(0, 0, 0, spec.nchannels, OIIO::TypeDesc::FLOAT, data.localpixels()) || in->has_error())
        return refused(in->geterror());
    FilePicture out;
    out.integers = !spec.format.is_floating_point();
    out.alphaApart = spec.get_int_attribute("oiio:UnassociatedAlpha", 0) != 0;
    const double aspect = spec.get_float_attribute("PixelAspectRatio", 1.0f);
    if (aspect > 1e-3 && aspect < 1e3) out.pixelAspect = aspect;
    // Orientations from 5 on turn the picture on its side, and its pixels with it.
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
    out.worldToCamera = matrixOf(spec, "worldtocamera");  // OpenImageIO's name of OpenEXR's worldToCamera
    out.worldToNdc = matrixOf(spec, "worldToNDC");
    return out;
}

/// A channel of one of a file's parts.
struct DepthChannel {
    int part = 0, channel = 0;
    std::string name;  ///< its name in a scene
};

std::vector<DepthChannel> channelsOf(OIIO::ImageInput& in) {
    constexpr int kMostParts = 256;
    std::vector<DepthChannel> all;
    for (int part = 0; part < kMostParts && in.seek_subimage(part, 0); ++part) {
        const OIIO::ImageSpec& spec = in.spec();
        const std::string of = in.supports("multiimage") ? spec.get_string_attribute("oiio:subimagename") : "";
        for (int c = 0; c < spec.nchannels && std::size_t(c) < spec.channelnames.size(); ++c) {
            const std::string& name = spec.channelnames[std::size_t(c)];
            all.push_back({part, c, of.empty() || name.starts_with(of + ".") ? name : of + "." + name});
        }
    }
    in.geterror();  // clears the error that there are no more parts
    return all;
}

std::string namesOf(const std::vector<DepthChannel>& channels) {
    constexpr std::size_t kMostNamed = 24;
    std::string text;
    for (std::size_t i = 0; i < channels.size() && i < kMostNamed; ++i)
        text += (i > 0 ? ", " : "") + ("'" + channels[i].name + "'");
    return channels.size() > kMostNamed ? fmt::format("{} and {} more", text, channels.size() - kMostNamed) : text;
}

std::string lastPart(const std::string& name) {
    return name.substr(name.rfind('.') + 1);
}

/// The channels that may be meant: those called `name`, or else those with a usual name for depth.
std::vector<DepthChannel> depthChannels(const std::vector<DepthChannel>& all, const std::string& name) {
    std::vector<DepthChannel> found;
    const auto take = [&](const auto& isMeant) {
        if (found.empty()) std::copy_if(all.begin(), all.end(), std::back_inserter(found), isMeant);
    };
    if (!name.empty()) {
        take([&](const DepthChannel& c) { return c.name == name; });
        take([&](const DepthChannel& c) { return c.name.ends_with("." + name); });
        return found;
    }
    take([](const DepthChannel& c) { return c.name == "Z"; });
    take([](const DepthChannel& c) { return OIIO::Strutil::iequals(lastPart(c.name), "Z"); });
    take([](const DepthChannel& c) { return OIIO::Strutil::iequals(lastPart(c.name), "depth"); });
    if (all.size() == 1) take([](const DepthChannel&) { return true; });
    return found;
}

FileDepth noDepth(const std::string& problem) {
    FileDepth out;
    out.problem = problemText(problem);
    return out;
}

/// Reads Z, ZBack and alpha of all samples.
FileDepth readDeep(OIIO::ImageInput& in, const DepthChannel& z, FileDepth out) {
    const OIIO::ImageSpec spec = in.spec();
    const std::string prefix = spec.channelnames[std::size_t(z.channel)];
    const std::string layer = prefix.substr(0, prefix.size() - lastPart(prefix).size());
    const int back = spec.channelindex(layer + "ZBack"), alpha = spec.channelindex(layer + "A");
    if (alpha < 0) return noDepth(fmt::format("its deep samples have no channel '{}A' for their opacity", layer));
    OIIO::DeepData data;
    if (!in.read_native_deep_image(z.part, 0, data)) return noDepth(in.geterror());
    const auto pixels = std::int64_t{spec.width} * spec.height;
    if (data.pixels() < pixels) return noDepth("its deep samples are incomplete");
    std::size_t samples = 0;
    for (std::int64_t p = 0; p < pixels; ++p) samples += std::size_t(std::max(data.samples(p), 0));
    if (samples > scrim::kMostDepthSamples)
        return noDepth(fmt::format("it has {} samples; expected at most {}", samples, scrim::kMostDepthSamples));
    out.samples.reserve(3 * samples);
    for (std::int64_t p = 0; p < pixels; ++p) {
        const int count = std::max(data.samples(p), 0);
        out.counts.push_back(static_cast<std::uint32_t>(count));
        for (int s = 0; s < count; ++s) {
            const float front = data.deep_value(p, z.channel, s);
            out.samples.push_back(front);
            out.samples.push_back(back < 0 ? front : data.deep_value(p, back, s));
            out.samples.push_back(data.deep_value(p, alpha, s));
        }
    }
    return out;
}

FileDepth readDepth(const std::string& path, const std::string& channel) {
    const auto in = OIIO::ImageInput::open(path);
    if (!in) return noDepth(OIIO::geterror());
    const std::vector<DepthChannel> all = channelsOf(*in), meant = depthChannels(all, channel);
    if (meant.empty() && !channel.empty())
        return noDepth(fmt::format("it has no channel '{}'; expected one of {}", channel, namesOf(all)));
    if (meant.empty())
        return noDepth(
            fmt::format("no channel is called Z or depth; expected 'channel' to be one of {}", namesOf(all)));
    if (meant.size() > 1)
        return noDepth(
            fmt::format("it has several channels of depths; expected 'channel' to be one of {}", namesOf(meant)));
    const DepthChannel& z = meant.front();
    if (!in->seek_subimage(z.part, 0)) return noDepth(in->geterror());
    const OIIO::ImageSpec spec = in->spec();
    const auto pixels = [](int width, int height) { return static_cast<double>(width) * height; };
    const auto most = static_cast<double>(scrim::kMostTexturePixels);
    if (spec.depth > 1 || spec.width < 1 || spec.height < 1 || pixels(spec.width, spec.height) > most)
        return noDepth(fmt::format("it has {} x {} pixels; expected at most {} million", spec.width, spec.height,
                                   scrim::kMostTexturePixels / 1000000));
    if (!spec.channelformat(z.channel).is_floating_point())
        return noDepth(fmt::format("its channel '{}' holds whole numbers; expected depths as floats", z.name));
    FileDepth out;
    out.fullWidth = spec.full_width > 0 ? spec.full_width : spec.width;
    out.fullHeight = spec.full_height > 0 ? spec.full_height : spec.height;
    out.x0 = spec.x - spec.full_x;
    out.y0 = spec.y - spec.full_y;
    out.width = spec.width;
    out.height = spec.height;
    out.deep = spec.deep;
    if (spec.deep) return readDeep(*in, z, std::move(out));
    out.depths.resize(std::size_t(spec.width) * std::size_t(spec.height));
    if (!in->read_image(z.part, 0, z.channel, z.channel + 1, OIIO::TypeDesc::FLOAT, out.depths.data()) ||
        in->has_error())
        return noDepth(in->geterror());
    return out;
}

// The picture is encoded in memory, because on a full disk OpenImageIO's PNG writer reports success and libjpeg ends
// the process.
FileBytes encoded(const std::string& name, const RgbPicture& picture) {
    const std::string extension = std::filesystem::path(name).extension().string();
    const std::unique_ptr<OIIO::ImageOutput> out = extension.empty() ? nullptr : OIIO::ImageOutput::create(name);
    if (!out || !out->supports("ioproxy")) {
        OIIO::geterror();  // drops the error; the text below is more helpful
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

/// Lists the formats now, since some of them set up tables of their own.
void prepare() {
    OIIO::attribute("threads", 1);
    OIIO::attribute("exr_threads", -1);  // -1 means no threads; 0 would mean one per core
    (void)OIIO::get_string_attribute("extension_list");
}

}  // namespace

extern "C" __attribute__((visibility("default"))) const scrim::PictureModule* scrim_picture_module_4() {
    static const scrim::PictureModule module{prepare, readPixels, readHeader, readDepth, encoded};
    return &module;
}
