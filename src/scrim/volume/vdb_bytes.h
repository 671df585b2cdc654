// SPDX-License-Identifier: Apache-2.0
// Internal: random access to the bytes of a .vdb file, in memory or on disk, and a reader that
// walks along them and never past their end. From disk only the requested bytes are read. The file
// is not mapped, since a file that shrinks under a mapping kills the process.
#pragma once

#include <scrim/base/error.h>

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace scrim {

/// How the error ends that reading a file of less than 16 MiB raises where memory does not suffice. If the system
/// limits memory to less than LoadOptions::kLeastMemory, guarded_load.cpp replaces it by an error about that limit.
constexpr const char* kClaimsMemory = "it claims more memory than its size allows";

/// Must not be used from several threads at once.
class VdbBytes {
  public:
    /// Opens `path`, which must be a regular file. Throws Error(input) "path: reason".
    explicit VdbBytes(const std::string& path);
    /// Uses a regular file that is open as descriptor `file`, which this object will close; `path` is for messages.
    VdbBytes(const std::string& path, int file);
    /// Uses bytes in memory, which must outlive this object; `path` is for messages.
    VdbBytes(const std::string& path, std::span<const char> bytes);
    ~VdbBytes();
    VdbBytes(const VdbBytes&) = delete;
    VdbBytes& operator=(const VdbBytes&) = delete;

    const std::string& path() const { return m_path; }
    std::uint64_t size() const { return m_size; }
    /// The file's descriptor; -1: none.
    int descriptor() const { return m_file; }

    /// Copies `count` bytes, all within the size, from position `at`. Throws Error(input) where the disk fails.
    void copy(std::uint64_t at, std::uint64_t count, char* to) const;

  private:
    void read(std::uint64_t at, std::uint64_t count, char* to) const;

    std::string m_path;
    int m_file = -1;
    const char* m_memory = nullptr;
    std::uint64_t m_size = 0;
    // The part of the file that was read last, since a walk asks for a few bytes at a time.
    mutable std::array<char, 4096> m_window;
    mutable std::uint64_t m_windowAt = 0;
    mutable std::uint64_t m_windowSize = 0;
};

/// Open files; where they are those of one volume, the first is its own.
using VdbFiles = std::vector<std::unique_ptr<VdbBytes>>;
/// Opens `path`, then others[1], others[2] and so on. others[0] is another name of the file `path` (GridEdit::files).
VdbFiles openFiles(const std::string& path, std::span<const std::string> others);

/// Reads one item after another; `what` names the item in errors.
class VdbWalker {
  public:
    explicit VdbWalker(const VdbBytes& bytes, std::uint64_t at = 0) : m_bytes(bytes), m_at(at) {}

    template <typename T>
    T number(const char* what) {
        need(sizeof(T), what);
        T value;
        m_bytes.copy(m_at, sizeof(T), reinterpret_cast<char*>(&value));
        m_at += sizeof(T);
        return value;
    }

    /// Reads a length and that many bytes.
    std::string text(const char* what);
    void skip(std::uint64_t size, const char* what);

    /// Reads a map of metadata: names, types and values of a stated size. Calls `visit(name, type, size)` with this
    /// walker at each value. Wherever `visit` leaves it, reading continues behind the value.
    template <typename Visit>
    void metadata(const Visit& visit) {
        for (std::uint32_t left = metadataCount(); left > 0; --left) {
            const std::string name = text("a metadata name");
            const std::string type = text("a metadata type");
            const auto size = number<std::uint32_t>("a metadata value");
            need(size, "a metadata value");
            const std::uint64_t end = m_at + size;
            visit(name, type, size);
            m_at = end;
        }
    }

    std::uint64_t at() const { return m_at; }
    void goTo(std::uint64_t at) { m_at = at; }
    std::uint64_t left() const { return m_bytes.size() - m_at; }

    [[noreturn]] void damaged(const std::string& reason) const;

  private:
    void need(std::uint64_t size, const char* what) const;
    std::uint32_t metadataCount();

    const VdbBytes& m_bytes;
    std::uint64_t m_at = 0;
};

}  // namespace scrim
