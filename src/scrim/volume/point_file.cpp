// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/point_file.h>

#include <scrim/base/error.h>
#include <scrim/base/letter_case.h>
#include <scrim/geometry/bounds.h>

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <limits>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

namespace scrim {
namespace {

constexpr std::string_view kPly = "ply", kNumpy = "\x93NUMPY";
constexpr std::uint64_t kLongestHeader = 1 << 16;
constexpr std::uint64_t kMostPoints = std::numeric_limits<std::uint32_t>::max();

[[noreturn]] void fail(const VdbBytes& bytes, const std::string& reason) {
    throw Error(ErrorKind::input, shortened(bytes.path() + ": " + reason, 1000));
}

template <typename T>
double numberAt(const char* at, bool swap) {
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), at, sizeof(T));
    if (swap) std::reverse(raw.begin(), raw.end());
    return static_cast<double>(std::bit_cast<T>(raw));
}

/// A type of numbers by its names in PLY and in NumPy.
struct NumberType {
    std::array<std::string_view, 3> names;
    std::size_t bytes;
    double (*read)(const char*, bool swap);
};
constexpr std::array<NumberType, 8> kTypes{{
    {{"char", "int8", "i1"}, 1, numberAt<std::int8_t>},
    {{"uchar", "uint8", "u1"}, 1, numberAt<std::uint8_t>},
    {{"short", "int16", "i2"}, 2, numberAt<std::int16_t>},
    {{"ushort", "uint16", "u2"}, 2, numberAt<std::uint16_t>},
    {{"int", "int32", "i4"}, 4, numberAt<std::int32_t>},
    {{"uint", "uint32", "u4"}, 4, numberAt<std::uint32_t>},
    {{"float", "float32", "f4"}, 4, numberAt<float>},
    {{"double", "float64", "f8"}, 8, numberAt<double>},
}};

const NumberType* typeCalled(std::string_view name) {
    for (const NumberType& type : kTypes)
        if (std::find(type.names.begin(), type.names.end(), name) != type.names.end()) return &type;
    return nullptr;
}

/// Numbers of all points, column by column.
struct Columns {
    std::vector<std::string> names;
    std::vector<std::vector<double>> values;

    const std::vector<double>* called(std::string_view name) const {
        const auto found = std::find(names.begin(), names.end(), name);
        return found == names.end() ? nullptr : &values[static_cast<std::size_t>(found - names.begin())];
    }
};

/// The usual distance of neighbours: they are taken for evenly spread in their box, or in the plane or line that it is.
double spacingOf(const std::vector<Vec3>& positions) {
    Bounds box;
    for (const Vec3& p : positions)
        if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)) box.include(p);
    if (box.empty() || !(largest(box.size()) > 0)) return 1;
    double product = 1;
    int wide = 0;
    for (int axis = 0; axis < 3; ++axis)
        if (box.size()[axis] > 1e-6 * largest(box.size())) {
            product *= box.size()[axis];
            ++wide;
        }
    return std::pow(product / static_cast<double>(positions.size()), 1.0 / wide);
}

PointCloud cloudOf(const Columns& columns) {
    PointCloud cloud;
    cloud.name = "points";
    std::vector<std::string> used;
    const auto take = [&](std::array<std::string_view, 3> names) -> std::array<const std::vector<double>*, 3> {
        std::array<const std::vector<double>*, 3> parts{};
        for (std::size_t c = 0; c < 3; ++c) parts[c] = columns.called(names[c]);
        if (parts[0] != nullptr && parts[1] != nullptr && parts[2] != nullptr)
            used.insert(used.end(), names.begin(), names.end());
        else
            parts.fill(nullptr);
        return parts;
    };
    const auto [x, y, z] = take({"x", "y", "z"});
    for (std::size_t i = 0; i < x->size(); ++i) cloud.positions.emplace_back((*x)[i], (*y)[i], (*z)[i]);
    const auto addVectors = [&](const char* name, std::array<std::string_view, 3> names) {
        const auto parts = take(names);
        if (parts[0] == nullptr) return;
        PointAttribute& attribute = cloud.attributes.emplace_back(PointAttribute{name, 3, {}});
        for (std::size_t i = 0; i < cloud.positions.size(); ++i)
            for (const auto* part : parts) attribute.values.push_back(static_cast<float>((*part)[i]));
    };
    addVectors("v", {"vx", "vy", "vz"});
    addVectors("Cd", {"red", "green", "blue"});
    for (std::size_t c = 0; c < columns.names.size(); ++c) {
        if (std::find(used.begin(), used.end(), columns.names[c]) != used.end()) continue;
        PointAttribute& attribute = cloud.attributes.emplace_back(PointAttribute{columns.names[c], 1, {}});
        for (const double value : columns.values[c]) attribute.values.push_back(static_cast<float>(value));
    }
    cloud.spacing = spacingOf(cloud.positions);
    return cloud;
}

struct PlyHeader {
    bool text = false, bigEndian = false;
    std::uint64_t points = 0;
    std::vector<std::pair<std::string, const NumberType*>> properties;
    std::uint64_t end = 0;
};

/// Reads the properties of the vertices, which must be the first element.
PlyHeader plyHeader(const VdbBytes& bytes, const std::string& start) {
    constexpr std::string_view kEnd = "end_header";
    const std::size_t end = start.find(kEnd);
    const std::size_t lineEnd = end == std::string::npos ? end : start.find('\n', end);
    if (lineEnd == std::string::npos) fail(bytes, "damaged: its PLY header has no end");
    PlyHeader header;
    header.end = lineEnd + 1;
    std::istringstream lines(start.substr(0, end));
    std::string element;
    for (std::string line; std::getline(lines, line);) {
        std::istringstream words(line);
        std::string word, type, name;
        words >> word;
        if (word == "format") {
            words >> type;
            header.text = type == "ascii";
            header.bigEndian = type == "binary_big_endian";
            if (!header.text && !header.bigEndian && type != "binary_little_endian")
                fail(bytes, fmt::format("damaged: its PLY format is '{}'", shortened(type, 40)));
        } else if (word == "element") {
            std::uint64_t count = 0;
            const bool isFirst = element.empty();
            if (!(words >> element >> count)) fail(bytes, "damaged: its PLY header has an element without a count");
            if (isFirst != (element == "vertex"))
                fail(bytes, fmt::format("its first PLY element is '{}', expected 'vertex'", shortened(element, 40)));
            if (isFirst) header.points = count;
            if (element == "face" && count > 0)
                fail(bytes, fmt::format("has {} faces: it is a mesh, of which source = \"mesh\" makes fog", count));
        } else if (word == "property" && element == "vertex") {
            words >> type >> name;
            const NumberType* const known = typeCalled(type);
            if (known == nullptr || name.empty())
                fail(bytes, fmt::format("a vertex has a property of type '{}', expected numbers", shortened(type, 40)));
            header.properties.emplace_back(name, known);
        }
    }
    for (const char* name : {"x", "y", "z"})
        if (std::none_of(header.properties.begin(), header.properties.end(),
                         [&](const auto& property) { return property.first == name; }))
            fail(bytes, fmt::format("its vertices have no '{}'", name));
    return header;
}

/// Refuses counts that the file cannot hold.
void checkCount(const VdbBytes& bytes, std::uint64_t points, std::uint64_t bytesOfPoint, std::uint64_t begin) {
    if (points == 0) fail(bytes, "has no points");
    if (points > kMostPoints || points > (bytes.size() - begin) / bytesOfPoint)
        fail(bytes,
             fmt::format("truncated or damaged: it has {} bytes after its header, which declares {} points of {}",
                         bytes.size() - begin, points, bytesOfPoint));
}

/// Reads rows of numbers from position `begin` on, piece by piece.
template <typename Row>
void readRows(const VdbBytes& bytes, std::uint64_t begin, std::uint64_t rows, std::uint64_t rowBytes, const Row& row) {
    constexpr std::uint64_t kPiece = 1 << 16;
    const std::uint64_t most = std::max<std::uint64_t>(kPiece / rowBytes, 1);
    std::string piece;
    for (std::uint64_t done = 0; done < rows;) {
        const std::uint64_t count = std::min(rows - done, most);
        piece.resize(count * rowBytes);
        bytes.copy(begin + done * rowBytes, piece.size(), piece.data());
        for (std::uint64_t i = 0; i < count; ++i) row(piece.data() + i * rowBytes);
        done += count;
    }
}

void readPlyText(const VdbBytes& bytes, const PlyHeader& header, Columns& columns) {
    std::string text(bytes.size() - header.end, '\0');
    bytes.copy(header.end, text.size(), text.data());
    const char *at = text.data(), *const end = at + text.size();
    for (std::uint64_t i = 0; i < header.points; ++i)
        for (std::size_t c = 0; c < columns.values.size(); ++c) {
            while (at < end && (*at == ' ' || *at == '\n' || *at == '\r' || *at == '\t')) ++at;
            double value = 0;
            const auto [stop, error] = std::from_chars(at, end, value);
            if (stop == at || error == std::errc::invalid_argument)
                fail(bytes, fmt::format("truncated or damaged: number {} of point {} is missing", c + 1, i + 1));
            columns.values[c].push_back(value);
            at = stop;
        }
}

PointCloud readPly(const VdbBytes& bytes) {
    std::string start(std::min(bytes.size(), kLongestHeader), '\0');
    bytes.copy(0, start.size(), start.data());
    const PlyHeader header = plyHeader(bytes, start);
    Columns columns;
    std::uint64_t rowBytes = 0;
    for (const auto& [name, type] : header.properties) {
        columns.names.push_back(name);
        columns.values.emplace_back();
        rowBytes += header.text ? 2 : type->bytes;  // a digit and a separator
    }
    // The last separator may be missing.
    checkCount(bytes, header.points, header.text ? rowBytes - 1 : rowBytes, header.end);
    if (header.text) {
        readPlyText(bytes, header, columns);
    } else {
        const bool swap = header.bigEndian == (std::endian::native == std::endian::little);
        readRows(bytes, header.end, header.points, rowBytes, [&](const char* at) {
            for (std::size_t c = 0; c < columns.values.size(); ++c) {
                const NumberType& type = *header.properties[c].second;
                columns.values[c].push_back(type.read(at, swap));
                at += type.bytes;
            }
        });
    }
    for (std::size_t c = 0; c < columns.values.size(); ++c) {
        const std::string& name = columns.names[c];
        if ((name == "red" || name == "green" || name == "blue") && header.properties[c].second->bytes == 1)
            for (double& value : columns.values[c]) value /= 255;
    }
    return cloudOf(columns);
}

/// The text behind "'key': " in NumPy's dictionary.
std::string_view entryOf(std::string_view dictionary, std::string_view key) {
    const std::size_t at = dictionary.find(fmt::format("'{}':", key));
    if (at == std::string_view::npos) return {};
    const std::string_view rest = dictionary.substr(at + key.size() + 3);
    return rest.substr(std::min(rest.find_first_not_of(' '), rest.size()));
}

/// The numbers in "(1000, 4)".
std::vector<std::uint64_t> shapeOf(std::string_view text) {
    std::vector<std::uint64_t> shape;
    const std::size_t close = text.find(')');
    if (!text.starts_with('(') || close == std::string_view::npos) return shape;
    for (const char *at = text.data() + 1, *const end = text.data() + close; at < end;) {
        std::uint64_t number = 0;
        const auto [stop, error] = std::from_chars(at, end, number);
        if (error != std::errc()) return {};
        shape.push_back(number);
        at = stop;
        while (at < end && (*at == ' ' || *at == ',')) ++at;
    }
    return shape;
}

/// "(2, 2, 2)", for errors.
std::string shapeText(std::string_view entry) {
    return shortened(std::string(entry.substr(0, std::min(entry.find(')'), entry.size() - 1) + 1)), 80);
}

std::string numpyDictionary(const VdbBytes& bytes, std::uint64_t& begin) {
    VdbWalker walk(bytes, kNumpy.size());
    const auto version = walk.number<std::uint8_t>("the header");
    walk.skip(1, "the header");
    const std::uint64_t length =
        version > 1 ? walk.number<std::uint32_t>("the header") : walk.number<std::uint16_t>("the header");
    if (length > std::min(kLongestHeader, walk.left())) fail(bytes, "damaged: its NumPy header has no end");
    std::string dictionary(length, '\0');
    bytes.copy(walk.at(), length, dictionary.data());
    begin = walk.at() + length;
    return dictionary;
}

PointCloud readNumpy(const VdbBytes& bytes) {
    static const std::vector<std::string> kNames{"x", "y", "z", "pscale", "vx", "vy", "vz", "red", "green", "blue"};
    std::uint64_t begin = 0;
    const std::string dictionary = numpyDictionary(bytes, begin);
    const std::string_view descr = entryOf(dictionary, "descr");
    const NumberType* const type = descr.size() < 5 || descr[0] != '\'' ? nullptr : typeCalled(descr.substr(2, 2));
    if (type == nullptr || descr[2] != 'f')
        fail(bytes, fmt::format("its array holds {}, expected floats or doubles ('<f4' or '<f8')",
                                descr.substr(0, std::min<std::size_t>(descr.find(','), 40))));
    const std::vector<std::uint64_t> shape = shapeOf(entryOf(dictionary, "shape"));
    constexpr std::array<std::uint64_t, 4> kWidths{3, 4, 7, 10};
    if (shape.size() != 2 || std::find(kWidths.begin(), kWidths.end(), shape[1]) == kWidths.end())
        fail(bytes, fmt::format("its array has the shape {}; expected points: (n, 3), (n, 4) with radii, (n, 7) with "
                                "radii and velocities, or (n, 10) with colours (source = \"scan\" reads volumes)",
                                shapeText(entryOf(dictionary, "shape"))));
    const std::uint64_t rows = shape[0], width = shape[1];
    checkCount(bytes, rows, width * type->bytes, begin);
    const bool swap = (descr[1] == '>') == (std::endian::native == std::endian::little);
    const bool byColumns = entryOf(dictionary, "fortran_order").starts_with("True");
    Columns columns;
    columns.names.assign(kNames.begin(), kNames.begin() + static_cast<std::ptrdiff_t>(width));
    columns.values.resize(width);
    std::uint64_t index = 0;
    readRows(bytes, begin, rows * width, type->bytes, [&](const char* at) {
        columns.values[byColumns ? index / rows : index % width].push_back(type->read(at, swap));
        ++index;
    });
    return cloudOf(columns);
}

bool beginsWith(const VdbBytes& bytes, std::string_view mark) {
    std::string start(std::min<std::uint64_t>(bytes.size(), mark.size()), '\0');
    bytes.copy(0, start.size(), start.data());
    return start == mark;
}

}  // namespace

std::string pointFormat(const VdbBytes& bytes) {
    return beginsWith(bytes, kPly) ? "PLY" : beginsWith(bytes, kNumpy) ? "NumPy" : "";
}

bool isPointFile(const std::string& path) {
    const std::string name = lowerCase(path);
    if (!name.ends_with(".npy")) return name.ends_with(".ply");
    try {
        const VdbBytes bytes(path);
        std::uint64_t begin = 0;
        return beginsWith(bytes, kNumpy) && shapeOf(entryOf(numpyDictionary(bytes, begin), "shape")).size() == 2;
    } catch (const Error&) {
        return false;  // its reader says what is wrong with it
    }
}

PointCloud readPointFile(const VdbBytes& bytes) {
    return beginsWith(bytes, kPly) ? readPly(bytes) : readNumpy(bytes);
}

}  // namespace scrim
