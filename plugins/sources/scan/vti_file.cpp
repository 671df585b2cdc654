// SPDX-License-Identifier: Apache-2.0
// Reads VTK's image data (.vti): XML of a few elements, and an array of samples that is text, base64 or, behind the
// XML, bytes; deflated or not (VTK's File Formats, "ImageData"). Of several arrays it is the one that the file names as
// its scalars, else the first.
#include "scan.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cctype>
#include <fstream>
#include <map>
#include <optional>
#include <string_view>

#include <fmt/format.h>
#include <zlib.h>

namespace scan {
namespace {

/// An XML element without its contents.
struct Element {
    std::string name;
    std::map<std::string, std::string> attributes;
    std::size_t end = 0;  ///< in the text, behind its '>'

    std::string get(const std::string& key, const std::string& standard = "") const {
        const auto found = attributes.find(key);
        return found == attributes.end() ? standard : found->second;
    }
};

/// The next element at or behind `at` that is no end, declaration or comment.
std::optional<Element> nextElement(std::string_view text, std::size_t at) {
    for (;;) {
        const std::size_t open = text.find('<', at), close = text.find('>', std::min(open, text.size()));
        if (open == text.npos || close == text.npos) return {};
        at = close + 1;
        std::string_view inner = text.substr(open + 1, close - open - 1);
        if (inner.empty() || inner[0] == '/' || inner[0] == '?' || inner[0] == '!') continue;
        Element element;
        element.end = close + 1;
        element.name = inner.substr(0, std::min(inner.find_first_of(" \t\r\n/"), inner.size()));
        for (std::size_t equals = inner.find('='); equals != inner.npos; equals = inner.find('=', equals)) {
            const std::size_t last = inner.find_last_not_of(" \t\r\n", equals - 1);
            const std::size_t first = inner.find_last_of(" \t\r\n", last);
            const std::size_t quote = inner.find_first_of("\"'", equals);
            const std::size_t end = quote == inner.npos ? quote : inner.find(inner[quote], quote + 1);
            if (first == inner.npos || last == inner.npos || end == inner.npos) break;
            element.attributes[std::string(inner.substr(first + 1, last - first))] =
                inner.substr(quote + 1, end - quote - 1);
            equals = end;
        }
        return element;
    }
}

template <std::size_t N>
std::array<double, N> numbers(const std::string& text, const char* what, const std::string& path) {
    std::array<double, N> out{};
    const char *at = text.data(), *const end = at + text.size();
    for (double& number : out) {
        while (at < end && std::isspace(static_cast<unsigned char>(*at)) != 0) ++at;
        const auto [stop, error] = std::from_chars(at, end, number);
        if (error != std::errc())
            refuse(path, fmt::format("its '{}' is '{}', expected {} numbers", what, text.substr(0, 80), N));
        at = stop;
    }
    return out;
}

struct File {
    std::string path, text;       ///< all of the file
    Element whole, image, array;  ///< VTKFile, ImageData, DataArray
    std::size_t appended = 0;     ///< where offsets count from; 0: there is no appended data
    bool appendedIsText = false, ofCells = false;
};

/// Finds the elements that matter.
void findElements(File& file) {
    std::string wanted, parent;
    int pieces = 0;
    for (auto element = nextElement(file.text, 0); element; element = nextElement(file.text, element->end)) {
        if (element->name == "VTKFile") file.whole = *element;
        if (element->name == "ImageData") file.image = *element;
        pieces += element->name == "Piece" ? 1 : 0;
        if (element->name == "PointData" || element->name == "CellData") {
            parent = element->name;
            wanted = element->get("Scalars");
        }
        if (element->name == "DataArray" && !parent.empty()) {
            const bool better =
                file.array.name.empty() || (file.ofCells && parent == "PointData") ||
                (!wanted.empty() && element->get("Name") == wanted && file.ofCells == (parent == "CellData"));
            if (better) {
                file.array = *element;
                file.ofCells = parent == "CellData";
            }
        }
        if (element->name != "AppendedData") continue;
        const std::size_t mark = file.text.find('_', element->end);
        if (mark == std::string::npos) refuse(file.path, "damaged: its appended data has no begin");
        file.appended = mark + 1;
        file.appendedIsText = element->get("encoding") != "raw";
        break;
    }
    const std::string type = file.whole.get("type");
    if (file.whole.name.empty()) refuse(file.path, "is not a file of VTK");
    if (type != "ImageData") refuse(file.path, fmt::format("holds VTK's {}, expected ImageData", type.substr(0, 40)));
    if (file.array.name.empty()) refuse(file.path, "holds no array of samples");
    if (pieces > 1) refuse(file.path, fmt::format("is in {} pieces, expected one: save it anew", pieces));
}

SampleType typeOf(const std::string& name, const std::string& path) {
    constexpr std::array<std::pair<std::string_view, SampleType>, 10> kTypes{{{"UInt8", SampleType::uint8},
                                                                              {"Int8", SampleType::int8},
                                                                              {"UInt16", SampleType::uint16},
                                                                              {"Int16", SampleType::int16},
                                                                              {"UInt32", SampleType::uint32},
                                                                              {"Int32", SampleType::int32},
                                                                              {"UInt64", SampleType::uint64},
                                                                              {"Int64", SampleType::int64},
                                                                              {"Float32", SampleType::float32},
                                                                              {"Float64", SampleType::float64}}};
    for (const auto& [known, type] : kTypes)
        if (name == known) return type;
    refuse(path, fmt::format("holds samples of type '{}', expected UInt8, Int16, Float32 or another number",
                             name.substr(0, 40)));
}

/// The bytes of base64 from `at` on, at most `most`, up to padding or the end of the text.
std::string fromBase64(std::string_view text, std::size_t& at, std::size_t most) {
    constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    std::uint32_t bits = 0;
    int digits = 0, padding = 0;
    for (; at < text.size() && out.size() < most; ++at) {
        const std::size_t digit = kDigits.find(text[at]);
        if (std::isspace(static_cast<unsigned char>(text[at])) != 0) continue;
        if (digit == kDigits.npos && text[at] != '=') break;
        padding += text[at] == '=' ? 1 : 0;
        bits = bits << 6 | static_cast<std::uint32_t>(digit == kDigits.npos ? 0 : digit);
        if (++digits < 4) continue;
        for (int i = 0; i < 3 - padding; ++i) out += static_cast<char>(bits >> (16 - 8 * i) & 0xff);
        digits = 0;
        bits = 0;
        if (padding > 0) {
            ++at;
            break;
        }
    }
    return out;
}

/// The bytes of an array, from a place on; base64 is a sequence of texts, each of which may end with padding.
class Source {
  public:
    Source(const std::string& path, std::string_view bytes, std::size_t at, bool isText)
        : m_path(path), m_bytes(bytes), m_at(at), m_isText(isText) {}

    std::string take(std::uint64_t count) {
        while (m_isText && m_left.size() < count) {
            const std::string more = fromBase64(m_bytes, m_at, count - m_left.size());
            if (more.empty()) break;
            m_left += more;
        }
        if (m_isText ? count > m_left.size() : count > m_bytes.size() - std::min(m_at, m_bytes.size()))
            refuse(m_path, "is cut off: its samples end too early");
        std::string out = m_isText ? m_left.substr(0, count) : std::string(m_bytes.substr(m_at, count));
        if (m_isText)
            m_left.erase(0, count);
        else
            m_at += count;
        return out;
    }
    /// VTK begins a new text of base64 here.
    void nextText() { m_left.clear(); }

  private:
    const std::string& m_path;
    std::string_view m_bytes;
    std::size_t m_at;
    bool m_isText;
    std::string m_left;
};

std::uint64_t wordIn(const std::string& bytes, std::size_t i, std::size_t width, bool bigEndian) {
    std::uint64_t word = 0;
    for (std::size_t k = 0; k < width; ++k)
        word = word << 8 | static_cast<unsigned char>(bytes[i * width + (bigEndian ? k : width - 1 - k)]);
    return word;
}

/// The samples' bytes, inflated.
std::string bytesOfArray(const File& file, Source source, bool bigEndian, std::uint64_t expected) {
    const std::size_t width = file.whole.get("header_type", "UInt32") == "UInt64" ? 8 : 4;
    const std::string compressor = file.whole.get("compressor");
    if (compressor.empty()) {
        const std::uint64_t bytes = wordIn(source.take(width), 0, width, bigEndian);
        if (bytes < expected) refuse(file.path, fmt::format("has {} bytes of samples, expected {}", bytes, expected));
        return source.take(expected);
    }
    if (compressor != "vtkZLibDataCompressor")
        refuse(file.path,
               fmt::format("is compressed by '{}', expected vtkZLibDataCompressor, or none", compressor.substr(0, 40)));
    const std::string head = source.take(3 * width);
    const std::uint64_t blocks = wordIn(head, 0, width, bigEndian), block = wordIn(head, 1, width, bigEndian);
    if (block == 0 || blocks != (expected + block - 1) / block)
        refuse(file.path, "damaged: its blocks are not as large as its samples");
    if (blocks > file.text.size() / width) refuse(file.path, "is cut off: its samples end too early");
    const std::string sizes = source.take(blocks * width);
    source.nextText();
    std::string out(expected, '\0');
    for (std::uint64_t i = 0; i < blocks; ++i) {
        const std::string packed = source.take(wordIn(sizes, i, width, bigEndian));
        uLongf bytes = static_cast<uLongf>(std::min(block, expected - i * block));
        const uLongf wanted = bytes;
        const int code = uncompress(reinterpret_cast<Bytef*>(out.data() + i * block), &bytes,
                                    reinterpret_cast<const Bytef*>(packed.data()), static_cast<uLong>(packed.size()));
        if (code != Z_OK || bytes != wanted) refuse(file.path, "its compressed data is damaged");
    }
    return out;
}

std::vector<float> textSamples(const File& file, std::int64_t count) {
    std::vector<float> values;
    const char *at = file.text.data() + file.array.end, *const end = file.text.data() + file.text.size();
    while (static_cast<std::int64_t>(values.size()) < count) {
        while (at < end && std::isspace(static_cast<unsigned char>(*at)) != 0) ++at;
        double value = 0;
        const auto [stop, error] = std::from_chars(at, end, value);
        if (stop == at)
            refuse(file.path, fmt::format("is cut off: it has {} samples, expected {}", values.size(), count));
        values.push_back(static_cast<float>(value));
        at = stop;
    }
    return values;
}

/// Size and place. Samples of cells lie in the middle of their points.
void place(const File& file, Scan& scan) {
    const auto extent = numbers<6>(file.image.get("WholeExtent"), "WholeExtent", file.path);
    const auto origin = numbers<3>(file.image.get("Origin", "0 0 0"), "Origin", file.path);
    const auto spacing = numbers<3>(file.image.get("Spacing", "1 1 1"), "Spacing", file.path);
    const auto axes = numbers<9>(file.image.get("Direction", "1 0 0 0 1 0 0 0 1"), "Direction", file.path);
    glm::dvec3 first(0);
    for (int k = 0; k < 3; ++k) {
        const auto i = static_cast<std::size_t>(k);
        const double points = std::clamp(extent[2 * i + 1] - extent[2 * i] + 1, 0.0, 1e12);
        scan.size[i] = static_cast<std::int64_t>(file.ofCells ? std::max(points - 1, 1.0) : points);
        for (int row = 0; row < 3; ++row) scan.axes[k][row] = axes[static_cast<std::size_t>(3 * row + k)] * spacing[i];
        scan.origin[k] = origin[i];
        first[k] = extent[2 * i] + (file.ofCells && points > 1 ? 0.5 : 0);
    }
    scan.origin += scan.axes * first;
}

std::string contentsOf(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    std::string text(static_cast<std::size_t>(fileBytes(path)), '\0');
    in.read(text.data(), static_cast<std::streamsize>(text.size()));
    text.resize(static_cast<std::size_t>(in.gcount()));
    return text;
}

}  // namespace

Scan readVti(const std::string& path) {
    File file;
    file.path = path;
    file.text = contentsOf(path);
    findElements(file);
    const std::string parts = file.array.get("NumberOfComponents", "1");
    if (parts != "1") refuse(path, fmt::format("has {} numbers a sample, expected 1", parts.substr(0, 40)));
    Scan scan;
    place(file, scan);
    RawLayout layout;
    layout.size = scan.size;
    layout.type = typeOf(file.array.get("type"), path);
    layout.bigEndian = file.whole.get("byte_order") == "BigEndian";
    scan.type = nameOf(layout.type);
    const std::int64_t count = sampleCount(scan.size, path);
    const auto bytes = static_cast<std::uint64_t>(count * bytesOf(layout.type));
    checkRatio(static_cast<std::int64_t>(file.text.size()), static_cast<std::int64_t>(bytes), path);
    const std::string format = file.array.get("format");
    if (format == "ascii") {
        scan.values = textSamples(file, count);
        return scan;
    }
    const bool isAppended = format == "appended";
    if (!isAppended && format != "binary")
        refuse(path, fmt::format("its samples are '{}', expected ascii, binary or appended", format.substr(0, 40)));
    if (isAppended && file.appended == 0) refuse(path, "is cut off: its appended data is missing");
    std::size_t at = file.array.end;
    if (isAppended) {
        const double offset = numbers<1>(file.array.get("offset"), "offset", path)[0];
        at = file.appended + static_cast<std::size_t>(std::clamp(offset, 0.0, 1e15));
    }
    const Source source(path, file.text, at, !isAppended || file.appendedIsText);
    scan.values = samplesIn(bytesOfArray(file, source, layout.bigEndian, bytes), layout);
    return scan;
}

}  // namespace scan
