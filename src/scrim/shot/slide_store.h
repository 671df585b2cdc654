// SPDX-License-Identifier: Apache-2.0
// The pictures of lights' slides. They are read once and kept as long as the next frame shows them, too.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/image/colour.h>
#include <scrim/image/sky_parts.h>
#include <scrim/scene/scene.h>
#include <scrim/guard/load_options.h>

#include <cstddef>
#include <map>
#include <memory>
#include <string>
#include <utility>

namespace scrim {

class SlideStore {
  public:
    explicit SlideStore(ColourConfig colour) : m_colour(std::move(colour)) {}

    /// Loads the picture of every slide of `scene` that names a file, and forgets pictures of the previous frame that
    /// this one does not use. A guarded load calls `checkpoint` while it waits. Throws Error(input) "scene.toml:12:18:
    /// light 'key': ...".
    void loadInto(Scene& scene, const LoadOptions& load, const MessageSink& messages, const Checkpoint& checkpoint);

    /// Memory of the pictures.
    std::size_t bytes() const;

  private:
    using Key = std::pair<std::string, std::string>;  // file and colour space

    ColourConfig m_colour;
    std::map<Key, std::shared_ptr<const Texture>> m_images;
    std::map<Key, std::shared_ptr<const SkyParts>> m_skies;  // of domes
};

}  // namespace scrim
