// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/block_memory.h>

#include <cstdint>

#include <sys/mman.h>
#include <unistd.h>

namespace scrim {

void BlockMemory::shrink(float* values, std::size_t count, std::size_t kept) {
    const auto page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
    const auto begin = reinterpret_cast<std::uintptr_t>(values + kept * kBlockVoxels);
    const auto end = reinterpret_cast<std::uintptr_t>(values + count * kBlockVoxels);
    const std::uintptr_t first = (begin + page - 1) / page * page, last = end / page * page;
    // Only pages that hold nothing else. They become zeros, without memory until they are touched.
    if (first < last) (void)::madvise(reinterpret_cast<void*>(first), last - first, MADV_DONTNEED);
}

}  // namespace scrim
