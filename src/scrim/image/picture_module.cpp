// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/picture_module.h>

#include <scrim/base/installed.h>

namespace scrim {
namespace {

constexpr const char* kFile = "scrim_images.so";
constexpr const char* kWhat = "reads slides and writes previews (Debian package scrim-pictures)";

}  // namespace

std::string pictureModulePath() {
    return installedModule(kFile, kWhat);
}

const PictureModule& pictureModule() {
    static const PictureModule* const module =
        reinterpret_cast<PictureModuleFunction>(moduleFunction(kFile, SCRIM_PICTURE_MODULE_SYMBOL, kWhat))();
    return *module;
}

}  // namespace scrim
