// SPDX-License-Identifier: Apache-2.0
#include <scrim/guard/transfer_file.h>

#include <scrim/base/parallel.h>
#include <scrim/base/system_error.h>
#include <scrim/volume/grid_request.h>

#include <algorithm>
#include <cerrno>
#include <filesystem>
#include <new>

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

namespace scrim {
namespace {

constexpr std::uint64_t kMagic = 0x3252464d49524353;  // "SCRIMFR2"
constexpr std::uint64_t kAlignment = 64;              // a cache line, which is more than any float needs

constexpr std::uint64_t kBlockBytes = kBlockVoxels * sizeof(float);
constexpr std::uint64_t kLargePage = 2 << 20;  // a system with large pages maps these at once

std::uint64_t alignedUp(std::uint64_t at, std::uint64_t alignment = kAlignment) {
    return (at + alignment - 1) / alignment * alignment;
}

/// Throws the error of a failed write. Children call this, too; behind their filter they cannot query limits. A child
/// may write no more than its memory limit, and the limit on file sizes may be lower.
[[noreturn]] void failedToWrite() {
    const int error = errno;
    if (error == EFBIG)
        throw Error(
            ErrorKind::output,
            "cannot hand over what was read: it exceeds the limit on file sizes (ulimit -f) or on memory (--memory)");
    const bool space = error == ENOSPC || error == ENOMEM || error == EDQUOT;
    throw Error(space ? ErrorKind::memory : ErrorKind::render,
                std::string("cannot hand over what was read: ") + std::strerror(error));
}

/// True if `name` is that of a file in some folder or below it ("slices/ct.raw"), and no way out of the folder.
bool isNameWithin(const std::string& name) {
    constexpr std::size_t kLongest = 255;  // what a child hands over
    if (name.empty() || name.size() > kLongest || name.find('\0') != std::string::npos) return false;
    const std::filesystem::path path(name);
    return path.is_relative() && path.has_filename() && path.filename() != "." &&
           std::find(path.begin(), path.end(), "..") == path.end();
}

GridRequest requestFrom(const std::string& text) {
    try {
        return gridRequestFrom(text);
    } catch (const Error& error) {
        incompleteTransfer(error.what());
    }
}

bool isOf(const TransferHeader& header, TransferKind kind) {
    return header.kind == static_cast<std::uint32_t>(kind);
}

/// Throws the error that was sent instead of a result.
[[noreturn]] void throwSent(const TransferHeader& header, TransferReader& reader) {
    const auto isKind = [&](ErrorKind kind) { return header.code == static_cast<std::uint32_t>(kind); };
    // No other kind of error can be blamed on the user who reads a file.
    const ErrorKind kind = isKind(ErrorKind::memory)   ? ErrorKind::memory
                           : isKind(ErrorKind::render) ? ErrorKind::render
                           // A child always has a limit on file sizes; this process's own limit
                           // decides what the error means.
                           : isKind(ErrorKind::output) ? (limitsFileSizes() ? ErrorKind::output : ErrorKind::memory)
                                                       : ErrorKind::input;
    const std::string problem = shortened(reader.text(), 2000);
    if (isOf(header, TransferKind::gridError)) throw GridError(problem, requestFrom(reader.text()));
    if (isOf(header, TransferKind::error)) throw Error(kind, problem);
    const std::string name = reader.text();
    if (!isNameWithin(name)) incompleteTransfer("it names a file in another folder");
    throw BesideError(Error(kind, problem), name);
}

}  // namespace

int createTransfer() {
    const int fd = aboveStandardStreams(::memfd_create("scrim-transfer", MFD_CLOEXEC | MFD_ALLOW_SEALING));
    if (fd >= 0) return fd;
    const int error = errno;
    throw Error(kindOfSystemError(error, ErrorKind::memory), "cannot create shared memory: " + systemErrorText(error));
}

void incompleteTransfer(const std::string& reason) {
    throw Error(ErrorKind::input, "what was read is incomplete: " + reason);
}

TransferBlocks::TransferBlocks(int fd) : m_fd(fd), m_end(sizeof(TransferHeader)) {
    if (::ftruncate(m_fd, 0) != 0) failedToWrite();
}

std::shared_ptr<float[]> TransferBlocks::take(std::size_t count) {
    if (count == 0) return BlockMemory::take(0);
    const auto page = static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
    const std::uint64_t bytes = alignedUp(count * kBlockBytes, page);
    const std::uint64_t at = alignedUp(m_end, bytes < kLargePage ? page : kLargePage);
    if (::ftruncate(m_fd, static_cast<off_t>(at + bytes)) != 0) failedToWrite();
    void* const address = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_SHARED, m_fd, static_cast<off_t>(at));
    if (address == MAP_FAILED) throw std::bad_alloc();
    (void)::madvise(address, bytes, MADV_HUGEPAGE);  // where the system has none, small ones do
    // All of it will be written, at scattered places: together its pages come faster than one by one.
    constexpr std::uint64_t kPart = 2 * kLargePage;
    parallelFor((bytes + kPart - 1) / kPart, [&](std::size_t i) {
        const std::uint64_t from = i * kPart;
        (void)::madvise(static_cast<char*>(address) + from, std::min(kPart, bytes - from), MADV_POPULATE_WRITE);
    });
    m_end = at + bytes;
    const std::shared_ptr<float[]> values(static_cast<float*>(address), [bytes](float* p) { ::munmap(p, bytes); });
    m_parts.push_back({values, at});
    return values;
}

void TransferBlocks::shrink(float* values, std::size_t count, std::size_t kept) {
    if (!positionOf(values)) return;
    const auto page = static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
    const std::uint64_t from = alignedUp(kept * kBlockBytes, page), to = alignedUp(count * kBlockBytes, page);
    if (from < to) (void)::madvise(reinterpret_cast<char*>(values) + from, to - from, MADV_REMOVE);
}

std::optional<std::uint64_t> TransferBlocks::positionOf(const float* values) const {
    for (const Part& part : m_parts)
        if (part.values.get() == values) return part.at;
    return {};
}

TransferWriter::TransferWriter(int fd) : m_fd(fd) {
    if (::ftruncate(m_fd, 0) != 0) failedToWrite();
}

void TransferWriter::bytes(const void* data, std::uint64_t size) {
    write(data, size, m_at);
    m_at += size;
}

void TransferWriter::text(const std::string& s) {
    value(std::uint64_t{s.size()});
    bytes(s.data(), s.size());
}

void TransferWriter::align() {
    m_at = alignedUp(m_at);
}

std::uint64_t TransferWriter::values(const void* data, std::uint64_t size) {
    align();
    const std::uint64_t at = m_at;
    bytes(data, size);
    beginContents();
    return at;
}

void TransferWriter::finish(TransferHeader header, TransferKind kind) {
    if (::ftruncate(m_fd, static_cast<off_t>(m_at)) != 0) failedToWrite();
    header.magic = kMagic;
    header.bytes = m_at;
    header.contents = m_contents;
    header.kind = static_cast<std::uint32_t>(kind);
    write(&header, sizeof header, 0);
}

void TransferWriter::write(const void* data, std::uint64_t size, std::uint64_t at) const {
    if (!writeAll(m_fd, data, size, at)) failedToWrite();
}

bool writeAll(int fd, const void* data, std::uint64_t size, std::uint64_t at) {
    const char* from = static_cast<const char*>(data);  // may be null where size is 0
    while (size > 0) {
        const ssize_t done = ::pwrite(fd, from, size, static_cast<off_t>(at));
        if (done < 0 && errno == EINTR) continue;
        if (done < 0) return false;
        from += done;
        at += static_cast<std::uint64_t>(done);
        size -= static_cast<std::uint64_t>(done);
    }
    return true;
}

TransferMapping::TransferMapping(int fd, Sender sender) {
    struct stat status {};
    if (::fstat(fd, &status) != 0 || !S_ISREG(status.st_mode)) incompleteTransfer("it is not a regular file");
    // If the sender shrank the file later, reading the mapping would crash. Only a memfd can be
    // sealed against that; with other files the caller must make sure that the sender is gone.
    if (sender == Sender::gone) (void)::fcntl(fd, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE);
    if (::fstat(fd, &status) != 0) incompleteTransfer(std::strerror(errno));
    m_size = std::size_t(status.st_size);
    if (m_size < sizeof(TransferHeader)) incompleteTransfer("the process that read it stopped before it was done");
    void* address = ::mmap(nullptr, m_size, PROT_READ, MAP_PRIVATE, fd, 0);
    if (address == MAP_FAILED) throw Error(ErrorKind::memory, "not enough memory to take over what was read");
    m_address = address;
}

TransferMapping::~TransferMapping() {
    if (m_address != nullptr) ::munmap(m_address, m_size);
}

TransferHeader TransferReader::header(TransferKind expected) {
    const auto header = value<TransferHeader>();
    if (header.magic != kMagic) incompleteTransfer("the process that read it stopped before it was done");
    if (header.bytes != m_bytes.size())
        incompleteTransfer(fmt::format("it has {} bytes, expected {}", m_bytes.size(), header.bytes));
    if (header.contents < m_at || header.contents > m_bytes.size()) incompleteTransfer("its contents lie elsewhere");
    m_at = m_contents = header.contents;
    for (const TransferKind error : {TransferKind::error, TransferKind::gridError, TransferKind::besideError})
        if (isOf(header, error)) throwSent(header, *this);
    if (!isOf(header, expected)) incompleteTransfer("it holds something else");
    return header;
}

const char* TransferReader::take(std::uint64_t count, std::uint64_t size) {
    if (count > (m_bytes.size() - m_at) / size) incompleteTransfer("it is shorter than it says");
    const char* at = m_bytes.data() + m_at;
    m_at += count * size;
    return at;
}

std::string TransferReader::text() {
    const auto size = value<std::uint64_t>();
    return std::string(take(size, 1), size);
}

void TransferReader::align() {
    take(alignedUp(m_at) - m_at, 1);
}

const float* TransferReader::blocks(std::uint64_t at, std::uint64_t count) const {
    if (at % kAlignment != 0 || at > m_contents || count > (m_contents - at) / kBlockBytes)
        incompleteTransfer("its values lie elsewhere");
    return reinterpret_cast<const float*>(m_bytes.data() + at);
}

}  // namespace scrim
