// SPDX-License-Identifier: Apache-2.0
#include "tiff_file.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <limits>
#include <optional>
#include <set>
#include <utility>

#include <fmt/format.h>

namespace scan {
namespace {

enum Tag : std::uint64_t {
    kSubfileType = 254,
    kWidth = 256,
    kHeight = 257,
    kBits = 258,
    kCompression = 259,
    kPhotometric = 262,
    kFillOrder = 266,
    kDescription = 270,
    kStripOffsets = 273,
    kParts = 277,
    kRowsPerStrip = 278,
    kStripBytes = 279,
    kXResolution = 282,
    kYResolution = 283,
    kPlanar = 284,
    kPredictor = 317,
    kTileWidth = 322,
    kTileHeight = 323,
    kTileOffsets = 324,
    kTileBytes = 325,
    kSampleFormat = 339,
};
constexpr std::uint64_t kBlackIsZero = 1, kRgb = 2, kPalette = 3;               // photometric
constexpr std::uint64_t kUnsigned = 1, kSigned = 2, kReal = 3, kUndefined = 4;  // sample format
constexpr std::uint64_t kRational = 5;

/// Bytes of a value by its type; 0: no such type.
std::uint64_t bytesOfType(std::uint64_t type) {
    constexpr std::array<std::uint64_t, 19> kBytes{0, 1, 1, 2, 4, 8, 1, 1, 2, 4, 8, 4, 8, 4, 0, 0, 8, 8, 8};
    return type < kBytes.size() ? kBytes[type] : 0;
}

/// True for types of whole numbers without a sign.
bool isCount(std::uint64_t type) {
    return type == 1 || type == 3 || type == 4 || type == 13 || type == 16 || type == 18;
}

std::optional<SampleType> typeOf(std::uint64_t format, std::uint64_t bits) {
    using enum SampleType;
    const auto among = [&](SampleType b8, SampleType b16, SampleType b32, SampleType b64) {
        return bits == 8 ? b8 : bits == 16 ? b16 : bits == 32 ? b32 : b64;
    };
    if (bits != 8 && bits != 16 && bits != 32 && bits != 64) return {};
    if (format == kUnsigned || format == kUndefined) return among(uint8, uint16, uint32, uint64);
    if (format == kSigned) return among(int8, int16, int32, int64);
    if (format == kReal && bits > 8) return among(float16, float16, float32, float64);
    return {};
}

std::int64_t ceilOf(std::int64_t a, std::int64_t b) {
    return (a + b - 1) / b;
}

}  // namespace

std::string textOf(const TiffForm& form) {
    return fmt::format("{} x {} of {}{}", form.columns, form.rows, form.parts == 3 ? "RGB " : "", nameOf(form.type));
}

TiffFile::TiffFile(const SliceFile& file, std::string path)
    : m_path(std::move(path)), m_file(file.path, std::ios::binary), m_begin(static_cast<std::uint64_t>(file.begin)) {
    m_size = static_cast<std::uint64_t>(file.bytes >= 0 ? file.bytes : fileBytes(file.path));
    const std::string start = m_size < 16 ? "" : bytesAt(0, 16);
    if (!beginsAsTiff(start)) refuse(m_path, "is not a TIFF file");
    m_bigEndian = start[0] == 'M';
    m_isBig = numberAt(2, 2) == 43;
    std::set<std::uint64_t> seen;
    TiffPacking packing = TiffPacking::none;
    for (std::uint64_t header = m_isBig ? numberAt(8, 8) : numberAt(4, 4), next = 0; header != 0; header = next) {
        if (!seen.insert(header).second) refuse(m_path, "damaged: its pages go round in a circle");
        const Fields fields = fieldsAt(header, next);
        if ((numberOf(fields, kSubfileType, 0) & 1) != 0) continue;  // a smaller version of another page
        const TiffForm here = formOf(fields);
        if (m_headers.empty()) {
            m_form = here;
            readCommon(fields);
            packing = static_cast<TiffPacking>(numberOf(fields, kCompression, 1));
        }
        m_headers.push_back(header);
        m_pages = static_cast<std::int64_t>(m_headers.size());
        if (here != m_form)
            refuse(m_path,
                   fmt::format("its page {} is {}, expected {} as the first", m_pages, textOf(here), textOf(m_form)));
    }
    if (m_headers.empty()) refuse(m_path, "holds no picture");
    checkBytes(packing);
}

std::string TiffFile::bytesAt(std::uint64_t begin, std::uint64_t count) {
    if (begin > m_size || count > m_size - begin) refuse(m_path, "damaged: it ends before what its header names");
    std::string bytes(count, '\0');
    m_file.clear();
    m_file.seekg(static_cast<std::streamoff>(m_begin + begin));
    m_file.read(bytes.data(), static_cast<std::streamsize>(count));
    if (static_cast<std::uint64_t>(m_file.gcount()) != count) refuse(m_path, "cannot be read");
    return bytes;
}

std::uint64_t TiffFile::numberIn(std::string_view bytes) const {
    std::uint64_t number = 0;
    for (std::size_t i = 0; i < bytes.size(); ++i)
        number = number << 8 | static_cast<unsigned char>(bytes[m_bigEndian ? i : bytes.size() - 1 - i]);
    return number;
}

std::uint64_t TiffFile::numberAt(std::uint64_t begin, std::uint64_t bytes) {
    return numberIn(bytesAt(begin, bytes));
}

TiffFile::Fields TiffFile::fieldsAt(std::uint64_t header, std::uint64_t& next) {
    const std::uint64_t word = m_isBig ? 8 : 4, counts = m_isBig ? 8 : 2, each = 4 + 2 * word;
    const std::uint64_t count = numberAt(header, counts);
    constexpr std::uint64_t kMost = 4096;  // of tags that are registered there are some hundreds
    if (count > kMost) refuse(m_path, fmt::format("damaged: a header has {} fields", count));
    const std::uint64_t first = header + counts;
    const std::string all = bytesAt(first, count * each + word);
    Fields fields;
    for (std::uint64_t at = 0; at < count * each; at += each) {
        const std::string_view entry = std::string_view(all).substr(at, each);
        Field field{numberIn(entry.substr(2, 2)), numberIn(entry.substr(4, word)), first + at + 4 + word};
        const std::uint64_t bytes = bytesOfType(field.type);
        // What needs a field that is damaged says that it is missing.
        if (bytes == 0 || field.count > m_size / bytes) continue;
        if (field.count * bytes > word) field.at = numberIn(entry.substr(4 + word));
        fields.emplace(numberIn(entry.substr(0, 2)), field);
    }
    next = numberIn(std::string_view(all).substr(count * each));
    return fields;
}

std::vector<std::uint64_t> TiffFile::numbersOf(const Fields& fields, std::uint64_t tag) {
    const auto found = fields.find(tag);
    if (found == fields.end() || !isCount(found->second.type)) return {};
    const Field& field = found->second;
    const std::uint64_t each = bytesOfType(field.type);
    const std::string bytes = bytesAt(field.at, field.count * each);
    std::vector<std::uint64_t> numbers;
    for (std::size_t at = 0; at < bytes.size(); at += each)
        numbers.push_back(numberIn(std::string_view(bytes).substr(at, each)));
    return numbers;
}

std::uint64_t TiffFile::numberOf(const Fields& fields, std::uint64_t tag, std::uint64_t otherwise) {
    const std::vector<std::uint64_t> numbers = numbersOf(fields, tag);
    return numbers.empty() ? otherwise : numbers.front();
}

double TiffFile::ratioOf(const Fields& fields, std::uint64_t tag) {
    const auto found = fields.find(tag);
    if (found == fields.end() || found->second.type != kRational || found->second.count == 0) return 0;
    const auto over = static_cast<double>(numberAt(found->second.at, 4)),
               under = static_cast<double>(numberAt(found->second.at + 4, 4));
    return under > 0 ? over / under : 0;
}

TiffForm TiffFile::formOf(const Fields& fields) {
    const std::vector<std::uint64_t> bits = numbersOf(fields, kBits), formats = numbersOf(fields, kSampleFormat);
    const auto areEqual = [](const auto& all) {
        return std::equal(all.begin() + !all.empty(), all.end(), all.begin());
    };
    if (!areEqual(bits) || !areEqual(formats)) refuse(m_path, "holds samples whose parts are of different types");
    const std::uint64_t width = bits.empty() ? 1 : bits.front(), format = formats.empty() ? kUnsigned : formats.front(),
                        parts = numberOf(fields, kParts, 1), colours = numberOf(fields, kPhotometric, kBlackIsZero);
    const std::optional<SampleType> type = typeOf(format, width);
    if (!type)
        refuse(m_path, fmt::format("holds samples of {} bits{}; expected numbers of 8, 16, 32 or 64", width,
                                   format == kUnsigned ? "" : fmt::format(" in format {}", format)));
    const auto packing = static_cast<TiffPacking>(numberOf(fields, kCompression, 1));
    if (mostRatioOf(packing) == 0)
        refuse(m_path, fmt::format("its samples are compressed by {}; expected LZW, deflate, PackBits or nothing",
                                   nameOf(packing)));
    const bool isGrey = colours <= kBlackIsZero || colours == kPalette;
    if (isGrey ? parts != 1 : colours != kRgb || parts != 3)
        refuse(m_path, fmt::format("holds {} values for each sample, expected one, or red, green and blue", parts));
    if (numberOf(fields, kFillOrder, 1) != 1) refuse(m_path, "its bits are in reverse order, which is not read");
    TiffForm form;
    constexpr std::uint64_t kMost = std::uint64_t{1} << 31;
    form.columns = static_cast<std::int64_t>(std::min(numberOf(fields, kWidth, 0), kMost));
    form.rows = static_cast<std::int64_t>(std::min(numberOf(fields, kHeight, 0), kMost));
    form.parts = static_cast<int>(parts);
    form.type = *type;
    sampleCount({form.columns, form.rows, form.parts}, m_path);
    return form;
}

void TiffFile::readCommon(const Fields& fields) {
    constexpr std::uint64_t kMostText = 1 << 24;
    const auto text = fields.find(kDescription);
    if (text != fields.end() && bytesOfType(text->second.type) == 1)
        m_description = bytesAt(text->second.at, std::min(text->second.count, kMostText));
    while (m_description.ends_with('\0')) m_description.pop_back();
    m_perUnit = {ratioOf(fields, kXResolution), ratioOf(fields, kYResolution)};
    const std::uint64_t colours = numberOf(fields, kPhotometric, kBlackIsZero);
    m_hasPalette = colours == kPalette;
    m_isInverted = colours == 0;
    m_isPlanar = m_form.parts > 1 && numberOf(fields, kPlanar, 1) == 2;
}

std::int64_t TiffFile::pageBytes() const {
    return m_form.columns * m_form.rows * m_form.parts * bytesOf(m_form.type);
}

/// Refuses pages that cannot be in the file.
void TiffFile::checkBytes(TiffPacking packing) const {
    sampleCount({m_form.columns * m_form.parts, m_form.rows, m_pages}, m_path);
    const std::int64_t bytes = m_pages * pageBytes();
    if (bytes / mostRatioOf(packing) > static_cast<std::int64_t>(m_size))
        refuse(m_path,
               fmt::format("{} page{} of {} {} {} bytes, more than its {} bytes can hold", m_pages,
                           m_pages == 1 ? "" : "s", textOf(m_form), m_pages == 1 ? "has" : "have", bytes, m_size));
}

TiffFile::Layout TiffFile::layoutOf(const Fields& fields) {
    constexpr std::uint64_t kMostEdge = 1 << 24;
    Layout layout;
    layout.isTiled = fields.contains(kTileWidth);
    layout.packing = static_cast<TiffPacking>(numberOf(fields, kCompression, 1));
    layout.predictor = layout.packing == TiffPacking::none ? 1 : numberOf(fields, kPredictor, 1);
    if (layout.predictor < 1 || layout.predictor > 3 || (layout.predictor == 3 && !isReal(m_form.type)))
        refuse(m_path, fmt::format("has the predictor {}, which is not read", layout.predictor));
    const auto edgeOf = [&](Tag tag, std::int64_t otherwise) {
        return static_cast<std::int64_t>(
            std::min(numberOf(fields, tag, static_cast<std::uint64_t>(otherwise)), kMostEdge));
    };
    layout.width = layout.isTiled ? edgeOf(kTileWidth, 0) : m_form.columns;
    layout.height = layout.isTiled ? edgeOf(kTileHeight, 0) : std::min(edgeOf(kRowsPerStrip, m_form.rows), m_form.rows);
    layout.begins = numbersOf(fields, layout.isTiled ? kTileOffsets : kStripOffsets);
    layout.lengths = numbersOf(fields, layout.isTiled ? kTileBytes : kStripBytes);
    if (layout.width < 1 || layout.height < 1) refuse(m_path, "damaged: its strips or tiles have no size");
    const std::int64_t count =
        ceilOf(m_form.columns, layout.width) * ceilOf(m_form.rows, layout.height) * (m_isPlanar ? m_form.parts : 1);
    if (layout.lengths.empty() && layout.packing == TiffPacking::none && count == 1)
        layout.lengths = {static_cast<std::uint64_t>(pageBytes())};  // old writers leave it out
    if (static_cast<std::int64_t>(std::min(layout.begins.size(), layout.lengths.size())) < count)
        refuse(m_path, "damaged: some of its strips or tiles are missing");
    return layout;
}

void TiffFile::assumePages(std::int64_t count) {
    if (m_pages != 1 || count <= 1 || m_isPlanar) return;
    std::uint64_t next = 0;
    const Layout layout = layoutOf(fieldsAt(m_headers[0], next));
    sampleCount({m_form.columns * m_form.parts, m_form.rows, count}, m_path);
    const std::uint64_t begin = layout.begins[0], all = static_cast<std::uint64_t>(count * pageBytes());
    if (layout.packing == TiffPacking::none && !layout.isTiled && begin <= m_size && m_size - begin >= all)
        m_pages = count;
}

/// Strip or tile `number`, of which `rows` rows are there, in this machine's order of bytes.
std::string TiffFile::chunk(const Layout& layout, std::size_t number, std::int64_t rows) {
    const int parts = m_isPlanar ? 1 : m_form.parts;
    const std::int64_t line = layout.width * parts * bytesOf(m_form.type),
                       stored = static_cast<std::int64_t>(std::min(layout.lengths[number], m_size));
    constexpr std::int64_t kSlack = 1 << 16;
    if (rows > (stored * mostRatioOf(layout.packing) + kSlack) / line)
        refuse(m_path, "damaged: a strip or a tile is larger than its bytes can hold");
    const std::string packed = bytesAt(layout.begins[number], static_cast<std::uint64_t>(stored));
    std::string bytes = unpacked(packed, layout.packing, line * rows);
    if (static_cast<std::int64_t>(bytes.size()) != line * rows) refuse(m_path, "its samples are damaged or incomplete");
    undoDifferences(bytes, {layout.width, parts, m_form.type, m_bigEndian, layout.predictor});
    return bytes;
}

/// The samples of a page, or of one of its planes, whose strips or tiles begin at `number`, which becomes the next one.
std::string TiffFile::plane(const Layout& layout, std::size_t& number) {
    const std::int64_t sample = bytesOf(m_form.type) * (m_isPlanar ? 1 : m_form.parts), line = m_form.columns * sample;
    std::string all(static_cast<std::size_t>(line * m_form.rows), '\0');
    for (std::int64_t y = 0; y < m_form.rows; y += layout.height)
        for (std::int64_t x = 0; x < m_form.columns; x += layout.width) {
            const std::int64_t rows = std::min(layout.height, m_form.rows - y);
            const std::string bytes = chunk(layout, number++, layout.isTiled ? layout.height : rows);
            const std::int64_t kept = std::min(layout.width, m_form.columns - x) * sample;
            for (std::int64_t row = 0; row < rows; ++row)
                std::memcpy(all.data() + (y + row) * line + x * sample, bytes.data() + row * layout.width * sample,
                            static_cast<std::size_t>(kept));
        }
    return all;
}

std::vector<float> TiffFile::samples(std::int64_t page) {
    const bool isBehind = page >= static_cast<std::int64_t>(m_headers.size());
    std::uint64_t next = 0;
    const Layout layout = layoutOf(fieldsAt(m_headers[isBehind ? 0 : static_cast<std::size_t>(page)], next));
    RawLayout raw;
    raw.type = m_form.type;
    raw.bigEndian = std::endian::native == std::endian::big;
    std::string bytes;
    std::size_t number = 0;
    if (isBehind) {
        raw.bigEndian = m_bigEndian;
        bytes = bytesAt(layout.begins[0] + static_cast<std::uint64_t>(page * pageBytes()),
                        static_cast<std::uint64_t>(pageBytes()));
    } else {
        for (int k = 0; k < (m_isPlanar ? m_form.parts : 1); ++k) bytes += plane(layout, number);
    }
    std::vector<float> values = samplesIn(bytes, raw);
    if (m_isPlanar) {
        const std::vector<float> planes = std::move(values);
        const auto parts = static_cast<std::size_t>(m_form.parts), count = planes.size() / parts;
        values.resize(planes.size());
        for (std::size_t i = 0; i < planes.size(); ++i) values[i % count * parts + i / count] = planes[i];
    }
    const bool isWhole = m_form.type == SampleType::uint8 || m_form.type == SampleType::uint16;
    if (m_isInverted && isWhole)
        for (float& value : values) value = (m_form.type == SampleType::uint8 ? 255.0f : 65535.0f) - value;
    return values;
}

}  // namespace scan
