// SPDX-License-Identifier: Apache-2.0
// The module of meshes (scrim/solid/mesh_module.h): makes the reader of the volume source `mesh` available for solids.
#include <scrim/solid/mesh_module.h>

#include "../../plugins/sources/mesh/mesh.h"

#include <exception>
#include <new>

namespace {

scrim::FileMesh read(const std::string& path, bool alone) {
    scrim::FileMesh out;
    try {
        mesh::Mesh file = mesh::readMesh(path, alone);
        out.mesh.points.reserve(file.points.size());
        for (const mesh::Point& p : file.points) out.mesh.points.emplace_back(p[0], p[1], p[2]);
        out.mesh.triangles = std::move(file.triangles);
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& error) {
        out.problem = error.what();
    }
    return out;
}

}  // namespace

extern "C" __attribute__((visibility("default"))) const scrim::MeshModule* scrim_mesh_module_1() {
    static const scrim::MeshModule module{read};
    return &module;
}
