// SPDX-License-Identifier: Apache-2.0
// Internal: what the module `scrim_meshes` does. Assimp brings readers for forty formats, and is loaded where a mesh is
// read: in a child of `scrim-load`, or in this process where loading is not guarded. The module uses nothing of Scrim
// but this header.
#pragma once

#include <scrim/solid/triangle_mesh.h>

#include <string>

namespace scrim {

/// A mesh file.
struct FileMesh {
    TriangleMesh mesh;
    std::string problem;  ///< why there is none, with the path in front; "": there is one
};

struct MeshModule {
    /// Reads an OBJ or PLY file. `alone`: this process was made for that, and gets limits. A damaged file may crash it.
    FileMesh (*read)(const std::string& path, bool alone);
};

/// The one function that the module exports. Its name changes with whatever stands above.
#define SCRIM_MESH_MODULE_SYMBOL "scrim_mesh_module_1"
using MeshModuleFunction = const MeshModule* (*)();

/// File name of the module, in the folder of modules.
inline constexpr const char* kMeshModule = "scrim_meshes.so";

}  // namespace scrim
