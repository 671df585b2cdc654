// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/slide_store.h>

#include <scrim/base/error.h>
#include <scrim/image/texture_read.h>
#include <scrim/guard/load_fields.h>

#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

namespace scrim {
namespace {

std::string ownerOf(const Light& light) {
    return fmt::format("light '{}'", light.name);
}

/// A picture of a scene, and whose it is.
struct Owned {
    Slide* picture;
    std::string owner;
    bool sky;  ///< its suns are looked for
};

/// The pictures that must be loaded; slides that were made in code have theirs already.
std::vector<Owned> picturesOf(Scene& scene) {
    std::vector<Owned> all;
    for (Light& light : scene.lights)
        if (light.slide && !light.slide->file.empty())
            all.push_back({&*light.slide, ownerOf(light), light.dome() && light.slide->split});
    if (auto& plate = scene.output.preview.backplate; plate && !plate->file.empty())
        all.push_back({&*plate, "the backplate of the preview", false});
    return all;
}

std::shared_ptr<const Texture> read(const Slide& slide, const ColourConfig& colour, const LoadOptions& load,
                                    const MessageSink& messages, const Checkpoint& checkpoint) {
    return textureOf(readPicture(slide.file, load, checkpoint), slide.file, slide.colorspace, colour, messages);
}

// Runs `load`, and puts the place in the scene and the owner in front of its error.
template <typename Load>
auto located(const std::string& where, const std::string& owner, const Load& load) {
    try {
        return load();
    } catch (const Error& error) {
        if (error.kind() == ErrorKind::interrupted) throw;
        const std::string place = where.empty() ? "" : where + ": ";
        throw Error(error.kind(), fmt::format("{}{}: {}", place, owner, error.what()));
    }
}

}  // namespace

void SlideStore::loadInto(Scene& scene, const LoadOptions& load, const MessageSink& messages,
                          const Checkpoint& checkpoint) {
    loadPictures(scene, load, messages, checkpoint);
    makeSkies(scene);
    loadProfiles(scene, load, checkpoint);
}

void SlideStore::makeSkies(Scene& scene) {
    auto before = std::exchange(m_made, {});
    for (Light& light : scene.lights) {
        if (!light.slide || !light.slide->sky) continue;
        const ClearSky& sky = *light.slide->sky;
        SkyPicture& picture = m_made[sky];
        if (!picture.image) picture = before[sky];
        if (!picture.image)
            picture = located(light.slide->where, ownerOf(light), [&] { return skyPicture(sky, m_colour); });
        light.slide->image = picture.image;
        light.slide->parts = picture.parts;
    }
}

void SlideStore::loadProfiles(Scene& scene, const LoadOptions& load, const Checkpoint& checkpoint) {
    auto before = std::exchange(m_profiles, {});
    for (Light& light : scene.lights) {
        if (!light.luminaire || light.luminaire->file.empty()) continue;
        std::shared_ptr<const LightProfile>& profile = m_profiles[light.luminaire->file];
        if (!profile) profile = before[light.luminaire->file];
        if (!profile)
            profile = located(light.luminaire->where, ownerOf(light), [&] {
                return std::make_shared<const LightProfile>(loadPhotometry(light.luminaire->file, load, checkpoint));
            });
        light.luminaire->profile = profile;
    }
}

void SlideStore::loadPictures(Scene& scene, const LoadOptions& load, const MessageSink& messages,
                              const Checkpoint& checkpoint) {
    // Only pictures of this frame are kept, so that those of two frames need never be in memory together.
    std::map<Key, std::shared_ptr<const Texture>> before;
    before.swap(m_images);
    const std::vector<Owned> pictures = picturesOf(scene);
    for (const Owned& owned : pictures)
        if (const auto known = before.find({owned.picture->file, owned.picture->colorspace}); known != before.end())
            m_images.insert(*known);
    before.clear();
    std::erase_if(m_skies, [&](const auto& sky) { return m_images.count(sky.first) == 0; });
    for (const auto& [slide, owner, sky] : pictures) {
        const Key key{slide->file, slide->colorspace};
        std::shared_ptr<const Texture>& image = m_images[key];
        if (!image)
            image = located(slide->where, owner, [&] { return read(*slide, m_colour, load, messages, checkpoint); });
        slide->image = image;
        if (!sky) continue;
        std::shared_ptr<const SkyParts>& parts = m_skies[key];
        if (!parts) parts = std::make_shared<const SkyParts>(skyParts(*image));
        slide->parts = parts;
    }
}

std::size_t SlideStore::bytes() const {
    std::size_t sum = 0;
    for (const auto& [key, image] : m_images) sum += image ? image->bytes() : 0;
    for (const auto& [key, sky] : m_skies) sum += sky && sky->smooth ? sky->smooth->bytes() : 0;
    for (const auto& [sky, picture] : m_made) sum += picture.image ? picture.image->bytes() : 0;
    for (const auto& [file, profile] : m_profiles) sum += profile ? profile->bytes() : 0;
    return sum;
}

}  // namespace scrim
