// SPDX-License-Identifier: Apache-2.0
#include "read_mesh.h"

#include "answered_calls.h"

#include <scrim/base/error.h>
#include <scrim/base/system_error.h>
#include <scrim/guard/field_transfer.h>
#include <scrim/guard/mesh_transfer.h>
#include <scrim/volume/read_fields.h>

#include <utility>

#include <dlfcn.h>

namespace scrim::load {
namespace {

/// Memory that suffices for the module and the libraries that it brings.
constexpr std::size_t kModuleBytes = std::size_t{1} << 30;

}  // namespace

ReadMesh::ReadMesh(int transfer, std::string path, const std::string& from, int input)
    : m_transfer(transfer), m_path(std::move(path)) {
    void* module = ::dlopen(from.c_str(), RTLD_LAZY | RTLD_LOCAL);
    void* function = module == nullptr ? nullptr : ::dlsym(module, SCRIM_MESH_MODULE_SYMBOL);
    if (function != nullptr) {
        m_module = reinterpret_cast<MeshModuleFunction>(function)();
    } else {
        const char* reason = ::dlerror();
        m_problem = "cannot load '" + from + "', which reads meshes: " + (reason ? reason : "");
        m_lacksMemory = limitsMemory(kModuleBytes);
    }
    if (hasFilter()) AnsweredCalls::install(m_path, input);
}

void ReadMesh::run() const {
    try {
        readWithErrors(m_path, [&] {
            if (m_module == nullptr) throw Error(m_lacksMemory ? ErrorKind::memory : ErrorKind::render, m_problem);
            sendMesh(m_transfer, m_module->read(m_path, true));
        });
    } catch (const Error& error) {
        sendError(m_transfer, error);
    }
}

}  // namespace scrim::load
