// SPDX-License-Identifier: Apache-2.0
// The one way to ask for the limits of this process, and to lower them. Only the plug-in for meshes
// has a way of its own, since volume sources include nothing of Scrim but their interface.
#pragma once

#include <algorithm>
#include <cerrno>

#include <sys/resource.h>

namespace scrim {

using LimitedResource = decltype(RLIMIT_AS);

/// The soft limit of this process on `resource`; RLIM_INFINITY, the largest number, where there is none.
inline rlim_t limitOf(LimitedResource resource) {
    rlimit limits{};
    return ::getrlimit(resource, &limits) == 0 ? limits.rlim_cur : RLIM_INFINITY;
}

/// Lowers the limit on `resource` to `most` for good; a limit that is lower already stays. Only root could raise it
/// again. The hard limit, which acts without a signal that can be handled, is `beyond` higher. Returns 0 or the errno.
inline int lowerLimit(LimitedResource resource, rlim_t most, rlim_t beyond = 0) {
    rlimit given{};
    if (::getrlimit(resource, &given) != 0) return errno;
    const rlim_t soft = std::min({most, given.rlim_cur, given.rlim_max});
    const rlimit both{soft, std::min(soft + beyond, given.rlim_max)};
    return ::setrlimit(resource, &both) == 0 ? 0 : errno;
}

}  // namespace scrim
