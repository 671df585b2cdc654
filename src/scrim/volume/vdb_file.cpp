// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/vdb_file.h>

#include <scrim/base/error.h>
#include <scrim/volume/openvdb_field.h>
#include <scrim/volume/vdb_layout.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <istream>
#include <streambuf>

#include <fcntl.h>
#include <fmt/format.h>
#include <openvdb/io/Stream.h>
#include <sys/stat.h>
#include <unistd.h>

namespace scrim {

struct VdbFile::Content {
    std::string path;
    VdbLayout layout;
    std::uint64_t bytes = 0;
    std::vector<std::pair<std::string, std::string>> metadata;
    openvdb::GridPtrVec grids;
};

namespace {

constexpr std::size_t kMessageLimit = 1000;  ///< bytes of an error that lists grids
/// A node of OpenVDB's trees takes some 35 times as much memory as it can be compressed to in a file, so
/// files below this need less than 1 GiB, and an allocation that fails is their fault, not the machine's.
constexpr std::size_t kSmallFile = std::size_t{16} << 20;
constexpr std::size_t kMetadataLimit = 200;  ///< bytes of a metadata value worth keeping

[[noreturn]] void fail(const std::string& path, const std::string& reason) {
    throw Error(ErrorKind::input, clipped(path + ": " + reason, kMessageLimit));
}

/// A stream over bytes in memory, with the seeking that OpenVDB's point grids need.
class MemoryBuffer : public std::streambuf {
  public:
    explicit MemoryBuffer(std::span<char> bytes) { setg(bytes.data(), bytes.data(), bytes.data() + bytes.size()); }
    std::size_t remaining() const { return static_cast<std::size_t>(egptr() - gptr()); }

  protected:
    pos_type seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode) override {
        const off_type base = from == std::ios_base::beg   ? 0
                              : from == std::ios_base::cur ? gptr() - eback()
                                                           : egptr() - eback();
        const off_type size = egptr() - eback();
        if (offset < -base || offset > size - base) return pos_type(off_type(-1));
        setg(eback(), eback() + (base + offset), egptr());
        return pos_type(base + offset);
    }
    pos_type seekpos(pos_type at, std::ios_base::openmode mode) override {
        return seekoff(off_type(at), std::ios_base::beg, mode);
    }
};

/// Closes a file descriptor.
struct Descriptor {
    int fd;
    ~Descriptor() {
        if (fd >= 0) ::close(fd);
    }
};

std::vector<char> readBytes(const std::string& path) {
    // Without O_NONBLOCK opening a FIFO would wait for a writer.
    const Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
    if (file.fd < 0) fail(path, errno == ENOENT ? "no such file" : std::strerror(errno));
    struct stat status {};
    if (::fstat(file.fd, &status) != 0) fail(path, std::strerror(errno));
    if (S_ISDIR(status.st_mode)) fail(path, "is a folder, not a VDB file");
    if (!S_ISREG(status.st_mode)) fail(path, "is not a regular file");

    std::vector<char> bytes(static_cast<std::size_t>(status.st_size));
    std::size_t filled = 0;
    while (filled < bytes.size()) {
        const ssize_t got = ::read(file.fd, bytes.data() + filled, bytes.size() - filled);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) fail(path, std::strerror(errno));
        if (got == 0) break;
        filled += static_cast<std::size_t>(got);
    }
    if (filled != bytes.size()) fail(path, "truncated or damaged: it shrank while it was read");
    return bytes;
}

/// Has OpenVDB parse `bytes`; everything it can throw becomes an Error.
void parse(VdbFile::Content& content, std::span<char> bytes) {
    const std::string damaged = "truncated or damaged: ";
    for (const VdbLayout::Grid& grid : content.layout.grids)
        if (!openvdb::GridBase::isRegistered(grid.type))
            fail(content.path,
                 fmt::format("grid '{}' has the type '{}', which OpenVDB {} cannot read", clipped(grid.name, 80),
                             clipped(grid.type, 80), openvdb::getLibraryVersionString()));
    try {
        MemoryBuffer buffer(bytes);
        std::istream stream(&buffer);
        stream.exceptions(std::ios_base::badbit | std::ios_base::failbit | std::ios_base::eofbit);
        openvdb::io::Stream reader(stream, /*delayLoad=*/false);
        if (buffer.remaining() > 0)
            fail(content.path, fmt::format("{}{} bytes are left after the last grid", damaged, buffer.remaining()));
        content.grids = *reader.getGrids();
        const openvdb::MetaMap::Ptr metadata = reader.getMetadata();
        for (auto entry = metadata->beginMeta(); entry != metadata->endMeta(); ++entry)
            content.metadata.emplace_back(clipped(entry->first, kMetadataLimit),
                                          clipped(entry->second->str(), kMetadataLimit));
    } catch (const Error&) {
        throw;
    } catch (const std::ios_base::failure&) {
        fail(content.path, damaged + "its data end too early");
    } catch (const std::bad_alloc&) {
        if (bytes.size() < kSmallFile) fail(content.path, damaged + "it claims more memory than its size allows");
        throw Error(ErrorKind::memory, clipped(content.path + ": not enough memory to read it", kMessageLimit));
    } catch (const std::exception& error) {
        fail(content.path, damaged + clipped(error.what(), 200));
    }
    for (const openvdb::GridBase::Ptr& grid : content.grids)
        if (!grid || !grid->baseTreePtr()) fail(content.path, damaged + "a grid has no tree");
}

/// How many grids before `i`, and in all, have the name of grid i.
std::pair<std::size_t, std::size_t> placeAmongEqual(const openvdb::GridPtrVec& grids, std::size_t i) {
    const std::string name = grids[i]->getName();
    std::size_t before = 0;
    std::size_t all = 0;
    for (std::size_t j = 0; j < grids.size(); ++j) {
        if (grids[j]->getName() != name) continue;
        ++all;
        if (j < i) ++before;
    }
    return {before, all};
}

/// The name by which `VdbFile::field` finds grid i.
std::string callName(const openvdb::GridPtrVec& grids, std::size_t i) {
    const std::string name = grids[i]->getName();
    const auto [before, all] = placeAmongEqual(grids, i);
    return all == 1 && !name.empty() ? name : fmt::format("{}[{}]", name, before);
}

std::vector<std::string> usableNames(const openvdb::GridPtrVec& grids) {
    std::vector<std::string> names;
    for (std::size_t i = 0; i < grids.size(); ++i)
        if (isScalarGrid(*grids[i])) names.push_back(callName(grids, i));
    return names;
}

openvdb::GridBase::Ptr defaultGrid(const VdbFile::Content& content) {
    const auto first = [&](auto&& wanted) -> openvdb::GridBase::Ptr {
        for (const auto& grid : content.grids)
            if (isScalarGrid(*grid) && wanted(*grid)) return grid;
        return nullptr;
    };
    using Grid = openvdb::GridBase;
    if (auto grid = first([](const Grid& g) { return g.getName() == "density"; })) return grid;
    if (auto grid = first([](const Grid& g) { return g.getGridClass() == openvdb::GRID_FOG_VOLUME; })) return grid;
    if (auto grid = first([](const Grid& g) { return g.getGridClass() != openvdb::GRID_LEVEL_SET; })) return grid;
    if (auto grid = first([](const Grid&) { return true; })) return grid;
    std::string types;
    for (std::size_t i = 0; i < content.grids.size(); ++i)
        types += fmt::format("{}'{}' ({})", i == 0 ? "" : ", ", clipped(callName(content.grids, i), 80),
                             content.grids[i]->valueType());
    fail(content.path,
         content.grids.empty() ? std::string("holds no grids") : "holds no float, half or double grid, only " + types);
}

/// "name[i]" → name and i, where it has that form.
bool splitIndex(const std::string& text, std::string& name, std::size_t& index) {
    const std::size_t open = text.rfind('[');
    if (open == std::string::npos || text.back() != ']') return false;
    const char* begin = text.data() + open + 1;
    const char* end = text.data() + text.size() - 1;
    const auto [stop, error] = std::from_chars(begin, end, index);
    if (error != std::errc() || stop != end) return false;
    name = text.substr(0, open);
    return true;
}

openvdb::GridBase::Ptr findGrid(const VdbFile::Content& content, const std::string& wanted) {
    if (wanted.empty()) return defaultGrid(content);
    for (const auto& grid : content.grids)
        if (grid->getName() == wanted) return grid;
    std::string name;
    std::size_t index = 0;
    if (splitIndex(wanted, name, index))
        for (std::size_t i = 0; i < content.grids.size(); ++i)
            if (content.grids[i]->getName() == name && placeAmongEqual(content.grids, i).first == index)
                return content.grids[i];
    std::string list;
    for (std::size_t i = 0; i < content.grids.size(); ++i)
        list += fmt::format("{}'{}' ({})", i == 0 ? "" : ", ", clipped(callName(content.grids, i), 80),
                            content.grids[i]->valueType());
    fail(content.path, fmt::format("no grid '{}'; it holds {}", clipped(wanted, 80), list.empty() ? "none" : list));
}

}  // namespace

VdbFile VdbFile::open(const std::string& path) {
    std::vector<char> bytes;
    try {
        bytes = readBytes(path);
    } catch (const std::bad_alloc&) {
        throw Error(ErrorKind::memory, clipped(path + ": not enough memory to read this file", kMessageLimit));
    }
    auto content = std::make_unique<Content>();
    content->path = path;
    content->bytes = bytes.size();
    content->layout = checkVdbLayout(path, bytes);
    openvdb::initialize();
    parse(*content, bytes);
    return VdbFile(std::move(content));
}

VdbFileInfo VdbFile::info() const {
    VdbFileInfo info;
    info.path = m_content->path;
    info.fileVersion = m_content->layout.fileVersion;
    info.libraryMajor = m_content->layout.libraryMajor;
    info.libraryMinor = m_content->layout.libraryMinor;
    info.fileBytes = m_content->bytes;
    info.metadata = m_content->metadata;
    for (const auto& grid : m_content->grids) info.grids.push_back(describeGrid(*grid));
    // Without offsets in the file there is only what its writer noted in each grid's metadata, if anything.
    const std::vector<VdbLayout::Grid>& layout = m_content->layout.grids;
    for (std::size_t i = 0; i < std::min(layout.size(), info.grids.size()); ++i) info.grids[i].codec = layout[i].codec;
    return info;
}

std::vector<std::string> VdbFile::usableGrids() const {
    return usableNames(m_content->grids);
}

SparseField VdbFile::field(const std::string& grid, const MessageSink& messages) const {
    const openvdb::GridBase::Ptr found = findGrid(*m_content, grid);
    if (!isScalarGrid(*found))
        fail(m_content->path,
             fmt::format("grid '{}' holds {} values, where a float, half or double grid is expected; of those "
                         "there is {}",
                         clipped(grid, 80), found->valueType(), choices(usableGrids())));
    return fieldFromGrid(*found, m_content->path, messages);
}

VdbFile::VdbFile(std::unique_ptr<Content> content) : m_content(std::move(content)) {}
VdbFile::VdbFile(VdbFile&&) noexcept = default;
VdbFile& VdbFile::operator=(VdbFile&&) noexcept = default;
VdbFile::~VdbFile() = default;

}  // namespace scrim
