// SPDX-License-Identifier: Apache-2.0
// The pictures of lights' slides and of the preview's backplate, and the profiles of luminaires.
// They are read once and kept as long as the next frame shows them, too.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/image/clear_sky.h>
#include <scrim/image/colour.h>
#include <scrim/image/light_profile.h>
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

    /// Loads the picture of every slide and of the backplate, and the profile of every luminaire of `scene` that names
    /// a file, makes the pictures of clear skies, and forgets those of the previous frame that this one does not use. A
    /// guarded load calls `checkpoint` while it waits. Throws Error(input) "scene.toml:12:18: light 'key': ...".
    void loadInto(Scene& scene, const LoadOptions& load, const MessageSink& messages, const Checkpoint& checkpoint);

    /// Memory of all of them.
    std::size_t bytes() const;

  private:
    using Key = std::pair<std::string, std::string>;  // file and colour space

    void loadPictures(Scene& scene, const LoadOptions& load, const MessageSink& messages, const Checkpoint& checkpoint);
    /// Makes the pictures of computed skies; one that the previous frame had is kept.
    void makeSkies(Scene& scene);
    void loadProfiles(Scene& scene, const LoadOptions& load, const Checkpoint& checkpoint);

    ColourConfig m_colour;
    std::map<Key, std::shared_ptr<const Texture>> m_images;
    std::map<Key, std::shared_ptr<const SkyParts>> m_skies;  // of domes
    std::map<ClearSky, SkyPicture> m_made;
    std::map<std::string, std::shared_ptr<const LightProfile>> m_profiles;  // by file
};

}  // namespace scrim
