// SPDX-License-Identifier: Apache-2.0
// Reads MetaImage (.mha, and .mhd with its samples in another file), the format of ITK: lines "Key = value", of which
// ElementDataFile is the last, and samples like those of a raw file, which may be deflated.
#include "scan.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string_view>

#include <fmt/format.h>

namespace scan {
namespace {

constexpr std::size_t kLongestHeader = 65536;

struct Header {
    std::map<std::string, std::string> values;  ///< by key
    std::int64_t bytes = 0;                     ///< up to the samples
};

Header headerOf(const std::string& path) {
    Header header;
    std::ifstream file(path, std::ios::binary);
    std::string line;
    while (std::getline(file, line) && static_cast<std::size_t>(file.tellg()) < kLongestHeader) {
        const std::size_t equals = line.find('=');
        if (equals == std::string::npos) break;
        const auto trimmed = [](std::string text) {
            constexpr const char* kSpace = " \t\r";
            text.erase(0, std::min(text.find_first_not_of(kSpace), text.size()));
            text.erase(text.find_last_not_of(kSpace) + 1);
            return text;
        };
        const std::string key = trimmed(line.substr(0, equals));
        header.values[key] = trimmed(line.substr(equals + 1));
        if (key != "ElementDataFile") continue;
        header.bytes = static_cast<std::int64_t>(file.tellg());
        return header;
    }
    refuse(path, "is not MetaImage: its header has no 'ElementDataFile'");
}

/// The numbers of a key; `standard` where the header lacks it.
template <std::size_t N>
std::array<double, N> numbers(const Header& header, const std::string& key, std::array<double, N> standard,
                              const std::string& path) {
    const auto found = header.values.find(key);
    if (found == header.values.end()) return standard;
    std::istringstream words(found->second);
    for (double& number : standard)
        if (!(words >> number)) refuse(path, fmt::format("'{}' needs {} numbers", key, N));
    return standard;
}

std::string textOf(const Header& header, const std::string& key, const std::string& other = "") {
    const auto found = header.values.find(key);
    const auto second = header.values.find(other);
    return found != header.values.end() ? found->second : second != header.values.end() ? second->second : "";
}

bool isTrue(const std::string& text) {
    return !text.empty() && (text[0] == 'T' || text[0] == 't' || text[0] == '1');
}

SampleType typeOf(const std::string& name, const std::string& path) {
    constexpr std::array<std::pair<std::string_view, SampleType>, 12> kTypes{{
        {"MET_UCHAR", SampleType::uint8},
        {"MET_CHAR", SampleType::int8},
        {"MET_USHORT", SampleType::uint16},
        {"MET_SHORT", SampleType::int16},
        {"MET_UINT", SampleType::uint32},
        {"MET_INT", SampleType::int32},
        {"MET_ULONG", SampleType::uint32},  // 4 bytes in files
        {"MET_LONG", SampleType::int32},
        {"MET_ULONG_LONG", SampleType::uint64},
        {"MET_LONG_LONG", SampleType::int64},
        {"MET_FLOAT", SampleType::float32},
        {"MET_DOUBLE", SampleType::float64},
    }};
    for (const auto& [known, type] : kTypes)
        if (name == known) return type;
    refuse(path, fmt::format("holds samples of type '{}', expected MET_UCHAR, MET_SHORT, MET_FLOAT or another number",
                             name.substr(0, 40)));
}

/// Steps and origin. The rows of the matrix are the directions of the axes.
void place(const Header& header, const std::string& path, Scan& scan) {
    const auto keyOf = [&](std::initializer_list<const char*> names) {
        for (const char* name : names)
            if (header.values.contains(name)) return std::string(name);
        return std::string(*names.begin());
    };
    const std::array<double, 3> size = numbers<3>(header, "ElementSize", {1, 1, 1}, path);
    const std::array<double, 3> spacing = numbers<3>(header, "ElementSpacing", size, path);
    const std::array<double, 3> origin = numbers<3>(header, keyOf({"Offset", "Position", "Origin"}), {0, 0, 0}, path);
    const std::array<double, 9> axes =
        numbers<9>(header, keyOf({"TransformMatrix", "Rotation", "Orientation"}), {1, 0, 0, 0, 1, 0, 0, 0, 1}, path);
    for (int k = 0; k < 3; ++k) {
        for (int row = 0; row < 3; ++row)
            scan.axes[k][row] = axes[static_cast<std::size_t>(3 * k + row)] * spacing[static_cast<std::size_t>(k)];
        scan.origin[k] = origin[static_cast<std::size_t>(k)];
    }
    scan.space = "left-posterior-superior";  // ITK's
}

/// The file of the samples.
std::string dataFile(const Header& header, const std::string& path) {
    const std::string name = textOf(header, "ElementDataFile");
    if (lowerCase(name) == "local") return path;
    if (lowerCase(name).starts_with("list") || name.find('%') != std::string::npos)
        refuse(path, "its samples are in several files, expected one; open and save it in 3D Slicer");
    checkWithin(name, path);
    return (std::filesystem::path(path).parent_path() / std::filesystem::path(name).lexically_normal()).string();
}

}  // namespace

Scan readMetaImage(const std::string& path) {
    fileBytes(path);
    const Header header = headerOf(path);
    const double dimensions = numbers<1>(header, "NDims", {3}, path)[0];
    if (dimensions != 3) refuse(path, fmt::format("has {} dimensions, expected 3", dimensions));
    if (const std::string channels = textOf(header, "ElementNumberOfChannels"); !channels.empty() && channels != "1")
        refuse(path, fmt::format("has {} numbers a sample, expected 1", channels.substr(0, 40)));
    if (lowerCase(textOf(header, "BinaryData")).starts_with('f'))
        refuse(path, "holds its samples as text: save it anew");
    Scan scan;
    const std::array<double, 3> size = numbers<3>(header, "DimSize", {0, 0, 0}, path);
    for (std::size_t k = 0; k < 3; ++k) scan.size[k] = static_cast<std::int64_t>(std::clamp(size[k], 0.0, 1e12));
    place(header, path, scan);
    RawLayout layout;
    layout.size = scan.size;
    layout.type = typeOf(textOf(header, "ElementType"), path);
    layout.bigEndian = isTrue(textOf(header, "BinaryDataByteOrderMSB", "ElementByteOrderMSB"));
    layout.deflated = isTrue(textOf(header, "CompressedData"));
    layout.exact = false;
    const std::string file = dataFile(header, path);
    const auto skipped = static_cast<std::int64_t>(numbers<1>(header, "HeaderSize", {0}, path)[0]);
    layout.header = file == path ? header.bytes : std::max<std::int64_t>(skipped, 0);
    if (skipped == -1 && file != path && !layout.deflated)  // the samples are at the file's end
        layout.header =
            std::max<std::int64_t>(fileBytes(file) - sampleCount(layout.size, path) * bytesOf(layout.type), 0);
    scan.type = nameOf(layout.type);
    scan.values = readRaw(file, layout);
    return scan;
}

}  // namespace scan
