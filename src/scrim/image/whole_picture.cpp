// SPDX-License-Identifier: Apache-2.0
// OpenEXR's layout follows "OpenEXR File Layout" (openexr.com): magic and version, the header's
// attributes (for each part), a table of the positions of chunks, the chunks.
#include <scrim/image/whole_picture.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <vector>

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

namespace scrim {
namespace {

constexpr std::uint32_t kMagic = 20000630;
constexpr std::uint32_t kTiled = 0x200, kDeep = 0x800, kMultipart = 0x1000;

/// Thrown by reads beyond the end of the file, and for impossible bytes.
struct NotWhole {};

void require(bool condition) {
    if (!condition) throw NotWhole{};
}

/// A regular file; reads never go beyond its end.
class Bytes {
  public:
    explicit Bytes(const std::string& path) : m_file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {
        struct stat status {};
        if (m_file >= 0 && ::fstat(m_file, &status) == 0 && S_ISREG(status.st_mode))
            m_size = static_cast<std::uint64_t>(status.st_size);
    }
    ~Bytes() {
        if (m_file >= 0) ::close(m_file);
    }
    Bytes(const Bytes&) = delete;
    Bytes& operator=(const Bytes&) = delete;

    std::uint64_t size() const { return m_size; }

    template <typename T>
    T number(std::uint64_t at) const {
        T value{};
        // little-endian, as is every machine that this runs on
        copy(at, sizeof value, reinterpret_cast<char*>(&value));
        return value;
    }
    /// The text at `at`, which ends with a 0 within 256 bytes.
    std::string text(std::uint64_t at) const {
        std::array<char, 256> buffer{};
        require(at < m_size);
        const std::uint64_t count = std::min<std::uint64_t>(buffer.size(), m_size - at);
        copy(at, count, buffer.data());
        const auto* end = static_cast<const char*>(std::memchr(buffer.data(), 0, count));
        require(end != nullptr);
        return std::string(static_cast<const char*>(buffer.data()), end);
    }
    bool holds(std::uint64_t at, std::string_view text) const {
        std::string found(text.size(), '\0');
        copy(at, found.size(), found.data());
        return found == text;
    }

  private:
    void copy(std::uint64_t at, std::uint64_t count, char* to) const {
        require(count <= m_size && at <= m_size - count);
        while (count > 0) {
            const ssize_t got = ::pread(m_file, to, count, static_cast<off_t>(at));
            if (got < 0 && errno == EINTR) continue;
            require(got > 0);
            at += static_cast<std::uint64_t>(got);
            to += got;
            count -= static_cast<std::uint64_t>(got);
        }
    }

    int m_file;
    std::uint64_t m_size = 0;
};

/// The attributes of a part's header that determine the form of its chunks.
struct Part {
    bool tiled = false, deep = false;
    int compression = -1;
    std::int32_t firstRow = 0, lastRow = -1;
};

class ExrFile {
  public:
    explicit ExrFile(const Bytes& bytes) : m_bytes(bytes) {}

    void check() {
        require(m_bytes.number<std::uint32_t>(0) == kMagic);
        m_flags = m_bytes.number<std::uint32_t>(4);
        m_at = 8;
        do m_parts.push_back(header());
        while (multipart() && m_bytes.number<std::uint8_t>(m_at) != 0);
        if (multipart()) ++m_at;
        checkChunks();
    }

  private:
    bool multipart() const { return (m_flags & kMultipart) != 0; }

    Part header() {
        Part part;
        part.tiled = (m_flags & kTiled) != 0;
        for (;;) {
            const std::string name = m_bytes.text(m_at);
            m_at += name.size() + 1;
            if (name.empty()) return part;
            m_at += m_bytes.text(m_at).size() + 1;
            const auto size = m_bytes.number<std::int32_t>(m_at);
            require(size >= 0);
            m_at += 4;
            if (name == "compression") part.compression = m_bytes.number<std::uint8_t>(m_at);
            if (name == "dataWindow") {
                part.firstRow = m_bytes.number<std::int32_t>(m_at + 4);
                part.lastRow = m_bytes.number<std::int32_t>(m_at + 12);
            }
            if (name == "type") {  // present in deep files and in those of several parts; a text without a final 0
                part.tiled = m_bytes.holds(m_at, "tiled") || m_bytes.holds(m_at, "deept");
                part.deep = m_bytes.holds(m_at, "deep");
            }
            m_at += static_cast<std::uint64_t>(size);
        }
    }

    /// The first chunk lies right behind the table. A file that was not finished has zeros in its table.
    void checkChunks() const {
        std::uint64_t first = m_bytes.size(), count = 0;
        for (std::uint64_t at = m_at; at < first; at += 8, ++count) {
            const auto offset = m_bytes.number<std::uint64_t>(at);
            require(offset > at);
            first = std::min(first, offset);
            require(endOfChunk(offset) <= m_bytes.size());
        }
        require(count > 0 && first == m_at + 8 * count);
        if (const auto expected = chunkCount()) require(count == *expected);
    }

    std::uint64_t endOfChunk(std::uint64_t at) const {
        Part part = m_parts.front();
        if (multipart()) {
            const auto number = m_bytes.number<std::uint32_t>(at);
            require(number < m_parts.size());
            part = m_parts[number];
            at += 4;
        }
        if (!part.tiled) {
            const auto row = m_bytes.number<std::int32_t>(at);
            require(row >= part.firstRow && row <= part.lastRow);
        }
        at += part.tiled ? 16 : 4;
        if (part.deep) {  // sizes of the table, of the samples, and of the samples before compression
            const auto table = m_bytes.number<std::uint64_t>(at), samples = m_bytes.number<std::uint64_t>(at + 8);
            require(table <= m_bytes.size() && samples <= m_bytes.size());
            return at + 24 + table + samples;
        }
        const auto size = m_bytes.number<std::int32_t>(at);
        require(size > 0);
        return at + 4 + static_cast<std::uint64_t>(size);
    }

    /// For single-part scanline files; no value for others.
    std::optional<std::uint64_t> chunkCount() const {
        // Lines per chunk, by the number of the compression: none, RLE, ZIPS, ZIP, PIZ, PXR24, B44, B44A, DWAA, DWAB.
        constexpr std::array<int, 10> kLines{1, 1, 1, 16, 32, 16, 32, 32, 32, 256};
        const Part& part = m_parts.front();
        if (multipart() || part.tiled || part.deep || (m_flags & kDeep) != 0) return std::nullopt;
        require(part.compression >= 0 && part.compression < static_cast<int>(kLines.size()));
        const std::int64_t rows = std::int64_t{part.lastRow} - part.firstRow + 1;
        require(rows > 0);
        const auto lines = kLines[static_cast<std::size_t>(part.compression)];
        return static_cast<std::uint64_t>((rows + lines - 1) / lines);
    }

    const Bytes& m_bytes;
    std::uint32_t m_flags = 0;
    std::uint64_t m_at = 0;
    std::vector<Part> m_parts;
};

template <typename Check>
bool holdsOf(const std::string& path, const Check& check) {
    try {
        return check(Bytes(path));
    } catch (const NotWhole&) {
        return false;
    }
}

bool beginsWith(const std::string& path, std::string_view text) {
    return holdsOf(path, [&](const Bytes& bytes) { return bytes.holds(0, text); });
}

bool endsWith(const std::string& path, std::string_view text) {
    return holdsOf(path, [&](const Bytes& bytes) {
        require(bytes.size() >= text.size());
        return bytes.holds(bytes.size() - text.size(), text);
    });
}

}  // namespace

bool isWholeExr(const std::string& path) {
    return holdsOf(path, [](const Bytes& bytes) {
        ExrFile(bytes).check();
        return true;
    });
}

std::optional<bool> isWholePicture(const std::string& path) {
    constexpr std::string_view kPng = "\x89PNG\r\n\x1a\n", kEndOfPng = "IEND\xae\x42\x60\x82";
    constexpr std::string_view kJpeg = "\xff\xd8\xff", kEndOfJpeg = "\xff\xd9", kExr = "\x76\x2f\x31\x01";
    if (holdsOf(path, [](const Bytes& bytes) { return bytes.size() == 0; })) return false;
    if (beginsWith(path, kPng)) return endsWith(path, kEndOfPng);
    if (beginsWith(path, kJpeg)) return endsWith(path, kEndOfJpeg);
    if (beginsWith(path, kExr)) return isWholeExr(path);
    return std::nullopt;
}

}  // namespace scrim
