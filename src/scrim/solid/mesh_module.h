// SPDX-License-Identifier: Apache-2.0
// Internal: the interface of the module `scrim_meshes`. Assimp brings readers for forty formats, so
// the module is loaded only where a mesh is read: in a child of `scrim-load`, or in this process
// where loading is not guarded. The module uses nothing of Scrim but this header.
#pragma once

#include <scrim/solid/triangle_mesh.h>

#include <string>

namespace scrim {

/// A mesh read from a file.
struct FileMesh {
    TriangleMesh mesh;
    std::string problem;  ///< why there is no mesh, with the path in front; "": there is one
};

struct MeshModule {
    /// Reads an OBJ or PLY file. `alone`: this process was made for that and sets itself limits. A
    /// damaged file may crash it.
    FileMesh (*read)(const std::string& path, bool alone);
};

/// The single function that the module exports. The name must change whenever anything above changes.
#define SCRIM_MESH_MODULE_SYMBOL "scrim_mesh_module_1"
using MeshModuleFunction = const MeshModule* (*)();

/// File name of the module in the folder of modules.
inline constexpr const char* kMeshModule = "scrim_meshes.so";

}  // namespace scrim
