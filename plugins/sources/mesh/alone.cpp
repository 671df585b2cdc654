// SPDX-License-Identifier: Apache-2.0
#include "alone.h"

#include <algorithm>
#include <ctime>

namespace mesh {
namespace {

/// Seconds of processor time that this process has used, including the one that has begun.
rlim_t secondsUsed() {
    timespec used{};
    ::clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &used);
    return static_cast<rlim_t>(used.tv_sec) + 1;
}

}  // namespace

LimitForNow::LimitForNow(decltype(RLIMIT_AS) resource, rlim_t value) : m_resource(resource) {
    if (::getrlimit(resource, &m_before) != 0) return;
    m_known = true;
    const rlimit now{std::min(value, m_before.rlim_cur), m_before.rlim_max};
    ::setrlimit(resource, &now);
}

LimitForNow::~LimitForNow() {
    if (m_known) ::setrlimit(m_resource, &m_before);
}

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
// A file tells how much address space is in use, but such a process cannot open it. At its start such a process has
// little more than this.
constexpr rlim_t kBesides = rlim_t{1} << 28;

AloneLimits::AloneLimits(std::uint64_t moreMemory, unsigned seconds)
    : m_time(RLIMIT_CPU, secondsUsed() + seconds), m_memory(RLIMIT_DATA, kBesides + moreMemory) {
    rlimit space{};
    m_lackMemory = m_memory.wasLess(kBesides + moreMemory) ||
                   (::getrlimit(RLIMIT_AS, &space) == 0 && space.rlim_cur < kBesides + moreMemory);
}
#else
AloneLimits::AloneLimits(std::uint64_t, unsigned seconds) : m_time(RLIMIT_CPU, secondsUsed() + seconds) {}
#endif

}  // namespace mesh
