// SPDX-License-Identifier: Apache-2.0
// What a child does: reads one mesh.
#pragma once

#include "confine.h"

#include <scrim/solid/mesh_module.h>
#include <scrim/guard/field_transfer.h>

#include <string>

namespace scrim::load {

class ReadMesh {
  public:
    static constexpr Files kFiles = Files::answered;

    /// Loads the module, which the request names as its source. From then on the open file `input` is all that names
    /// lead to.
    ReadMesh(int transfer, LoadRequest request, int input);
    /// Reads the file, and sends what it holds, or what is wrong with it.
    void run() const;

  private:
    int m_transfer;
    LoadRequest m_request;
    const MeshModule* m_module = nullptr;
    std::string m_problem;       ///< of a module that cannot be loaded
    bool m_lacksMemory = false;  ///< which may be why
};

}  // namespace scrim::load
