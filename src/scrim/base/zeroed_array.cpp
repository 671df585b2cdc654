// SPDX-License-Identifier: Apache-2.0
#include <scrim/base/zeroed_array.h>

#include <scrim/base/error.h>

#include <sys/mman.h>
#include <unistd.h>

#include <memory>

namespace scrim {
namespace {

constexpr std::size_t kLargePage = std::size_t{2} << 20;

std::size_t pagesOf(std::size_t bytes) {
    static const auto page = static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
    return (bytes + page - 1) / page * page;
}

char* mapped(std::size_t bytes) {
    void* memory = ::mmap(nullptr, bytes, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS | MAP_NORESERVE, -1, 0);
    if (memory == MAP_FAILED) throw Error(ErrorKind::memory, "not enough memory for the buffers of a render");
    return static_cast<char*>(memory);
}

}  // namespace

void* mapZeros(std::size_t bytes) {
    if (bytes < kLargePage) return mapped(bytes);
    // A large page begins at a multiple of its size; whatever is mapped before that and behind the end is unmapped.
    const std::size_t whole = bytes + kLargePage;
    char* const first = mapped(whole);
    void* aligned = first;
    std::size_t space = whole;
    std::align(kLargePage, bytes, aligned, space);
    char* const memory = static_cast<char*>(aligned);
    if (memory > first) ::munmap(first, std::size_t(memory - first));
    char* const end = memory + pagesOf(bytes);
    if (first + whole > end) ::munmap(end, std::size_t(first + whole - end));
    // This is only a request; if it is not granted, pages are small.
    ::madvise(memory, bytes, MADV_HUGEPAGE);
    return memory;
}

void unmapZeros(void* memory, std::size_t bytes) noexcept {
    ::munmap(memory, bytes);
}

}  // namespace scrim
