// SPDX-License-Identifier: Apache-2.0
// Reads samples from plain and gzipped files, and checks sizes so that a wrong header cannot fill the memory.
#include "scan.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>
#include <memory>
#include <optional>

#include <fmt/format.h>
#include <zlib.h>

namespace scan {
namespace {

constexpr std::int64_t kMostSamples = std::int64_t{1} << 31;  // 8 GB of floats
constexpr std::int64_t kMostRatio = 1032;                     // the largest ratio of deflate (zlib's technical details)
constexpr std::int64_t kSlack = 1 << 16;                      // for headers and empty files

/// The bytes of a file in sequence, decompressed where needed.
class Bytes {
  public:
    Bytes(const std::string& path, bool compressed) : m_path(path) {
        if (compressed) {
            m_gz.reset(gzopen(path.c_str(), "rb"));
            if (!m_gz) refuse(path, "cannot be opened");
        } else {
            m_file.open(path, std::ios::binary);
            if (!m_file) refuse(path, "cannot be opened");
        }
    }

    /// Reads up to `count` bytes; fewer at the end. Throws on damaged compression.
    std::int64_t read(char* to, std::int64_t count) {
        if (!m_gz) {
            m_file.read(to, count);
            return m_file.gcount();
        }
        const int got = gzread(m_gz.get(), to, static_cast<unsigned>(count));
        int code = Z_OK;
        const char* text = gzerror(m_gz.get(), &code);
        if (got < 0 || (code != Z_OK && code != Z_STREAM_END && code != Z_BUF_ERROR))
            refuse(m_path, fmt::format("its compressed data is damaged: {}", text));
        return got;
    }

  private:
    struct Close {
        void operator()(gzFile file) const { gzclose(file); }
    };
    std::string m_path;
    std::ifstream m_file;
    std::unique_ptr<gzFile_s, Close> m_gz;
};

template <typename T>
float sample(const char* bytes, bool swap) {
    std::array<char, sizeof(T)> raw;
    std::memcpy(raw.data(), bytes, sizeof(T));
    if (swap) std::reverse(raw.begin(), raw.end());
    return static_cast<float>(std::bit_cast<T>(raw));
}

/// The value of a half float (IEEE 754 binary16).
float fromHalf(std::uint16_t bits) {
    const int exponent = bits >> 10 & 0x1f, fraction = bits & 0x3ff;
    const float magnitude = exponent == 0    ? std::ldexp(static_cast<float>(fraction), -24)
                            : exponent == 31 ? (fraction == 0 ? std::numeric_limits<float>::infinity()
                                                              : std::numeric_limits<float>::quiet_NaN())
                                             : std::ldexp(static_cast<float>(fraction + 1024), exponent - 25);
    return (bits & 0x8000) != 0 ? -magnitude : magnitude;
}

float sample(SampleType type, const char* bytes, bool swap) {
    switch (type) {
        case SampleType::uint8:
            return sample<std::uint8_t>(bytes, false);
        case SampleType::int8:
            return sample<std::int8_t>(bytes, false);
        case SampleType::uint16:
            return sample<std::uint16_t>(bytes, swap);
        case SampleType::int16:
            return sample<std::int16_t>(bytes, swap);
        case SampleType::uint32:
            return sample<std::uint32_t>(bytes, swap);
        case SampleType::int32:
            return sample<std::int32_t>(bytes, swap);
        case SampleType::float32:
            return sample<float>(bytes, swap);
        case SampleType::float64:
            return sample<double>(bytes, swap);
        case SampleType::uint64:
            return sample<std::uint64_t>(bytes, swap);
        case SampleType::int64:
            return sample<std::int64_t>(bytes, swap);
        case SampleType::float16:
            break;
    }
    return fromHalf(static_cast<std::uint16_t>(sample<std::uint16_t>(bytes, swap)));
}

/// The light that a number from 0 to 1 stands for (IEC 61966-2-1).
double linearOf(double srgb) {
    return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

/// A stream of zlib within a file.
class Inflated {
  public:
    Inflated(const std::string& path, std::int64_t begin) : m_path(path), m_file(path, std::ios::binary) {
        m_file.seekg(begin);
        if (!m_file || inflateInit(&m_stream) != Z_OK) refuse(path, "cannot be opened");
    }
    ~Inflated() { inflateEnd(&m_stream); }
    Inflated(const Inflated&) = delete;
    Inflated& operator=(const Inflated&) = delete;

    /// Reads up to `count` bytes; fewer at the end. Throws on damaged compression.
    std::int64_t read(char* to, std::int64_t count) {
        m_stream.next_out = reinterpret_cast<Bytef*>(to);
        m_stream.avail_out = static_cast<uInt>(count);
        while (m_stream.avail_out > 0 && !m_ended) {
            if (m_stream.avail_in == 0) {
                m_file.read(m_packed.data(), static_cast<std::streamsize>(m_packed.size()));
                m_stream.next_in = reinterpret_cast<Bytef*>(m_packed.data());
                m_stream.avail_in = static_cast<uInt>(m_file.gcount());
                if (m_stream.avail_in == 0) break;
            }
            const int code = inflate(&m_stream, Z_NO_FLUSH);
            m_ended = code == Z_STREAM_END;
            if (code != Z_OK && !m_ended) refuse(m_path, "its compressed data is damaged");
        }
        return count - m_stream.avail_out;
    }

  private:
    std::string m_path;
    std::ifstream m_file;
    z_stream m_stream{};
    std::array<char, 1 << 14> m_packed{};
    bool m_ended = false;
};

}  // namespace

std::int64_t bytesOf(SampleType type) {
    constexpr std::array<std::int64_t, kSampleTypes> kBytes{1, 1, 2, 2, 4, 4, 4, 8, 8, 8, 2};
    return kBytes[static_cast<std::size_t>(type)];
}

std::string nameOf(SampleType type) {
    constexpr std::array<const char*, kSampleTypes> kNames{"uint8", "int8",   "uint16", "int16", "uint32", "int32",
                                                           "float", "double", "uint64", "int64", "half"};
    return kNames[static_cast<std::size_t>(type)];
}

void worldFromIndexOf(const Scan& scan, double matrix[16]) {
    for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 4; ++column)
            matrix[4 * row + column] = row == 3 ? column == 3 : column == 3 ? scan.origin[row] : scan.axes[column][row];
}

std::string textOf(const Size& size) {
    return fmt::format("{} x {} x {}", size[0], size[1], size[2]);
}

std::string lowerCase(std::string text) {
    for (char& c : text) c = c >= 'A' && c <= 'Z' ? static_cast<char>(c + ('a' - 'A')) : c;
    return text;
}

void refuse(const std::string& path, const std::string& reason) {
    throw std::runtime_error(path + ": " + reason);
}

void checkComponent(std::int64_t component, std::int64_t count, const std::string& path) {
    if (component < 0 && count != 1)
        refuse(path, fmt::format("holds {0} volumes, expected one; component = 0 to {1} takes one of them", count,
                                 count - 1));
    if (component >= std::max<std::int64_t>(count, 1))
        refuse(path, fmt::format("holds {} volume{}, and no component {}", count, count == 1 ? "" : "s", component));
}

void checkWithin(const std::string& name, const std::string& path) {
    const std::filesystem::path file(name);
    if (std::find(file.begin(), file.end(), "..") != file.end() || file.is_absolute())
        refuse(path,
               fmt::format("its samples are in '{}', expected a file in its own folder or below", name.substr(0, 200)));
}

std::int64_t sampleCount(const Size& size, const std::string& path) {
    std::int64_t count = 1;
    for (const std::int64_t n : size) {
        if (n < 1) refuse(path, fmt::format("{} samples, expected at least 1 along each axis", textOf(size)));
        if (n > kMostSamples / count)
            refuse(path, fmt::format("{} samples are too many, expected at most {}", textOf(size), kMostSamples));
        count *= n;
    }
    return count;
}

std::int64_t fileBytes(const std::string& path) {
    std::error_code error;
    const auto status = std::filesystem::status(path, error);
    if (status.type() == std::filesystem::file_type::not_found) refuse(path, "there is no such file");
    if (error) refuse(path, error.message());
    if (status.type() != std::filesystem::file_type::regular) refuse(path, "is not a file");
    const auto bytes = std::filesystem::file_size(path, error);
    if (error) refuse(path, error.message());
    return static_cast<std::int64_t>(bytes);
}

void checkRatio(std::int64_t compressed, std::int64_t bytes, const std::string& path) {
    if (bytes > compressed * kMostRatio + kSlack)
        refuse(path, fmt::format("declares {} bytes of samples, more than its {} compressed bytes can hold", bytes,
                                 compressed));
}

bool isReal(SampleType type) {
    return type == SampleType::float16 || type == SampleType::float32 || type == SampleType::float64;
}

void addColours(const std::vector<float>& parts, SampleType type, Scan& scan) {
    const bool real = isReal(type);
    const bool isSigned = nameOf(type).starts_with("int");
    const double white = real ? 1 : std::exp2(8 * double(bytesOf(type)) - (isSigned ? 1 : 0)) - 1;
    for (std::size_t i = 0; i + 2 < parts.size(); i += 3) {
        scan.values.push_back(0.2126f * parts[i] + 0.7152f * parts[i + 1] + 0.0722f * parts[i + 2]);
        for (std::size_t c = 0; c < 3; ++c) {
            const double part = double(parts[i + c]) / white;
            scan.colours[c].push_back(static_cast<float>(real ? part : linearOf(part)));
        }
    }
}

std::string colourTypeOf(SampleType type) {
    return "RGB of " + nameOf(type);
}

std::vector<float> samplesIn(const std::string& bytes, const RawLayout& layout) {
    const bool swap = layout.bigEndian == (std::endian::native == std::endian::little);
    const auto width = static_cast<std::size_t>(bytesOf(layout.type));
    std::vector<float> values;
    values.reserve(bytes.size() / width);
    for (std::size_t at = 0; at + width <= bytes.size(); at += width)
        values.push_back(sample(layout.type, bytes.data() + at, swap));
    return values;
}

std::vector<float> readRaw(const std::string& path, const RawLayout& layout) {
    const std::int64_t count = sampleCount(layout.size, path), width = bytesOf(layout.type);
    const std::int64_t expected = layout.header + count * width, stored = fileBytes(path);
    const bool compressed = path.ends_with(".gz") || layout.deflated;
    const std::string declared = fmt::format("{} bytes ({} of {} after {} bytes of header)", expected,
                                             textOf(layout.size), nameOf(layout.type), layout.header);
    if (compressed)
        checkRatio(stored, expected, path);
    else if (stored < expected || (layout.exact && stored > expected))
        refuse(path, fmt::format("has {} bytes, expected {}", stored, declared));

    // A confined process must not have the file open twice: its descriptors share one position.
    std::optional<Inflated> inflated;
    std::optional<Bytes> in;
    if (layout.deflated)
        inflated.emplace(path, layout.header);
    else
        in.emplace(path, compressed);
    std::vector<char> chunk(static_cast<std::size_t>(1 << 16));  // a multiple of every sample's width
    const auto limit = static_cast<std::int64_t>(chunk.size());
    std::int64_t got = 0;
    const auto fetch = [&](std::int64_t bytes) {
        const std::int64_t n = inflated ? inflated->read(chunk.data(), bytes) : in->read(chunk.data(), bytes);
        got += n;
        if (n < bytes) refuse(path, fmt::format("ends after {} bytes, expected {}", got, declared));
    };
    for (std::int64_t left = inflated ? 0 : layout.header; left > 0; left -= std::min(left, limit))
        fetch(std::min(left, limit));

    const bool swap = layout.bigEndian == (std::endian::native == std::endian::little);
    std::vector<float> values(static_cast<std::size_t>(count));
    for (std::int64_t i = 0; i < count;) {
        const std::int64_t n = std::min(count - i, limit / width);
        fetch(n * width);
        for (std::int64_t k = 0; k < n; ++k, ++i)
            values[static_cast<std::size_t>(i)] = sample(layout.type, chunk.data() + k * width, swap);
    }
    if (in && compressed && layout.exact && in->read(chunk.data(), 1) != 0)
        refuse(path, fmt::format("has data after {}", declared));
    return values;
}

}  // namespace scan
