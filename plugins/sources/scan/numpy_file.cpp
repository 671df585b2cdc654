// SPDX-License-Identifier: Apache-2.0
// Reads NumPy's .npy: a magic number, a Python dictionary with type, order and shape, and the samples (NumPy's NEP 1).
// An array is (nx, ny, nz), as in scrim.Field, or (nx, ny, nz, 3) of colours.
#include "scan.h"

#include <algorithm>
#include <charconv>
#include <fstream>
#include <optional>
#include <string_view>

#include <fmt/format.h>

namespace scan {
namespace {

/// What stands behind "'key':" in the dictionary, up to the end of the text.
std::string_view behind(std::string_view dictionary, std::string_view key, const std::string& path) {
    const std::string quoted = fmt::format("'{}':", key);
    const std::size_t at = dictionary.find(quoted);
    if (at == std::string_view::npos) refuse(path, fmt::format("its header has no '{}'", key));
    std::string_view rest = dictionary.substr(at + quoted.size());
    rest.remove_prefix(std::min(rest.find_first_not_of(' '), rest.size()));
    return rest;
}

std::string dictionaryOf(const std::string& path, std::int64_t& headerBytes) {
    constexpr std::string_view kMagic = "\x93NUMPY";
    std::ifstream file(path, std::ios::binary);
    std::string start(12, '\0');
    file.read(start.data(), static_cast<std::streamsize>(start.size()));
    if (!start.starts_with(kMagic) || file.gcount() < 10) refuse(path, "is not a NumPy file (.npy)");
    const bool isLong = start[6] > 1;  // the version: the length has 4 bytes
    std::int64_t length = 0;
    for (int i = isLong ? 3 : 1; i >= 0; --i)
        length = length << 8 | static_cast<unsigned char>(start[static_cast<std::size_t>(8 + i)]);
    headerBytes = (isLong ? 12 : 10) + length;
    constexpr std::int64_t kLongest = 65536;
    if (length > kLongest || headerBytes > fileBytes(path)) refuse(path, "its header is damaged");
    std::string text(static_cast<std::size_t>(length), '\0');
    file.seekg(headerBytes - length);
    file.read(text.data(), length);
    return text;
}

/// The type of "'<f4', ...".
std::optional<SampleType> typeOf(std::string_view descr) {
    using enum SampleType;
    constexpr std::array<std::pair<std::string_view, SampleType>, 12> kTypes{{{"u1", uint8},
                                                                              {"b1", uint8},
                                                                              {"i1", int8},
                                                                              {"u2", uint16},
                                                                              {"i2", int16},
                                                                              {"u4", uint32},
                                                                              {"i4", int32},
                                                                              {"u8", uint64},
                                                                              {"i8", int64},
                                                                              {"f2", float16},
                                                                              {"f4", float32},
                                                                              {"f8", float64}}};
    if (descr.size() < 5 || descr[0] != '\'' || descr[4] != '\'') return {};
    for (const auto& [name, type] : kTypes)
        if (descr.substr(2, 2) == name) return type;
    return {};
}

/// The shape of an array; the fourth number is 3 for colours and else 1.
std::array<std::int64_t, 4> shapeOf(std::string_view text, const std::string& path) {
    const std::size_t close = text.find(')');
    if (!text.starts_with('(') || close == std::string_view::npos) refuse(path, "its header is damaged");
    const std::string_view shape = text.substr(0, close + 1);
    std::array<std::int64_t, 4> size{1, 1, 1, 1};
    std::size_t count = 0;
    const char* at = shape.data() + 1;
    const char* const end = shape.data() + close;
    for (; at < end; ++at) {
        if (*at == ' ' || *at == ',') continue;
        std::int64_t number = 0;
        const auto [stop, error] = std::from_chars(at, end, number);
        if (error != std::errc()) refuse(path, "its header is damaged");
        if (count < size.size()) size[count] = number;
        ++count;
        at = stop - 1;
    }
    if (count != 3 && (count != 4 || size[3] != 3))
        refuse(path, fmt::format("its array is of shape {}, expected (nx, ny, nz), or (nx, ny, nz, 3) for colours",
                                 shape.substr(0, 80)));
    return size;
}

}  // namespace

Scan readNumpy(const std::string& path) {
    fileBytes(path);
    RawLayout layout;
    const std::string dictionary = dictionaryOf(path, layout.header);
    const std::string_view descr = behind(dictionary, "descr", path);
    const auto type = typeOf(descr);
    if (!type)
        refuse(path, fmt::format("its array holds {}, expected whole or real numbers",
                                 descr.substr(0, std::min<std::size_t>(descr.find(','), 40))));
    layout.type = *type;
    layout.bigEndian = descr[1] == '>';
    const bool xFastest = behind(dictionary, "fortran_order", path).starts_with("True");
    const auto [nx, ny, nz, parts] = shapeOf(behind(dictionary, "shape", path), path);
    Scan scan;
    scan.size = {nx, ny, nz};
    const std::int64_t count = sampleCount(scan.size, path);
    // Colours lie along the slowest of three axes, or along the fastest.
    layout.size =
        xFastest ? Size{nx, ny, sampleCount({nz, parts, 1}, path)} : Size{sampleCount({nz, parts, 1}, path), ny, nx};
    scan.type = parts == 3 ? colourTypeOf(layout.type) : nameOf(layout.type);
    std::vector<float> stored = readRaw(path, layout);
    if (xFastest && parts == 1) {
        scan.values = std::move(stored);
        return scan;
    }
    std::vector<float> sorted(stored.size());
    auto to = sorted.begin();
    for (std::int64_t z = 0; z < nz; ++z)
        for (std::int64_t y = 0; y < ny; ++y)
            for (std::int64_t x = 0; x < nx; ++x)
                for (std::int64_t part = 0; part < parts; ++part)
                    *to++ =
                        stored[static_cast<std::size_t>(xFastest ? part * count + std::int64_t(scan.indexOf(x, y, z))
                                                                 : ((x * ny + y) * nz + z) * parts + part)];
    if (parts == 3)
        addColours(sorted, layout.type, scan);
    else
        scan.values = std::move(sorted);
    return scan;
}

}  // namespace scan
