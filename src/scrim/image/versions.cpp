// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/versions.h>

#include <OpenColorIO/OpenColorIO.h>
#include <OpenEXR/OpenEXRConfig.h>
#include <OpenImageIO/oiioversion.h>
#include <fmt/format.h>

namespace scrim {

std::string openExrVersion() {
    return OPENEXR_VERSION_STRING;
}

std::string openColorIoVersion() {
    return OCIO_NAMESPACE::GetVersion();
}

std::string openImageIoVersion() {
    // This is the version compiled against; asking the library itself would load it.
    return fmt::format("{}.{}.{}", OIIO_VERSION_MAJOR, OIIO_VERSION_MINOR, OIIO_VERSION_PATCH);
}

}  // namespace scrim
