// SPDX-License-Identifier: Apache-2.0
// Meshes of solids: read once, and kept as long as the next frame shows them, too.
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
    /// Gives every mesh of `scene` that names a file its triangles; forgets those of the frame before that this one
    /// does not use. A guarded load calls `checkpoint` while it waits. Throws Error "scene.toml:12:8: mesh 'actor':
    /// ...".
    void loadInto(Scene& scene, const LoadOptions& load, const Checkpoint& checkpoint);

    /// That the meshes take, and what rays need of them.
    std::size_t bytes() const;

  private:
    std::map<std::string, std::shared_ptr<const TriangleMesh>> m_meshes;  // by file
};

/// The solids of a loaded scene; null where it has no meshes.
std::shared_ptr<const Solids> solidsOf(const Scene& scene);

}  // namespace scrim
