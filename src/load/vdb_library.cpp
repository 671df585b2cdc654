// SPDX-License-Identifier: Apache-2.0
#include "vdb_library.h"

#include "fork.h"

#include <scrim/base/error.h>
#include <scrim/base/system_error.h>
#include <scrim/volume/vdb_module.h>

#include <filesystem>
#include <string>
#include <system_error>

#include <dlfcn.h>

namespace scrim {
namespace load {
namespace {

/// Memory that suffices for the module and the libraries that it brings.
constexpr std::size_t kModuleBytes = std::size_t{1} << 30;

struct Library {
    bool tried = false;
    const VdbModule* module = nullptr;
    std::string problem;
};

Library& library() {
    static Library one;
    return one;
}

}  // namespace

void loadOpenVdb() noexcept {
    Library& own = library();
    if (std::exchange(own.tried, true)) return;
    std::error_code error;
    const auto folder = std::filesystem::read_symlink("/proc/self/exe", error).parent_path();
    const std::string path = (folder / "scrim-load-vdb.so").string();
    void* const module = ::dlopen(path.c_str(), RTLD_LAZY | RTLD_LOCAL);
    void* const function = module == nullptr ? nullptr : ::dlsym(module, SCRIM_VDB_MODULE_SYMBOL);
    if (function != nullptr) {
        own.module = reinterpret_cast<VdbModuleFunction>(function)();
    } else {
        const char* reason = ::dlerror();
        own.problem = "cannot load '" + path + "', which reads volumes: " + (reason == nullptr ? "" : reason);
    }
    threadsHaveStarted();  // OpenVDB's
}

bool triedOpenVdb() {
    return library().tried;
}

}  // namespace load

/// Takes the place of the library's function: the module is this program's own, and only reads.
const VdbModule& vdbModule() {
    const load::Library& own = load::library();
    if (own.module == nullptr)
        throw Error(limitsMemory(load::kModuleBytes) ? ErrorKind::memory : ErrorKind::render, own.problem);
    return *own.module;
}

}  // namespace scrim
