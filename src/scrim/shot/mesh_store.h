// SPDX-License-Identifier: Apache-2.0
// The meshes of solids. They are read once and kept as long as the next frame shows them, too.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/scene/scene.h>
#include <scrim/solid/solids.h>
#include <scrim/guard/load_options.h>

#include <cstddef>
#include <map>
#include <memory>
#include <string>

namespace scrim {

class MeshStore {
  public:
    /// Loads the triangles of every mesh of `scene` that names a file, and forgets meshes of the
    /// previous frame that this one does not use. A guarded load calls `checkpoint` while it waits.
    /// Throws Error "scene.toml:12:8: mesh 'actor': ...".
    void loadInto(Scene& scene, const LoadOptions& load, const Checkpoint& checkpoint);

    /// Memory of the meshes and of the trees that rays need.
    std::size_t bytes() const;

  private:
    std::map<std::string, std::shared_ptr<const TriangleMesh>> m_meshes;  // by file
};

/// Lets the lights whose shapes are meshes shine from those of a loaded scene.
void shineFromMeshes(Scene& scene);

/// The solids of a loaded scene; null where it has no meshes.
std::shared_ptr<const Solids> solidsOf(const Scene& scene);

}  // namespace scrim
