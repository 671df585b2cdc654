// SPDX-License-Identifier: Apache-2.0
// Internal: the file through which two processes hand over what one of them read (field_transfer.h,
// picture_transfer.h). The sender writes everything and then the header, so that one that died half way leaves no valid
// header. The receiver trusts nothing.
#pragma once

#include <scrim/base/error.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <utility>

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
};

/// What the file begins with; the content that `kind` means follows. An error's is its text and, of a GridError (which
/// counts as one field), the text of its request, of a BesideError (which counts as a message) its name. Numbers are
/// those of this machine: both ends are on it.
struct TransferHeader {
    std::uint64_t magic = 0;
    std::uint64_t bytes = 0;  ///< of the whole file
    std::uint32_t kind = 0;
    std::uint32_t code = 0;  ///< of an error: its kind
    std::uint64_t fields = 0;
    std::uint64_t messages = 0;
};

/// A file could not be read, perhaps for want of another in the same folder, which was asked for.
class BesideError : public Error {
  public:
    BesideError(const Error& error, std::string name) : Error(error), m_name(std::move(name)) {}
    /// Without a folder, once it was received.
    const std::string& name() const noexcept { return m_name; }

  private:
    std::string m_name;
};

/// Creates the descriptor to share: a memfd that is closed on exec (dup it for a child that
/// execs), and not in the place of a standard stream that is closed. The caller closes it. Throws Error: memory,
/// render.
int createTransfer();

/// Throws Error(input) "what was read is incomplete: ...".
[[noreturn]] void incompleteTransfer(const std::string& reason);

/// Throws Error(memory) where there is no space, Error(output) where files may not be as large, Error(render) where
/// writing fails otherwise.
class TransferWriter {
  public:
    /// Invalidates whatever the file held.
    explicit TransferWriter(int fd);

    void bytes(const void* data, std::uint64_t size);
    template <typename T>
    void value(const T& v) {
        bytes(&v, sizeof v);
    }
    void text(const std::string& s);
    /// Goes on at a place where any float may stand.
    void align();
    /// Last of all. Fills in what is the same for all.
    void finish(TransferHeader header, TransferKind kind);

  private:
    void write(const void* data, std::uint64_t size, std::uint64_t at) const;

    int m_fd;
    std::uint64_t m_at = sizeof(TransferHeader);
};

/// The received file, mapped for reading for as long as someone holds on to it.
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

/// Reads one thing after the other. Throws as `incompleteTransfer` where the file ends before.
class TransferReader {
  public:
    explicit TransferReader(const TransferMapping& mapping) : m_bytes(mapping.bytes()) {}

    /// First of all. Throws the Error that was sent instead, if one was.
    TransferHeader header(TransferKind expected);
    /// The next `count` records of `size` bytes.
    const char* take(std::uint64_t count, std::uint64_t size);
    template <typename T>
    T value() {
        T v;
        std::memcpy(&v, take(1, sizeof v), sizeof v);
        return v;
    }
    std::string text();
    void align();
    bool done() const { return m_at == m_bytes.size(); }

  private:
    std::span<const char> m_bytes;
    std::uint64_t m_at = 0;
};

}  // namespace scrim
