// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/slide_store.h>

#include <scrim/base/error.h>
#include <scrim/image/texture_read.h>
#include <scrim/guard/load_fields.h>

#include <fmt/format.h>

#include <utility>

namespace scrim {
namespace {

/// True if the slide must be loaded; slides that were made in code have their pictures already.
bool hasFile(const Light& light) {
    return light.slide && !light.slide->file.empty();
}

std::shared_ptr<const Texture> read(const Slide& slide, const ColourConfig& colour, const LoadOptions& load,
                                    const MessageSink& messages, const Checkpoint& checkpoint) {
    return textureOf(readPicture(slide.file, load, checkpoint), slide.file, slide.colorspace, colour, messages);
}

// Runs `load`, and puts the place in the scene and the light in front of its error.
template <typename Load>
auto located(const std::string& where, const Light& light, const Load& load) {
    try {
        return load();
    } catch (const Error& error) {
        if (error.kind() == ErrorKind::interrupted) throw;
        const std::string place = where.empty() ? "" : where + ": ";
        throw Error(error.kind(), fmt::format("{}light '{}': {}", place, light.name, error.what()));
    }
}

}  // namespace

void SlideStore::loadInto(Scene& scene, const LoadOptions& load, const MessageSink& messages,
                          const Checkpoint& checkpoint) {
    loadSlides(scene, load, messages, checkpoint);
    loadProfiles(scene, load, checkpoint);
}

void SlideStore::loadProfiles(Scene& scene, const LoadOptions& load, const Checkpoint& checkpoint) {
    auto before = std::exchange(m_profiles, {});
    for (Light& light : scene.lights) {
        if (!light.luminaire || light.luminaire->file.empty()) continue;
        std::shared_ptr<const LightProfile>& profile = m_profiles[light.luminaire->file];
        if (!profile) profile = before[light.luminaire->file];
        if (!profile)
            profile = located(light.luminaire->where, light, [&] {
                return std::make_shared<const LightProfile>(loadPhotometry(light.luminaire->file, load, checkpoint));
            });
        light.luminaire->profile = profile;
    }
}

void SlideStore::loadSlides(Scene& scene, const LoadOptions& load, const MessageSink& messages,
                            const Checkpoint& checkpoint) {
    // Only pictures of this frame are kept, so that those of two frames need never be in memory together.
    std::map<Key, std::shared_ptr<const Texture>> before;
    before.swap(m_images);
    for (const Light& light : scene.lights) {
        if (!hasFile(light)) continue;
        const Key key{light.slide->file, light.slide->colorspace};
        if (const auto known = before.find(key); known != before.end()) m_images.insert(*known);
    }
    before.clear();
    std::erase_if(m_skies, [&](const auto& sky) { return m_images.count(sky.first) == 0; });
    for (Light& light : scene.lights) {
        if (!hasFile(light)) continue;
        Slide& slide = *light.slide;
        std::shared_ptr<const Texture>& image = m_images[{slide.file, slide.colorspace}];
        if (!image)
            image = located(slide.where, light, [&] { return read(slide, m_colour, load, messages, checkpoint); });
        slide.image = image;
        if (!light.dome() || !slide.split) continue;
        std::shared_ptr<const SkyParts>& parts = m_skies[{slide.file, slide.colorspace}];
        if (!parts) parts = std::make_shared<const SkyParts>(skyParts(*image));
        slide.parts = parts;
    }
}

std::size_t SlideStore::bytes() const {
    std::size_t sum = 0;
    for (const auto& [key, image] : m_images) sum += image ? image->bytes() : 0;
    for (const auto& [key, sky] : m_skies) sum += sky && sky->smooth ? sky->smooth->bytes() : 0;
    for (const auto& [file, profile] : m_profiles) sum += profile ? profile->bytes() : 0;
    return sum;
}

}  // namespace scrim
