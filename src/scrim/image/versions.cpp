// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/versions.h>

#include <OpenColorIO/OpenColorIO.h>
#include <OpenEXR/OpenEXRConfig.h>
#include <OpenImageIO/imageio.h>

namespace scrim {

std::string openExrVersion() {
    return OPENEXR_VERSION_STRING;
}

std::string openColorIoVersion() {
    return OCIO_NAMESPACE::GetVersion();
}

std::string openImageIoVersion() {
    const int version = OIIO::openimageio_version();  // 10000 * major + 100 * minor + patch
    return std::to_string(version / 10000) + "." + std::to_string(version / 100 % 100) + "." +
           std::to_string(version % 100);
}

}  // namespace scrim
