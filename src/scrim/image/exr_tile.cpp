// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/exr_tile.h>

#include <scrim/base/error.h>
#include <scrim/image/exr_read.h>
#include <scrim/image/whole_picture.h>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDeepFrameBuffer.h>
#include <OpenEXR/ImfDeepScanLineInputFile.h>
#include <OpenEXR/ImfMultiPartInputFile.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStdIO.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfVersion.h>
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <set>
#include <system_error>

namespace scrim {
namespace {

[[noreturn]] void refuse(const std::string& path, const std::string& why) {
    throw Error(ErrorKind::input, fmt::format("cannot merge '{}': {}", path, why));
}

PixelWindow halfOpen(const Imath::Box2i& box) {
    return {box.min.x, box.min.y, box.max.x + 1, box.max.y + 1};
}

std::string textOf(const Imf::Header& header, const std::string& name) {
    const auto* text = header.findTypedAttribute<Imf::StringAttribute>(name);
    return text == nullptr ? "" : text->value();
}

std::vector<std::string> channelTexts(const Imf::Header& header) {
    std::vector<std::string> texts;
    for (auto it = header.channels().begin(); it != header.channels().end(); ++it) {
        const Imf::PixelType type = it.channel().type;
        texts.push_back(
            fmt::format("{}:{}", it.name(), type == Imf::HALF ? "half" : (type == Imf::FLOAT ? "float" : "uint")));
    }
    return texts;
}

/// Parses the attribute scrim:crop: "0,0,64,36 of 0,0,128,72".
void readCrop(ExrTile& tile) {
    const std::string text = textOf(tile.header, "scrim:crop");
    const PixelWindow display = halfOpen(tile.header.displayWindow());
    tile.crop = tile.data;
    if (text.empty()) {
        if (tile.header.findTypedAttribute<Imf::StringAttribute>("scrim:version") != nullptr)
            tile.crop.include(display);
        return;
    }
    PixelWindow a, b;
    int end = 0;
    if (std::sscanf(text.c_str(), "%d,%d,%d,%d of %d,%d,%d,%d%n", &a.x0, &a.y0, &a.x1, &a.y1, &b.x0, &b.y0, &b.x1,
                    &b.y1, &end) != 8 ||
        std::size_t(end) != text.size() || a.empty() || !b.contains(a) || !a.contains(tile.data))
        refuse(tile.path, fmt::format("its attribute scrim:crop is '{}'; expected X0,Y0,X1,Y1 of X0,Y0,X1,Y1, around "
                                      "its data window {}",
                                      shortened(text, 80), cropText(tile.data)));
    tile.crop = a;
    tile.picture = b;
}

/// True for an empty picture, which has one pixel at its corner because OpenEXR cannot express "none".
bool holdsNothing(const ExrTile& tile) {
    if (tile.data != PixelWindow{tile.crop.x0, tile.crop.y0, tile.crop.x0 + 1, tile.crop.y0 + 1}) return false;
    if (tile.deep) {
        Imf::DeepScanLineInputFile file(tile.path.c_str());
        unsigned count = 0;
        Imf::DeepFrameBuffer frame;
        frame.insertSampleCountSlice(Imf::Slice(Imf::UINT, reinterpret_cast<char*>(&count), 0, 0));
        file.setFrameBuffer(frame);
        file.readPixelSampleCounts(tile.data.y0);
        return count == 0;
    }
    for (auto it = tile.header.channels().begin(); it != tile.header.channels().end(); ++it)
        if (readExrChannel(tile.path, it.name()).front() != 0) return false;
    return true;
}

/// The bytes of an attribute in the file.
std::string bytesOf(const Imf::Attribute& attribute) {
    Imf::StdOSStream stream;
    attribute.writeValueTo(stream, Imf::EXR_VERSION);
    return fmt::format("{}:{}", attribute.typeName(), stream.str());
}

std::set<std::string> attributeNames(const Imf::Header& header) {
    std::set<std::string> names;
    for (auto it = header.begin(); it != header.end(); ++it) names.insert(it.name());
    return names;
}

/// True for attributes that describe a tile and not the picture.
bool isOfTile(const std::string& name) {
    return name.starts_with("scrim:verify:") || name.starts_with("scrim:tolerance:");
}

/// The parts of the picture that no tile covers, as cells between the edges of all tiles.
std::vector<PixelWindow> holesOf(const std::vector<ExrTile>& tiles, const PixelWindow& picture) {
    std::set<int> xs{picture.x0, picture.x1}, ys{picture.y0, picture.y1};
    for (const ExrTile& tile : tiles) {
        const PixelWindow part = intersection(tile.crop, picture);
        if (part.empty()) continue;
        xs.insert({part.x0, part.x1});
        ys.insert({part.y0, part.y1});
    }
    std::vector<PixelWindow> holes;
    for (auto y = ys.begin(); std::next(y) != ys.end(); ++y)
        for (auto x = xs.begin(); std::next(x) != xs.end(); ++x) {
            const PixelWindow cell{*x, *y, *std::next(x), *std::next(y)};
            const auto holds = [&](const ExrTile& tile) { return tile.crop.contains(cell); };
            if (std::none_of(tiles.begin(), tiles.end(), holds)) holes.push_back(cell);
        }
    return holes;
}

}  // namespace

std::string cropText(const PixelWindow& window) {
    return fmt::format("{},{},{},{}", window.x0, window.y0, window.x1, window.y1);
}

ExrTile readExrTile(const std::string& path) {
    std::error_code ignored;
    const std::filesystem::file_status status = std::filesystem::status(path, ignored);
    if (!std::filesystem::exists(status)) refuse(path, "there is no such file");
    if (!std::filesystem::is_regular_file(status)) refuse(path, "it is not a regular file");
    if (!isWholeExr(path)) refuse(path, "it is not an OpenEXR file, or it is truncated");
    ExrTile tile;
    tile.path = path;
    try {
        const Imf::MultiPartInputFile file(path.c_str());
        if (file.parts() != 1) refuse(path, fmt::format("it has {} parts; expected one", file.parts()));
        tile.header = file.header(0);
    } catch (const Error&) {
        throw;
    } catch (const std::exception& exception) {
        refuse(path, shortened(exception.what()));
    }
    const std::string type = tile.header.hasType() ? tile.header.type() : Imf::SCANLINEIMAGE;
    if (type != Imf::SCANLINEIMAGE && type != Imf::DEEPSCANLINE)
        refuse(path,
               fmt::format("it is of type '{}'; expected {}", type, choices({Imf::SCANLINEIMAGE, Imf::DEEPSCANLINE})));
    for (auto it = tile.header.channels().begin(); it != tile.header.channels().end(); ++it)
        if (it.channel().xSampling != 1 || it.channel().ySampling != 1)
            refuse(path, fmt::format("its channel '{}' is subsampled; expected all pixels", it.name()));
    tile.deep = type == Imf::DEEPSCANLINE;
    tile.data = halfOpen(tile.header.dataWindow());
    readCrop(tile);
    if (holdsNothing(tile)) tile.data = {};
    return tile;
}

void checkExrTiles(const std::vector<ExrTile>& tiles) {
    const ExrTile& first = tiles.front();
    PixelWindow picture = halfOpen(first.header.displayWindow());
    const auto kind = [](const ExrTile& tile) { return tile.deep ? "deep" : "flat"; };
    for (const ExrTile& tile : tiles) {
        const PixelWindow display = halfOpen(tile.header.displayWindow());
        if (display != halfOpen(first.header.displayWindow()))
            refuse(tile.path, fmt::format("its display window is {}, that of '{}' is {}", cropText(display), first.path,
                                          cropText(halfOpen(first.header.displayWindow()))));
        if (tile.deep != first.deep)
            refuse(tile.path, fmt::format("it is {}, and '{}' is {}", kind(tile), first.path, kind(first)));
        const std::vector<std::string> has = channelTexts(tile.header), wanted = channelTexts(first.header);
        if (has != wanted)
            refuse(tile.path, fmt::format("its channels are {}, those of '{}' are {}", fmt::join(has, " "), first.path,
                                          fmt::join(wanted, " ")));
        if (tile.picture && first.picture && *tile.picture != *first.picture)
            refuse(tile.path, fmt::format("it is a part of {}, and '{}' is one of {}", cropText(*tile.picture),
                                          first.path, cropText(*first.picture)));
        if (tile.picture) picture = *tile.picture;
    }
    const std::vector<PixelWindow> holes = holesOf(tiles, picture);
    if (holes.empty()) return;
    const std::string more = holes.size() > 1 ? fmt::format(", nor those of {} more boxes", holes.size() - 1) : "";
    throw Error(ErrorKind::input, fmt::format("a tile is missing: none holds the pixels {}{} of the picture {}",
                                              cropText(holes.front()), more, cropText(picture)));
}

Imf::Header mergedExrHeader(const std::vector<ExrTile>& tiles, std::vector<std::string>& leftOut) {
    // These belong to the file and not to the picture; checkExrTiles has compared the channels.
    static const std::set<std::string> ofFile{"dataWindow", "channels", "chunkCount", "scrim:crop", "type", "version"};
    Imf::Header merged = tiles.front().header;
    std::set<std::string> names;
    for (const ExrTile& tile : tiles) names.merge(attributeNames(tile.header));
    for (const std::string& name : names) {
        if (ofFile.contains(name)) continue;
        if (isOfTile(name)) {
            leftOut.push_back(name);
            merged.erase(name);
            continue;
        }
        if (name == "scrim:plan" || name == "scrim:stats") {
            std::vector<std::string> texts;
            for (const ExrTile& tile : tiles) texts.push_back(textOf(tile.header, name));
            if (tiles.size() > 1)
                merged.insert(name, Imf::StringAttribute(fmt::format("[{}]", fmt::join(texts, ", "))));
            continue;
        }
        const auto valueIn = [&](const ExrTile& tile) {
            const auto found = tile.header.find(name);
            return found == tile.header.end() ? std::string() : bytesOf(found.attribute());
        };
        for (const ExrTile& tile : tiles)
            if (valueIn(tile) != valueIn(tiles.front()))
                refuse(tile.path, fmt::format("it is not of the same render as '{}': the attribute '{}' differs",
                                              tiles.front().path, name));
    }
    // A picture of one part does not need these, and OpenEXR recomputes the count.
    for (const char* const name : {"chunkCount", "scrim:crop", "type", "version"}) merged.erase(name);
    return merged;
}

}  // namespace scrim
