// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/bake_shot.h>

#include <scrim/base/percent.h>
#include <scrim/base/error.h>
#include <scrim/base/finite.h>
#include <scrim/base/parallel.h>
#include <scrim/base/system_error.h>
#include <scrim/base/version.h>
#include <scrim/engine/baked_light.h>
#include <scrim/engine/plan/make_plan.h>
#include <scrim/scene/field_rays.h>
#include <scrim/scene/layer_names.h>
#include <scrim/scene/nearest_name.h>
#include <scrim/shot/shot_content.h>
#include <scrim/volume/grid_edit.h>

#include <algorithm>
#include <map>

#include <fmt/format.h>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

const char* const kIrradiance =
    "irradiance times transmittance; a distant light of intensity 1 gives 1 where nothing is in its way";
const char* const kScattered = "radiance per world unit, scattered evenly to all sides";
const char* const kRadiance = "mean over all directions of the radiance of light that has scattered before";
const char* const kFlux = "mean over all directions of that radiance times the direction of travel in world space";
const char* const kExtinction = "extinction per world unit";

std::string placed(const Scene& scene, const std::string& key) {
    const std::string where = scene.lines ? scene.lines->of(key) : "";
    return where.empty() ? where : where + ": ";
}

// True if no light, no glow and no medium makes scattered light coloured.
bool scattersGrey(const ViewScene& view) {
    if (!greyScattering(view) || !isGrey(view.ambient)) return false;
    for (const Light& light : view.lights)
        if (!isGrey(light.intensity) || light.slide) return false;
    for (const ViewVolume& volume : view.volumes)
        for (const ViewEmission& emission : volume.emission)
            if (!isGrey(emission.color)) return false;
    return true;
}

// Something scatters more than once, or there is no indirect light to bake.
void checkIndirect(const Scene& scene) {
    if (std::ranges::any_of(scene.volumes, [](const SceneVolume& volume) { return volume.scattersFully(); })) return;
    const SceneVolume* first = scene.volumes.empty() ? nullptr : &scene.volumes.front();
    throw Error(
        ErrorKind::input,
        fmt::format("{}: --indirect: light scatters once in all volumes; expected one with "
                    "scattering = \"full\", for example by --set 'volume.{}.{}.scattering=full'",
                    scene.file, first ? first->name : "NAME", first && first->classified ? "classified" : "medium"));
}

// For each light of the scene, whether the request names it.
std::vector<bool> wantedLights(const Scene& scene, const BakeRequest& request) {
    if (scene.lights.empty())
        throw Error(ErrorKind::input,
                    fmt::format("{}: there is no light to bake; add a [[light]] to the scene", scene.file));
    std::vector<std::string> names;
    for (const Light& light : scene.lights) names.push_back(light.name);
    std::vector<bool> wanted(names.size(), request.lights.empty());
    for (const std::string& name : request.lights) {
        const auto found = std::find(names.begin(), names.end(), name);
        if (found == names.end())
            throw Error(ErrorKind::usage, fmt::format("there is no light '{}' to bake{}; expected {}",
                                                      shortened(name, 80), didYouMean(name, names), choices(names)));
        wanted[std::size_t(found - names.begin())] = true;
    }
    return wanted;
}

Mat3 outputFromWorking(const Scene& scene, const ColourConfig& colour) {
    try {
        return glm::inverse(colour.workingFrom(scene.output.colorspace));
    } catch (const Error& error) {
        throw Error(error.kind(), placed(scene, "output.colorspace") + error.what());
    }
}

class GridMaker {
  public:
    GridMaker(const Scene& scene, const ViewScene& view, const Mat3& outputFromWorking, std::string space)
        : m_scene(scene),
          m_outputFromWorking(outputFromWorking),
          m_space(std::move(space)),
          m_coloured(!greyExtinction(view)),
          m_scattersGrey(scattersGrey(view)) {}

    // `baked` is null where the volume shows nothing; its grids are then empty.
    void addVolume(std::size_t volume, const ViewVolume* view, const BakedVolume* baked,
                   const std::vector<bool>& wanted, const BakeRequest& request);
    std::vector<VdbGrid> take() { return std::move(m_grids); }

  private:
    VdbGrid& add(std::size_t volume, const std::string& name, const std::string& of, const BakedVolume* baked);
    void setColours(VdbGrid& grid, std::vector<float> values, bool grey) const;
    void addIndirect(std::size_t volume, const BakedVolume* baked, bool grey);
    void addExtinction(std::size_t volume, const ViewVolume* view, const BakedVolume* baked);

    const Scene& m_scene;
    Mat3 m_outputFromWorking;
    std::string m_space;
    bool m_coloured, m_scattersGrey;  // extinction has colours; all light that scatters is grey
    std::vector<VdbGrid> m_grids;
    std::map<std::string, std::string> m_names;  // grid name, and the light and volume that use it
};

VdbGrid& GridMaker::add(std::size_t volume, const std::string& name, const std::string& of, const BakedVolume* baked) {
    const SceneVolume& own = m_scene.volumes[volume];
    const std::string prefix = m_scene.volumes.size() > 1 ? channelName(own.name) + "." : "";
    VdbGrid& grid = m_grids.emplace_back();
    grid.name = prefix + channelName(name);
    const auto [known, isNew] = m_names.emplace(grid.name, of);
    if (!isNew)
        throw Error(ErrorKind::input, fmt::format("{}: {} and {} would both be the grid '{}', whose name has only "
                                                  "letters, digits and underscores; expected different names",
                                                  m_scene.file, known->second, of, grid.name));
    grid.wsFromIs = own.wsFromAsset;
    if (!baked) return grid;
    grid.blockOrigins = baked->blockOrigins;
    grid.active = baked->active;
    return grid;
}

// Grey values need no colour space.
void GridMaker::setColours(VdbGrid& grid, std::vector<float> values, bool grey) const {
    grid.colour = !grey;
    if (!grey) {
        grid.metadata.emplace_back("scrim:colorspace", m_space);
        for (std::size_t i = 0; i < values.size();
             i += (i % kBlockVoxels == kBlockVoxels - 1 ? 2 * kBlockVoxels : 0) + 1) {
            const Rgb c = m_outputFromWorking *
                          Rgb(values[i], values[i + kBlockVoxels], values[i + std::size_t{2} * kBlockVoxels]);
            for (int k = 0; k < 3; ++k) values[i + std::size_t(k) * kBlockVoxels] = static_cast<float>(c[k]);
        }
        grid.values = std::move(values);
        return;
    }
    grid.values.resize(values.size() / 3);
    for (std::size_t b = 0; b < grid.blockOrigins.size(); ++b)
        std::copy_n(values.begin() + std::ptrdiff_t(3 * b * kBlockVoxels), kBlockVoxels,
                    grid.values.begin() + std::ptrdiff_t(b * kBlockVoxels));
}

void GridMaker::addExtinction(std::size_t volume, const ViewVolume* view, const BakedVolume* baked) {
    const std::string of = fmt::format("the extinction of volume '{}'", m_scene.volumes[volume].name);
    VdbGrid& grid = add(volume, "density", of, baked);
    grid.metadata.emplace_back("scrim:unit", kExtinction);
    const Medium& medium = m_scene.volumes[volume].medium;
    grid.colour = !isGrey(medium.extinctionTint);
    if (!baked) return;
    const FieldRays field(*view->field);
    const int channels = grid.colour ? 3 : 1;
    grid.values.resize(std::size_t(channels) * kBlockVoxels * grid.blockOrigins.size());
    for (std::size_t b = 0; b < grid.blockOrigins.size(); ++b)
        for (int i = 0; i < kBlockVoxels; ++i) {
            if (!grid.active[b][std::size_t(i)]) continue;
            const Vec3 is = Vec3(grid.blockOrigins[b]) + Vec3(i / 64, i / 8 % 8, i % 8);
            const double value = view->medium.densityScale * field.value(transformPoint(view->field->wsFromIs, is));
            for (int c = 0; c < channels; ++c)
                grid.values[(b * std::size_t(channels) + std::size_t(c)) * kBlockVoxels + std::size_t(i)] =
                    static_cast<float>(value * medium.extinctionTint[c]);
        }
}

// The flux is a vector in world space for each colour. Colours are converted to the output's space, vectors are not.
void GridMaker::addIndirect(std::size_t volume, const BakedVolume* baked, bool grey) {
    const std::string of = fmt::format("the indirect light of volume '{}'", m_scene.volumes[volume].name);
    VdbGrid& mean = add(volume, "indirect", of, baked);
    mean.metadata = {{"scrim:unit", kRadiance}};
    setColours(mean, baked ? baked->indirect : std::vector<float>{}, grey);
    for (std::size_t c = 0; c < (grey ? 1 : 3); ++c) {
        VdbGrid& flux = add(volume, grey ? "indirect_flux" : fmt::format("indirect_flux_{}", "rgb"[c]), of, baked);
        flux.metadata = {{"scrim:unit", kFlux}};
        flux.colour = true;
        if (!grey) flux.metadata.emplace_back("scrim:colorspace", m_space);
        if (!baked) continue;
        flux.values.resize(baked->flux[0].size());
        for (std::size_t from = 0; from < 3; ++from) {
            const auto part = grey ? float(from == 0) : static_cast<float>(m_outputFromWorking[int(from)][int(c)]);
            for (std::size_t i = 0; i < flux.values.size(); ++i) flux.values[i] += part * baked->flux[from][i];
        }
    }
}

void GridMaker::addVolume(std::size_t volume, const ViewVolume* view, const BakedVolume* baked,
                          const std::vector<bool>& wanted, const BakeRequest& request) {
    const SceneVolume& own = m_scene.volumes[volume];
    const std::size_t first = m_grids.size();
    bool greyLights = true;
    for (std::size_t l = 0; l < m_scene.lights.size(); ++l) {
        const Light& light = m_scene.lights[l];
        const bool lit =
            !own.lights || std::find(own.lights->begin(), own.lights->end(), light.name) != own.lights->end();
        if (!wanted[l] || !lit) continue;
        const bool grey = isGrey(light.intensity) && !light.slide && !m_coloured;
        greyLights = greyLights && grey;
        VdbGrid& grid = add(volume, light.name, fmt::format("light '{}'", light.name), baked);
        grid.metadata = {{"scrim:light", light.name}, {"scrim:unit", kIrradiance}};
        setColours(grid, baked ? baked->lights[l] : std::vector<float>{}, grey);
    }
    const bool full = own.scattersFully();
    const bool grey =
        full ? m_scattersGrey
             : greyLights && isGrey(own.medium.albedo) && !own.albedoGrid && isGrey(m_scene.ambient) && !m_coloured;
    if (request.indirect && full && !own.holdout) addIndirect(volume, baked, grey);
    if (request.emission && !own.classified) {
        VdbGrid& grid = add(volume, "emission", fmt::format("the emission of volume '{}'", own.name), baked);
        grid.metadata = {{"scrim:unit", kScattered}};
        setColours(grid, baked ? baked->scattered : std::vector<float>{}, grey);
        addExtinction(volume, view, baked);
    }
    for (std::size_t g = first; g < m_grids.size(); ++g) {
        m_grids[g].metadata.emplace_back("scrim:volume", own.name);
        if (view) m_grids[g].wsFromIs = view->wsFromIs;
    }
}

void warnOfLooks(const Scene& scene, const MessageSink& messages) {
    for (const SceneVolume& volume : scene.volumes) {
        const std::string key = "volume." + volume.name;
        if (volume.classified)
            notify(messages, Severity::warning,
                   fmt::format("{}volume '{}' is classified: its reflection depends on the eye's position, so it has "
                               "no emission grid",
                               placed(scene, key), volume.name));
        else if (!volume.medium.phase.isotropic())
            notify(messages, Severity::warning,
                   fmt::format(
                       "{}volume '{}' scatters anisotropically, but its emission grid is that of isotropic scattering",
                       placed(scene, key + ".medium.phase"), volume.name));
    }
}

// Grids of light have the voxels of their volume, and not those of its detail.
void leaveOutDetail(Scene& scene, const MessageSink& messages) {
    for (SceneVolume& volume : scene.volumes) {
        if (!volume.edit || volume.edit->detail == 1) continue;
        GridEdit edit = *volume.edit;
        edit.detail = 1;
        volume.edit = std::make_shared<const GridEdit>(std::move(edit));
        notify(messages, Severity::warning,
               fmt::format("{}volume '{}': its grids of light are those without 'detail'",
                           placed(scene, "volume." + volume.name + ".detail"), volume.name));
    }
}

}  // namespace

BakedShot bakeShot(const Shot& shot, int frame, const BakeRequest& request, const RenderOptions& options) {
    Shot::Content& content = *shot.m_content;
    BakedShot out;
    const auto bake = [&] {
        // What a text says wrongly is refused before its reader's warnings, which are about pictures.
        if (content.text) outputFromWorking(content.sceneUnframed(frame), content.stores->colour);
        Scene scene = withOptions(content.sceneAt(frame, options), options, *content.stores);
        leaveOutDetail(scene, options.messages);
        const std::vector<bool> wanted = wantedLights(scene, request);
        const std::string space = scene.output.colorspace;
        const Mat3 toOutput = outputFromWorking(scene, content.stores->colour);
        if (request.emission) warnOfLooks(scene, options.messages);
        if (request.indirect) checkIndirect(scene);
        content.keepPromise(scene, options, ShotUse::render);
        const auto loaded = content.loadOnce(std::move(scene), options, VolumesOf::scene, ShotUse::render);
        out.skipped = !loaded;
        if (!loaded) return;
        const ViewScene view = loaded->view(options, 0, VolumesOf::scene);
        const std::vector<BakedVolume> baked =
            bakeLight(view, wanted, request.emission, request.indirect, threadCount(), options.progress);
        const std::string id = content.stores->colour.interopId(space);
        GridMaker maker(loaded->scene, view, toOutput, id.empty() ? space : id);
        for (std::size_t v = 0; v < loaded->scene.volumes.size(); ++v) {
            const std::string& name = loaded->scene.volumes[v].name;
            const auto shown = std::find_if(view.volumes.begin(), view.volumes.end(),
                                            [&](const ViewVolume& volume) { return volume.name == name; });
            const bool isThere = shown != view.volumes.end() && !shown->field->empty();
            const BakedVolume* const own = isThere ? &baked[std::size_t(shown - view.volumes.begin())] : nullptr;
            if (!isThere)
                notify(options.messages, Severity::warning,
                       fmt::format("frame {}: volume '{}' has no density; its grids are empty", frame, name));
            if (own && own->iterationError > 0)
                notify(options.messages, Severity::warning,
                       fmt::format("frame {}: volume '{}': scattered light has not converged: further sweeps would "
                                   "change it by about {} %",
                                   frame, name, percentText(own->iterationError)));
            maker.addVolume(v, isThere ? &*shown : nullptr, own, wanted, request);
        }
        out.grids = maker.take();
        for (const VdbGrid& grid : out.grids)
            if (!allFinite(grid.values))
                throw Error(ErrorKind::render,
                            fmt::format("frame {}: the grid '{}' contains infinite or NaN values, so nothing is "
                                        "written; is a light brighter than floats can hold?",
                                        frame, grid.name));
        out.metadata = {{"scrim:version", scrimVersion()},
                        {"scrim:frame", fmt::format("{}", frame)},
                        {"scrim:scene", content.text ? content.text->toml({}) : std::string()}};
    };
    withErrors([&] { TaskArena(options.threads).run(bake); });
    return out;
}

}  // namespace scrim
