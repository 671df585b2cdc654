// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/ax_module.h>

#include <scrim/base/error.h>

#include <fmt/format.h>

#include <filesystem>
#include <system_error>

#include <dlfcn.h>

namespace scrim {

const AxModule* loadAxModule(const std::string& path, const std::string& where) {
    void* module = ::dlopen(path.c_str(), RTLD_LAZY | RTLD_LOCAL);
    void* function = module == nullptr ? nullptr : ::dlsym(module, SCRIM_AX_MODULE_SYMBOL);
    if (function != nullptr) return reinterpret_cast<AxModuleFunction>(function)();
    const char* reason = ::dlerror();
    std::error_code ignored;
    if (!std::filesystem::exists(path, ignored))
        throw Error(ErrorKind::render,
                    fmt::format("{}: this needs OpenVDB AX, and {} is not installed; install the package scrim-ax, or "
                                "build Scrim with libopenvdb-ax-dev",
                                where, shortened(path)));
    throw Error(ErrorKind::render, fmt::format("{}: cannot load OpenVDB AX (package libopenvdb-ax10.0): {}", where,
                                               shortened(reason == nullptr ? path : reason)));
}

}  // namespace scrim
