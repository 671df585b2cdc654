// SPDX-License-Identifier: Apache-2.0
#include "tiff_packing.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>

#include <fmt/format.h>
#include <zlib.h>

namespace scan {
namespace {

/// A string of LZW: an earlier one and a byte.
struct Code {
    std::uint16_t before = 0, length = 1;
    char last = 0, first = 0;
};

/// Codes of 9 to 12 bits, the highest bit first.
class CodeReader {
  public:
    explicit CodeReader(const std::string& bytes) : m_bytes(bytes) {}
    /// The next code; -1 at the end.
    int next(int width) {
        while (m_count < width) {
            if (m_at == m_bytes.size()) return -1;
            m_bits = m_bits << 8 | static_cast<unsigned char>(m_bytes[m_at++]);
            m_count += 8;
        }
        m_count -= width;
        return static_cast<int>(m_bits >> m_count & ((1U << width) - 1));
    }

  private:
    const std::string& m_bytes;
    std::size_t m_at = 0;
    std::uint32_t m_bits = 0;
    int m_count = 0;
};

std::string fromLzw(const std::string& packed, std::size_t bytes) {
    constexpr int kClear = 256, kEnd = 257, kFirst = 258, kLeastWidth = 9, kMostWidth = 12;
    std::array<Code, 1 << kMostWidth> codes;
    for (std::size_t i = 0; i < 256; ++i) codes[i].first = codes[i].last = static_cast<char>(i);
    std::string out;
    out.reserve(bytes);
    CodeReader reader(packed);
    int width = kLeastWidth, count = kFirst, before = -1;
    while (out.size() < bytes) {
        const int code = reader.next(width);
        if (code < 0 || code == kEnd) break;
        if (code == kClear) {
            width = kLeastWidth, count = kFirst, before = -1;
            continue;
        }
        // A code may be the one that is about to be added: the last string and its own first byte.
        if (before < 0 ? code >= kClear : code > count || (code == count && count == 1 << kMostWidth)) break;
        if (before >= 0 && count < 1 << kMostWidth) {
            const Code& last = codes[static_cast<std::size_t>(before)];
            const char next = codes[static_cast<std::size_t>(code == count ? before : code)].first;
            codes[static_cast<std::size_t>(count++)] = {static_cast<std::uint16_t>(before),
                                                        static_cast<std::uint16_t>(last.length + 1), next, last.first};
            // Widths change one code early.
            if (count == (1 << width) - 1 && width < kMostWidth) ++width;
        }
        const std::size_t begin = out.size(), length = codes[static_cast<std::size_t>(code)].length;
        out.resize(begin + length);
        auto at = static_cast<std::size_t>(code);
        for (std::size_t i = length; i-- > 0; at = codes[at].before) out[begin + i] = codes[at].last;
        before = code;
    }
    out.resize(std::min(out.size(), bytes));
    return out;
}

std::string fromPackBits(const std::string& packed, std::size_t bytes) {
    std::string out;
    out.reserve(bytes + 128);
    for (std::size_t at = 0; at + 1 < packed.size() && out.size() < bytes;) {
        const int n = static_cast<signed char>(packed[at++]);
        if (n >= 0) {
            out.append(packed, at, static_cast<std::size_t>(n) + 1);
            at += static_cast<std::size_t>(n) + 1;
        } else if (n != -128) {
            out.append(static_cast<std::size_t>(1 - n), packed[at++]);
        }
    }
    out.resize(std::min(out.size(), bytes));
    return out;
}

std::string fromDeflate(const std::string& packed, std::size_t bytes) {
    std::string out(bytes, '\0');
    z_stream stream{};
    if (inflateInit(&stream) != Z_OK) return "";
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(packed.data()));
    std::size_t left = packed.size(), got = 0;
    for (int code = Z_OK; code == Z_OK && got < bytes;) {
        constexpr std::size_t kMost = 1 << 30;  // zlib counts by 32 bits
        const auto input = static_cast<uInt>(std::min(left, kMost)),
                   output = static_cast<uInt>(std::min(bytes - got, kMost));
        stream.avail_in = input;
        stream.next_out = reinterpret_cast<Bytef*>(out.data() + got);
        stream.avail_out = output;
        code = inflate(&stream, Z_NO_FLUSH);
        left -= input - stream.avail_in;
        got += output - stream.avail_out;
    }
    inflateEnd(&stream);
    out.resize(got);
    return out;
}

/// Adds to each number of a row the one `parts` before it; unsigned numbers wrap around.
template <typename Number>
void addUp(char* row, std::size_t count, std::size_t parts) {
    for (std::size_t i = parts; i < count; ++i) {
        Number before, here;
        std::memcpy(&before, row + (i - parts) * sizeof before, sizeof before);
        std::memcpy(&here, row + i * sizeof here, sizeof here);
        here = static_cast<Number>(here + before);
        std::memcpy(row + i * sizeof here, &here, sizeof here);
    }
}

/// A row whose bytes were sorted by their place in a float, the highest first, and made differences.
void joinBytes(char* row, std::size_t count, std::size_t width, std::size_t parts) {
    addUp<std::uint8_t>(row, count * width, parts);
    const std::string sorted(row, count * width);
    for (std::size_t i = 0; i < count; ++i)
        for (std::size_t b = 0; b < width; ++b) {
            const std::size_t place = std::endian::native == std::endian::big ? b : width - 1 - b;
            row[i * width + place] = sorted[b * count + i];
        }
}

}  // namespace

std::int64_t mostRatioOf(TiffPacking packing) {
    switch (packing) {
        case TiffPacking::none:
            return 1;
        case TiffPacking::packBits:
            return 64;  // 128 bytes of 2
        case TiffPacking::lzw:
            return 2731;  // a code of 12 bits stands for 4096 bytes at most
        case TiffPacking::adobeDeflate:
        case TiffPacking::deflate:
            return 1032;
    }
    return 0;
}

std::string nameOf(TiffPacking packing) {
    const auto number = static_cast<std::uint64_t>(packing);
    constexpr std::array<std::pair<std::uint64_t, const char*>, 8> kNames{{{2, "CCITT"},
                                                                           {3, "CCITT"},
                                                                           {4, "CCITT"},
                                                                           {6, "JPEG"},
                                                                           {7, "JPEG"},
                                                                           {34712, "JPEG 2000"},
                                                                           {34925, "LZMA"},
                                                                           {50000, "Zstandard"}}};
    for (const auto& [known, name] : kNames)
        if (known == number) return name;
    return fmt::format("method {}", number);
}

std::string unpacked(const std::string& packed, TiffPacking packing, std::int64_t bytes) {
    const auto count = static_cast<std::size_t>(bytes);
    if (packing == TiffPacking::lzw) return fromLzw(packed, count);
    if (packing == TiffPacking::packBits) return fromPackBits(packed, count);
    if (packing == TiffPacking::none) return packed.substr(0, count);
    return fromDeflate(packed, count);
}

void undoDifferences(std::string& bytes, const TiffRows& rows) {
    const auto width = static_cast<std::size_t>(bytesOf(rows.type)), parts = static_cast<std::size_t>(rows.parts),
               count = static_cast<std::size_t>(rows.columns) * parts;
    if (rows.predictor != 3 && rows.bigEndian != (std::endian::native == std::endian::big))
        for (std::size_t at = 0; at + width <= bytes.size(); at += width)
            std::reverse(bytes.data() + at, bytes.data() + at + width);
    if (rows.predictor == 1) return;
    for (std::size_t at = 0; at + count * width <= bytes.size(); at += count * width) {
        char* const row = bytes.data() + at;
        if (rows.predictor == 3)
            joinBytes(row, count, width, parts);
        else if (width == 1)
            addUp<std::uint8_t>(row, count, parts);
        else if (width == 2)
            addUp<std::uint16_t>(row, count, parts);
        else if (width == 4)
            addUp<std::uint32_t>(row, count, parts);
        else
            addUp<std::uint64_t>(row, count, parts);
    }
}

}  // namespace scan
