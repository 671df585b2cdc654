// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/picture_module.h>

#include <scrim/base/installed.h>

namespace scrim {

const PictureModule& pictureModule() {
    static const PictureModule* const module = reinterpret_cast<PictureModuleFunction>(
        moduleFunction("scrim_images.so", SCRIM_PICTURE_MODULE_SYMBOL, "reads and writes pictures"))();
    return *module;
}

}  // namespace scrim
