// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/exr_read.h>

#include <scrim/base/error.h>

#include <OpenEXR/ImfBoxAttribute.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfChannelListAttribute.h>
#include <OpenEXR/ImfChromaticitiesAttribute.h>
#include <OpenEXR/ImfCompressionAttribute.h>
#include <OpenEXR/ImfDoubleAttribute.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfIntAttribute.h>
#include <OpenEXR/ImfMatrixAttribute.h>
#include <OpenEXR/ImfRationalAttribute.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfVecAttribute.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace scrim {

namespace {

template <typename Call>
auto reading(const std::string& path, const Call& call) {
    try {
        return call();
    } catch (const Error&) {
        throw;
    } catch (const std::exception& exception) {
        throw Error(ErrorKind::input, fmt::format("cannot read '{}': {}", path, shortened(exception.what())));
    }
}

PixelWindow halfOpen(const Imath::Box2i& box) {
    return {box.min.x, box.min.y, box.max.x + 1, box.max.y + 1};
}

/// Reads the channels `names`, interleaved; channels that the file lacks are filled with the matching value of `fill`.
std::vector<float> readChannels(Imf::InputFile& file, const std::vector<std::string>& names,
                                const std::vector<double>& fill) {
    const Imath::Box2i box = file.header().dataWindow();
    const PixelWindow window = halfOpen(box);
    const std::size_t pixelBytes = names.size() * sizeof(float);
    std::vector<float> values(names.size() * window.pixelCount());
    Imf::FrameBuffer frame;
    for (std::size_t c = 0; c < names.size(); ++c)
        frame.insert(names[c], Imf::Slice::Make(Imf::FLOAT, values.data() + c, box, pixelBytes,
                                                std::size_t(window.width()) * pixelBytes, 1, 1, fill[c]));
    file.setFrameBuffer(frame);
    file.readPixels(box.min.y, box.max.y);
    return values;
}

std::string channelsText(const Imf::ChannelList& channels) {
    std::vector<std::string> texts;
    for (auto it = channels.begin(); it != channels.end(); ++it) {
        const Imf::PixelType type = it.channel().type;
        texts.push_back(
            fmt::format("{}:{}", it.name(), type == Imf::HALF ? "half" : (type == Imf::FLOAT ? "float" : "uint")));
    }
    return fmt::format("{}", fmt::join(texts, " "));
}

std::string compressionText(Imf::Compression compression) {
    switch (compression) {
        case Imf::NO_COMPRESSION:
            return "none";
        case Imf::ZIPS_COMPRESSION:
            return "zips";
        case Imf::ZIP_COMPRESSION:
            return "zip";
        case Imf::PIZ_COMPRESSION:
            return "piz";
        case Imf::DWAA_COMPRESSION:
            return "dwaa";
        default:
            return fmt::format("compression {}", static_cast<int>(compression));
    }
}

std::string attributeText(const Imf::Attribute& attribute) {
    if (const auto* text = dynamic_cast<const Imf::StringAttribute*>(&attribute)) return text->value();
    if (const auto* number = dynamic_cast<const Imf::IntAttribute*>(&attribute))
        return fmt::format("{}", number->value());
    if (const auto* number = dynamic_cast<const Imf::FloatAttribute*>(&attribute))
        return fmt::format("{}", number->value());
    if (const auto* number = dynamic_cast<const Imf::DoubleAttribute*>(&attribute))
        return fmt::format("{}", number->value());
    if (const auto* rate = dynamic_cast<const Imf::RationalAttribute*>(&attribute))
        return fmt::format("{}/{}", rate->value().n, rate->value().d);
    if (const auto* point = dynamic_cast<const Imf::V2fAttribute*>(&attribute))
        return fmt::format("{} {}", point->value().x, point->value().y);
    if (const auto* matrix = dynamic_cast<const Imf::M44fAttribute*>(&attribute)) {
        const float* values = matrix->value().getValue();
        return fmt::format("{}", fmt::join(values, values + 16, " "));
    }
    if (const auto* box = dynamic_cast<const Imf::Box2iAttribute*>(&attribute)) {
        const PixelWindow window = halfOpen(box->value());
        return fmt::format("{} {} {} {}", window.x0, window.y0, window.x1, window.y1);
    }
    if (const auto* list = dynamic_cast<const Imf::ChannelListAttribute*>(&attribute))
        return channelsText(list->value());
    if (const auto* compression = dynamic_cast<const Imf::CompressionAttribute*>(&attribute))
        return compressionText(compression->value());
    if (const auto* xy = dynamic_cast<const Imf::ChromaticitiesAttribute*>(&attribute)) {
        const Imf::Chromaticities& c = xy->value();
        return fmt::format("{} {} {} {} {} {} {} {}", c.red.x, c.red.y, c.green.x, c.green.y, c.blue.x, c.blue.y,
                           c.white.x, c.white.y);
    }
    return fmt::format("({})", attribute.typeName());
}

}  // namespace

Image readExr(const std::string& path) {
    return reading(path, [&] {
        Imf::InputFile file(path.c_str());
        Image image;
        image.window = halfOpen(file.header().dataWindow());
        image.rgba = readChannels(file, {"R", "G", "B", "A"}, {0, 0, 0, 1});
        return image;
    });
}

std::vector<float> readExrChannel(const std::string& path, const std::string& channel) {
    return reading(path, [&] {
        Imf::InputFile file(path.c_str());
        if (file.header().channels().findChannel(channel) == nullptr)
            throw Error(ErrorKind::input, fmt::format("'{}' has no channel '{}'; it has {}", path, channel,
                                                      channelsText(file.header().channels())));
        return readChannels(file, {channel}, {0});
    });
}

std::map<std::string, std::string> readExrAttributes(const std::string& path) {
    return reading(path, [&] {
        const Imf::InputFile file(path.c_str());
        std::map<std::string, std::string> texts;
        for (auto it = file.header().begin(); it != file.header().end(); ++it)
            texts[it.name()] = attributeText(it.attribute());
        return texts;
    });
}

}  // namespace scrim
