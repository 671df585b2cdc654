// SPDX-License-Identifier: Apache-2.0
// The work of a child: reads one mesh.
#pragma once

#include "confine.h"

#include <scrim/solid/mesh_module.h>

#include <string>

namespace scrim::load {

class ReadMesh {
  public:
    static constexpr Rights kRights = Rights::names;

    /// Loads the module at the path `from`. From then on, names of files lead to the open file `input` only.
    ReadMesh(int transfer, std::string path, const std::string& from, int input);
    /// Reads the file and sends its contents, or the error.
    void run() const;

  private:
    int m_transfer;
    std::string m_path;
    const MeshModule* m_module = nullptr;
    std::string m_problem;       ///< why the module cannot be loaded
    bool m_lacksMemory = false;  ///< lack of memory may be the reason
};

}  // namespace scrim::load
