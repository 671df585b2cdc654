// SPDX-License-Identifier: Apache-2.0
// The depth picture that holds volumes out. It is read once and kept as long as the next frame uses the same.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/image/depth_picture.h>
#include <scrim/scene/scene.h>
#include <scrim/guard/load_options.h>

#include <cstddef>

namespace scrim {

class DepthStore {
  public:
    /// Loads the picture of the scene's holdout where it names a file. A guarded load calls `checkpoint` while it
    /// waits. Throws Error "scene.toml:12:8: holdout: ...", also where the picture's size is not the scene's.
    void loadInto(Scene& scene, const LoadOptions& load, const Checkpoint& checkpoint);

    /// Memory of the picture.
    std::size_t bytes() const { return m_known.picture ? m_known.picture->bytes() : 0; }

  private:
    SceneHoldout m_known;
    Int2 m_resolution{0};  // resolution of the scene that it was read for
};

}  // namespace scrim
