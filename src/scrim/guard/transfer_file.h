// SPDX-License-Identifier: Apache-2.0
// Internal: the file through which one process hands what it read to another (field_transfer.h,
// picture_transfer.h). The sender writes the contents first and the header last, so that a sender
// that dies half-way leaves no valid header. The receiver trusts nothing. Large values lie before
// the contents, which say where, so that they can be made in place.
#pragma once

#include <scrim/base/error.h>
#include <scrim/volume/block_memory.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace scrim {

enum class TransferKind : std::uint32_t {
    fields = 1,
    info = 2,
    error = 3,
    request = 4,
    picture = 5,
    pictureHeader = 6,
    mesh = 7,
    pictureDepth = 8,
    file = 9,
    photometry = 10,
    gridError = 11,
    besideError = 12,
};

/// The start of the file; the contents that `kind` stands for begin at byte `contents` and reach to
/// the end. An error consists of its text; a GridError adds the text of its request, a BesideError
/// a file name. Numbers have this machine's byte order, because both ends run on it.
struct TransferHeader {
    std::uint64_t magic = 0;
    std::uint64_t bytes = 0;  ///< size of the whole file
    std::uint64_t contents = 0;
    std::uint32_t kind = 0;
    std::uint32_t code = 0;  ///< kind of an error
    std::uint64_t fields = 0;
    std::uint64_t messages = 0;
};

/// A file could not be read, perhaps because a second file of the same folder or below is missing, which was asked for.
class BesideError : public Error {
  public:
    BesideError(const Error& error, std::string name) : Error(error), m_name(std::move(name)) {}
    /// The name of the second file, within the folder of the first once it has been received.
    const std::string& name() const noexcept { return m_name; }

  private:
    std::string m_name;
};

/// Creates the descriptor to share: a memfd that is closed on exec (dup it for a child that execs) and does not take
/// the number of a closed standard stream. The caller closes it. Throws Error: memory, render.
int createTransfer();

/// Throws Error(input) "what was read is incomplete: ...".
[[noreturn]] void incompleteTransfer(const std::string& reason);

/// Writes all bytes at position `at` of a file. False: it failed, as errno tells.
bool writeAll(int fd, const void* data, std::uint64_t size, std::uint64_t at);

/// Memory for blocks that lies in the transfer, before its contents. A field whose values are there
/// is handed over without a copy (sendFields).
class TransferBlocks : public BlockMemory {
  public:
    /// Invalidates the former contents of the file, a memfd, which must stay open as long as this object lives.
    explicit TransferBlocks(int fd);

    /// Throws Error as TransferWriter does.
    std::shared_ptr<float[]> take(std::size_t count) override;
    /// Gives memory back to the system; the file keeps its size.
    void shrink(float* values, std::size_t count, std::size_t kept) override;

    /// Where in the file values that take() returned lie; nothing for any other values.
    std::optional<std::uint64_t> positionOf(const float* values) const;
    int fd() const { return m_fd; }
    /// The position behind all that was taken.
    std::uint64_t end() const { return m_end; }

  private:
    /// Kept to the end, so that no other values can have the same address.
    struct Part {
        std::shared_ptr<float[]> values;
        std::uint64_t at = 0;
    };

    int m_fd;
    std::uint64_t m_end = 0;
    std::vector<Part> m_parts;
};

/// Throws Error(memory) where there is no space, Error(output) where the limit on file sizes is
/// reached, Error(render) where writing fails otherwise.
class TransferWriter {
  public:
    /// Invalidates the former contents of the file.
    explicit TransferWriter(int fd);
    /// Keeps the values that lie in `blocks`.
    explicit TransferWriter(const TransferBlocks& blocks) : m_fd(blocks.fd()), m_at(blocks.end()) {}

    /// Writes `size` bytes, aligned for any float, and returns their position. Only before the contents.
    std::uint64_t values(const void* data, std::uint64_t size);
    /// What is written from now on are the contents. May be left out where there are no values before them.
    void beginContents() { m_contents = m_at; }
    void bytes(const void* data, std::uint64_t size);
    template <typename T>
    void value(const T& v) {
        bytes(&v, sizeof v);
    }
    void text(const std::string& s);
    /// Skips to a position aligned for any float.
    void align();
    /// Writes the header; must be called last. Fills in its common members.
    void finish(TransferHeader header, TransferKind kind);

  private:
    void write(const void* data, std::uint64_t size, std::uint64_t at) const;

    int m_fd;
    std::uint64_t m_at = sizeof(TransferHeader);
    std::uint64_t m_contents = sizeof(TransferHeader);
};

/// The received file, mapped for reading as long as this object lives.
class TransferMapping {
  public:
    enum class Sender { gone, trusted };

    explicit TransferMapping(int fd, Sender sender = Sender::gone);
    ~TransferMapping();
    TransferMapping(const TransferMapping&) = delete;
    TransferMapping& operator=(const TransferMapping&) = delete;

    std::span<const char> bytes() const { return {static_cast<const char*>(m_address), m_size}; }

  private:
    void* m_address = nullptr;
    std::size_t m_size = 0;
};

/// Reads one item after another. Throws as `incompleteTransfer` where the file ends too early.
class TransferReader {
  public:
    explicit TransferReader(const TransferMapping& mapping) : m_bytes(mapping.bytes()) {}

    /// Reads the header; must be called first. Throws the Error that was sent instead, if there is one.
    TransferHeader header(TransferKind expected);
    /// Returns the next `count` records of `size` bytes each.
    const char* take(std::uint64_t count, std::uint64_t size);
    template <typename T>
    T value() {
        T v;
        std::memcpy(&v, take(1, sizeof v), sizeof v);
        return v;
    }
    std::string text();
    void align();
    /// The values of `count` blocks at the position `at`, which must lie before the contents.
    const float* blocks(std::uint64_t at, std::uint64_t count) const;
    bool done() const { return m_at == m_bytes.size(); }

  private:
    std::span<const char> m_bytes;
    std::uint64_t m_at = 0;
    std::uint64_t m_contents = 0;
};

}  // namespace scrim
