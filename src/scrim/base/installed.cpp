// SPDX-License-Identifier: Apache-2.0
#include <scrim/base/installed.h>

#include <scrim/base/error.h>

#include <filesystem>
#include <system_error>

#include <dlfcn.h>
#include <fmt/format.h>

namespace scrim {

std::string libraryFolder() {
    // Any address inside this library will do.
    static const char here = 0;
    Dl_info info{};
    if (::dladdr(&here, &info) == 0 || info.dli_fname == nullptr) return "";
    std::error_code error;
    const std::filesystem::path library = std::filesystem::weakly_canonical(info.dli_fname, error);
    return error ? "" : library.parent_path().string();
}

std::string besideLibrary(const std::string& name) {
    return (std::filesystem::path(libraryFolder()) / "scrim" / name).string();
}

std::string installedModule(const std::string& file, const std::string& what) {
    std::string path = besideLibrary(file);
    std::error_code ignored;
    if (std::filesystem::exists(path, ignored)) return path;
    throw Error(ErrorKind::render, fmt::format("the module that {} is not installed: {}", what, shortened(path)));
}

void* moduleFunction(const std::string& file, const char* symbol, const std::string& what) {
    const std::string path = installedModule(file, what);
    void* module = ::dlopen(path.c_str(), RTLD_LAZY | RTLD_LOCAL);
    void* function = module == nullptr ? nullptr : ::dlsym(module, symbol);
    if (function != nullptr) return function;
    const char* reason = ::dlerror();
    throw Error(ErrorKind::render,
                fmt::format("cannot load the module that {}: {}", what, shortened(reason == nullptr ? path : reason)));
}

}  // namespace scrim
