// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/mesh_store.h>

#include <scrim/base/error.h>
#include <scrim/guard/load_fields.h>
#include <scrim/scene/light_surface.h>

#include <fmt/format.h>

#include <algorithm>
#include <utility>
#include <vector>

namespace scrim {

void MeshStore::loadInto(Scene& scene, const LoadOptions& load, const Checkpoint& checkpoint) {
    std::map<std::string, std::shared_ptr<const TriangleMesh>> kept;
    for (SceneMesh& mesh : scene.meshes) {
        if (mesh.file.empty()) {  // the mesh was made in code
            if (!mesh.mesh) throw Error(ErrorKind::usage, fmt::format("mesh '{}' has no triangles", mesh.name));
            continue;
        }
        std::shared_ptr<const TriangleMesh>& known = kept[mesh.file];
        if (const auto before = m_meshes.find(mesh.file); before != m_meshes.end()) known = before->second;
        try {
            if (!known) known = std::make_shared<const TriangleMesh>(loadMesh(mesh.file, load, checkpoint));
        } catch (const Error& error) {
            if (error.kind() == ErrorKind::interrupted) throw;
            const std::string place = mesh.where.empty() ? "" : mesh.where + ": ";
            throw Error(error.kind(), fmt::format("{}mesh '{}': {}", place, mesh.name, error.what()));
        }
        mesh.mesh = known;
    }
    m_meshes = std::move(kept);
    shineFromMeshes(scene);
}

std::size_t MeshStore::bytes() const {
    constexpr std::size_t kForRays = 4;  // size relative to the mesh: doubles, floats and trees for up to three roles
    std::size_t sum = 0;
    for (const auto& [file, mesh] : m_meshes) sum += (1 + kForRays) * mesh->bytes();
    return sum;
}

void shineFromMeshes(Scene& scene) {
    for (Light& light : scene.lights)
        if (const Light::Area* area = light.area(); area && area->shape == AreaShape::mesh)
            for (const SceneMesh& mesh : scene.meshes)
                if (mesh.name == area->mesh) shineFrom(light, *mesh.mesh, mesh.wsFromMesh);
}

std::shared_ptr<const Solids> solidsOf(const Scene& scene) {
    std::vector<Solid> solids;
    for (const SceneMesh& mesh : scene.meshes)
        solids.push_back(
            {mesh.name, mesh.mesh, mesh.wsFromMesh, mesh.holdout, mesh.shadows, mesh.catches, mesh.albedo, mesh.color});
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        const Light& light = scene.lights[i];
        const Light::Area* area = light.area();
        if (!light.visible || area == nullptr) continue;
        const auto mesh = std::ranges::find(solids, area->mesh, &Solid::name);
        const bool isMesh = area->shape == AreaShape::mesh && mesh != solids.end();
        Solid& solid = isMesh ? *mesh : solids.emplace_back(Solid{.name = light.name, .mesh = {}, .shadows = false});
        solid.mesh = std::make_shared<const TriangleMesh>(surfaceOf(light));
        solid.wsFromMesh = Mat4(1);
        solid.holdout = true;
        solid.light = i;
    }
    return solids.empty() ? nullptr : std::make_shared<const Solids>(std::move(solids));
}

}  // namespace scrim
