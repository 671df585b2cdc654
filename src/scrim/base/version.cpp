// SPDX-License-Identifier: Apache-2.0
#include <scrim/base/version.h>

#include <hwy/highway.h>
#include <tbb/version.h>

#ifndef SCRIM_VERSION
#error "define SCRIM_VERSION as the version of Scrim, as a string"
#endif

namespace scrim {

std::string scrimVersion() {
    return SCRIM_VERSION;
}

std::string tbbVersion() {
    return TBB_runtime_version();
}

std::string highwayVersion() {
    return std::to_string(HWY_MAJOR) + "." + std::to_string(HWY_MINOR) + "." + std::to_string(HWY_PATCH);
}

}  // namespace scrim
