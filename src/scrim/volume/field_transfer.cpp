// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/field_transfer.h>

#include <scrim/base/parallel.h>
#include <scrim/volume/field_builder.h>
#include <scrim/volume/grid_request.h>
#include <scrim/volume/vdb_info_text.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <limits>
#include <span>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

namespace scrim {

namespace {

/// Layout: Header, then `kind`'s content. Fields: per field a FieldHeader, its name, origins, tiles, and the
/// values of its blocks, which begin at a multiple of kAlignment. Error: its text and, of a GridError (which counts
/// as one field), the text of its request. Numbers are those of this machine: both
/// ends are on it.
constexpr std::uint64_t kMagic = 0x3152464d49524353;  // "SCRIMFR1"
constexpr std::uint64_t kAlignment = 64;              // a cache line, and more than any float needs

enum class Kind : std::uint32_t { fields = 1, info = 2, error = 3 };

struct Header {
    std::uint64_t magic = 0;
    std::uint64_t bytes = 0;  ///< of the whole file
    std::uint32_t kind = 0;
    std::uint32_t code = 0;  ///< of an error: its kind
    std::uint64_t fields = 0;
    std::uint64_t messages = 0;
};

struct FieldHeader {
    std::uint64_t blocks = 0;
    std::uint64_t tiles = 0;
    std::uint64_t nonFinite = 0;
    std::uint64_t negative = 0;
    double wsFromIs[16] = {};  ///< column by column, as GLM
};

struct TileRecord {
    std::int32_t origin[3];
    std::int32_t edge;
    float value;
};

std::uint64_t alignedUp(std::uint64_t at) {
    return (at + kAlignment - 1) / kAlignment * kAlignment;
}

class Writer {
  public:
    /// Invalidates whatever the file held.
    explicit Writer(int fd) : m_fd(fd) {
        if (::ftruncate(m_fd, 0) != 0) fail();
        m_at = sizeof(Header);
    }

    void bytes(const void* data, std::uint64_t size) {
        write(data, size, m_at);
        m_at += size;
    }
    template <typename T>
    void value(const T& v) {
        bytes(&v, sizeof v);
    }
    void text(const std::string& s) {
        value(std::uint64_t{s.size()});
        bytes(s.data(), s.size());
    }
    void align() { m_at = alignedUp(m_at); }

    /// Last of all, so that a file without it is known to be incomplete.
    void finish(Header header) {
        if (::ftruncate(m_fd, static_cast<off_t>(m_at)) != 0) fail();
        header.magic = kMagic;
        header.bytes = m_at;
        write(&header, sizeof header, 0);
    }

  private:
    void write(const void* data, std::uint64_t size, std::uint64_t at) const {
        const char* from = static_cast<const char*>(data);  // null where size is 0
        while (size > 0) {
            const ssize_t done = ::pwrite(m_fd, from, size, static_cast<off_t>(at));
            if (done < 0 && errno == EINTR) continue;
            if (done < 0) fail();
            from += done;
            at += static_cast<std::uint64_t>(done);
            size -= static_cast<std::uint64_t>(done);
        }
    }
    [[noreturn]] static void fail() {
        const bool space = errno == ENOSPC || errno == ENOMEM || errno == EFBIG || errno == EDQUOT;
        throw Error(space ? ErrorKind::memory : ErrorKind::render,
                    std::string("cannot hand over what was read: ") + std::strerror(errno));
    }

    int m_fd;
    std::uint64_t m_at = 0;
};

[[noreturn]] void incomplete(const std::string& reason) {
    throw Error(ErrorKind::input, "what was read is incomplete: " + reason);
}

/// The received file, mapped for reading for as long as someone holds on to it.
struct Mapping {
    void* address = MAP_FAILED;
    std::size_t size = 0;

    explicit Mapping(int fd) {
        struct stat status {};
        if (::fstat(fd, &status) != 0 || !S_ISREG(status.st_mode)) incomplete("it is not a regular file");
        // A sender that shrank the file afterwards would make reads of the mapping crash. Only a memfd can be
        // sealed; with other files the caller sees to it that the sender is gone.
        (void)::fcntl(fd, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE);
        if (::fstat(fd, &status) != 0) incomplete(std::strerror(errno));
        size = std::size_t(status.st_size);
        if (size < sizeof(Header)) incomplete("the process that read it stopped before it was done");
        address = ::mmap(nullptr, size, PROT_READ, MAP_PRIVATE, fd, 0);
        if (address == MAP_FAILED) throw Error(ErrorKind::memory, "not enough memory to take over what was read");
    }
    ~Mapping() {
        if (address != MAP_FAILED) ::munmap(address, size);
    }
    Mapping(const Mapping&) = delete;
    Mapping& operator=(const Mapping&) = delete;

    std::span<const char> bytes() const { return {static_cast<const char*>(address), size}; }
};

class Reader {
  public:
    explicit Reader(std::span<const char> bytes) : m_bytes(bytes) {}

    /// The next `count` records of `size` bytes.
    const char* take(std::uint64_t count, std::uint64_t size) {
        if (count > (m_bytes.size() - m_at) / size) incomplete("it is shorter than it says");
        const char* at = m_bytes.data() + m_at;
        m_at += count * size;
        return at;
    }
    template <typename T>
    T value() {
        T v;
        std::memcpy(&v, take(1, sizeof v), sizeof v);
        return v;
    }
    std::string text() {
        const auto size = value<std::uint64_t>();
        return std::string(take(size, 1), size);
    }
    void align() {
        const std::uint64_t at = alignedUp(m_at);
        take(at - m_at, 1);
    }
    bool done() const { return m_at == m_bytes.size(); }

  private:
    std::span<const char> m_bytes;
    std::uint64_t m_at = 0;
};

GridRequest requestFrom(const std::string& text) {
    try {
        return gridRequestFrom(text);
    } catch (const Error& error) {
        incomplete(error.what());
    }
}

Header readHeader(Reader& reader, const Mapping& mapping, Kind expected) {
    const auto header = reader.value<Header>();
    if (header.magic != kMagic) incomplete("the process that read it stopped before it was done");
    if (header.bytes != mapping.size)
        incomplete(fmt::format("it has {} bytes, expected {}", mapping.size, header.bytes));
    if (header.kind == static_cast<std::uint32_t>(Kind::error)) {
        const auto kind = header.code <= static_cast<std::uint32_t>(ErrorKind::accuracy)
                              ? static_cast<ErrorKind>(header.code)
                              : ErrorKind::input;
        const std::string text = shortened(reader.text(), 2000);
        if (header.fields == 0) throw Error(kind, text);
        throw GridError(text, requestFrom(reader.text()));
    }
    if (header.kind != static_cast<std::uint32_t>(expected)) incomplete("it holds something else");
    return header;
}

/// What `buildField` promises about values, found again in blocks that came from elsewhere: counts them, and
/// tells whether all are finite and not negative.
bool countBlocks(SparseField& field) {
    constexpr std::size_t kBlocksPerTask = 256;
    struct Part {
        std::uint64_t active = 0;
        float maxValue = 0;
        bool good = true;
    };
    std::vector<Part> parts((field.blockCount() + kBlocksPerTask - 1) / kBlocksPerTask);
    parallelFor(parts.size(), [&](std::size_t task) {
        Part& part = parts[task];
        const std::size_t end = std::min(field.blockCount(), (task + 1) * kBlocksPerTask);
        const float* values = field.block(task * kBlocksPerTask);
        for (const float* v = values; v != field.block(end); ++v) {
            part.good = part.good && *v >= 0 && *v <= std::numeric_limits<float>::max();
            part.active += *v > 0;
            part.maxValue = std::max(part.maxValue, *v);
        }
    });
    bool good = true;
    for (const Part& part : parts) {
        good = good && part.good;
        field.activeVoxels += part.active;
        field.maxValue = std::max(field.maxValue, part.maxValue);
    }
    return good;
}

SparseField readField(Reader& reader, const std::shared_ptr<const Mapping>& mapping) {
    const auto header = reader.value<FieldHeader>();
    SparseField field;
    field.name = reader.text();
    field.nonFinite = header.nonFinite;
    field.negative = header.negative;
    FieldPieces frame;  // everything but the values, to be checked as any other field
    frame.name = field.name;
    for (int i = 0; i < 16; ++i) frame.wsFromIs[i / 4][i % 4] = header.wsFromIs[i];
    field.wsFromIs = frame.wsFromIs;

    const char* origins = reader.take(header.blocks, sizeof(Int3));
    field.blockOrigins.resize(header.blocks);
    if (header.blocks > 0) std::memcpy(field.blockOrigins.data(), origins, header.blocks * sizeof(Int3));
    const char* tiles = reader.take(header.tiles, sizeof(TileRecord));
    for (std::uint64_t i = 0; i < header.tiles; ++i) {
        TileRecord t;
        std::memcpy(&t, tiles + i * sizeof t, sizeof t);
        field.tiles.push_back({{t.origin[0], t.origin[1], t.origin[2]}, t.edge, t.value});
        if (!(std::isfinite(t.value) && t.value > 0)) incomplete("a tile holds a value that is not above 0");
    }
    reader.align();
    const auto* values = reinterpret_cast<const float*>(reader.take(header.blocks, kBlockVoxels * sizeof(float)));
    field.blockValues = std::shared_ptr<const float>(mapping, values);

    if (!std::is_sorted(field.blockOrigins.begin(), field.blockOrigins.end(), originLess))
        incomplete("its blocks are out of order");
    frame.blockOrigins = field.blockOrigins;
    frame.tiles = field.tiles;
    try {
        checkPieces(frame);
    } catch (const Error& error) {
        incomplete(error.what());
    }
    if (!countBlocks(field)) incomplete("its blocks hold values that are negative or not finite");
    for (const ConstantTile& tile : field.tiles) {
        const auto edge = static_cast<std::uint64_t>(tile.edge);
        field.activeVoxels += edge * edge * edge;
        field.maxValue = std::max(field.maxValue, tile.value);
    }
    return field;
}

}  // namespace

int createTransfer() {
    const int fd = ::memfd_create("scrim-transfer", MFD_CLOEXEC | MFD_ALLOW_SEALING);
    if (fd < 0) throw Error(ErrorKind::memory, std::string("cannot create shared memory: ") + std::strerror(errno));
    return fd;
}

void sendFields(int fd, const std::vector<SparseField>& fields, const std::vector<TransferMessage>& messages) {
    Writer writer(fd);
    for (const TransferMessage& message : messages) {
        writer.value(static_cast<std::uint32_t>(message.severity));
        writer.text(message.text);
    }
    for (const SparseField& field : fields) {
        FieldHeader header;
        header.blocks = field.blockCount();
        header.tiles = field.tiles.size();
        header.nonFinite = field.nonFinite;
        header.negative = field.negative;
        for (int i = 0; i < 16; ++i) header.wsFromIs[i] = field.wsFromIs[i / 4][i % 4];
        writer.value(header);
        writer.text(field.name);
        writer.bytes(field.blockOrigins.data(), field.blockOrigins.size() * sizeof(Int3));
        for (const ConstantTile& t : field.tiles)
            writer.value(TileRecord{{t.origin.x, t.origin.y, t.origin.z}, t.edge, t.value});
        writer.align();
        writer.bytes(field.blockValues.get(), field.blockCount() * kBlockVoxels * sizeof(float));
    }
    Header header;
    header.kind = static_cast<std::uint32_t>(Kind::fields);
    header.fields = fields.size();
    header.messages = messages.size();
    writer.finish(header);
}

void sendInfo(int fd, const VdbFileInfo& info) {
    Writer writer(fd);
    writer.text(toJson(info));
    Header header;
    header.kind = static_cast<std::uint32_t>(Kind::info);
    writer.finish(header);
}

void sendError(int fd, const Error& error) {
    Writer writer(fd);
    writer.text(error.what());
    Header header;
    header.kind = static_cast<std::uint32_t>(Kind::error);
    if (const auto* ofGrid = dynamic_cast<const GridError*>(&error)) {
        writer.text(toText(ofGrid->request()));
        header.fields = 1;
    }
    header.code = static_cast<std::uint32_t>(error.kind());
    writer.finish(header);
}

ReceivedFields receiveFields(int fd) {
    const auto mapping = std::make_shared<const Mapping>(fd);
    Reader reader(mapping->bytes());
    const Header header = readHeader(reader, *mapping, Kind::fields);
    ReceivedFields out;
    for (std::uint64_t i = 0; i < header.messages; ++i) {
        const auto severity = reader.value<std::uint32_t>();
        out.messages.push_back({severity == 0 ? Severity::info : Severity::warning, shortened(reader.text(), 2000)});
    }
    for (std::uint64_t i = 0; i < header.fields; ++i) out.fields.push_back(readField(reader, mapping));
    if (!reader.done()) incomplete("it is longer than it says");
    return out;
}

VdbFileInfo receiveInfo(int fd) {
    const Mapping mapping(fd);
    Reader reader(mapping.bytes());
    readHeader(reader, mapping, Kind::info);
    return vdbFileInfoFromJson(reader.text());
}

}  // namespace scrim
