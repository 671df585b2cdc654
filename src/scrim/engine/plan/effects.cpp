// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/plan/effects.h>

#include <scrim/base/error.h>
#include <scrim/engine/plan/transport_plan.h>
#include <scrim/engine/solve/scatter_domains.h>
#include <scrim/engine/solve/scattered_light.h>
#include <scrim/image/sky_parts.h>
#include <scrim/scene/layer_names.h>

#include <algorithm>
#include <functional>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace scrim {
namespace {

// Collects the lights or volumes that have or lack a property, and the places where the scene sets it.
class Finder {
  public:
    explicit Finder(const ViewScene& scene) : m_scene(scene) {}

    void add(const std::string& text, const std::string& path) {
        m_texts.push_back(text);
        addPlace(path);
    }
    void addPlace(const std::string& path) {
        if (!m_scene.lines) return;
        if (const std::string where = m_scene.lines->of(path); !where.empty()) m_where.push_back(where);
    }
    bool any() const { return !m_texts.empty(); }
    std::string texts() const {
        constexpr std::size_t kMostNamed = 12;  // nobody reads a list of thousands of lights
        const auto end = m_texts.begin() + static_cast<std::ptrdiff_t>(std::min(m_texts.size(), kMostNamed));
        const std::string more =
            m_texts.size() > kMostNamed ? fmt::format(" and {} more", m_texts.size() - kMostNamed) : "";
        return fmt::format("{}{}", fmt::join(m_texts.begin(), end, ", "), more);
    }

    /// The effect is on if anything was found, with the reason "`before` a, b"; otherwise off with
    /// the reason `otherwise`.
    Effect effect(const std::string& name, const std::string& before, const std::string& otherwise) const {
        if (!any()) return {name, false, otherwise, {}};
        return {name, true, before + texts(), m_where};
    }
    const std::vector<std::string>& where() const { return m_where; }

  private:
    const ViewScene& m_scene;
    std::vector<std::string> m_texts, m_where;
};

std::string quoted(const std::string& name) {
    return "'" + name + "'";
}

// The name of a light or volume that has a property; otherwise nothing.
std::string nameIf(bool has, const std::string& name) {
    return has ? quoted(name) : std::string();
}

// Finds the lights of the plan that are not culled, or the volumes, for which say() returns a text.
template <class Say>
Finder lightsThat(const ViewScene& scene, const Plan& plan, const std::string& key, const Say& say) {
    Finder found(scene);
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        if (i < plan.culledLights.size() && !plan.culledLights[i].empty()) continue;
        const Light& light = scene.lights[i];
        if (const std::string text = say(light); !text.empty()) found.add(text, "light." + light.name + key);
    }
    return found;
}
template <class Say>
Finder volumesThat(const ViewScene& scene, const std::string& key, const Say& say) {
    Finder found(scene);
    for (const ViewVolume& volume : scene.volumes)
        if (const std::string text = say(volume); !text.empty()) found.add(text, "volume." + volume.name + key);
    return found;
}

Effect shadows(const ViewScene& scene, const Plan& plan) {
    if (scene.lights.empty()) return {"shadows", false, "there are no lights", {}};
    const Finder with = lightsThat(scene, plan, "", [](const Light& l) { return nameIf(l.shadows, l.name); });
    const Finder without =
        lightsThat(scene, plan, ".shadows", [](const Light& l) { return nameIf(!l.shadows, l.name); });
    Effect effect =
        with.effect("shadows", "of ", without.any() ? "every light has shadows = false" : "no light is used");
    if (without.any()) {
        if (effect.on) effect.reason += fmt::format("; not of {}: shadows = false", without.texts());
        effect.where = without.where();
    }
    if (const std::string coarser = coarserRasters(scene, plan); !coarser.empty())
        effect.reason += fmt::format("; cells of their rasters are larger than shadow_texel says: {}", coarser);
    return effect;
}

Effect slides(const ViewScene& scene, const Plan& plan) {
    const auto has = [](const Light& light) { return light.slide && !light.slide->sky; };
    const bool any = std::ranges::any_of(scene.lights, has);
    return lightsThat(scene, plan, ".slide", [&](const Light& light) { return nameIf(has(light), light.name); })
        .effect("slides", "of ", any ? "every light with a slide is culled" : "no light has a slide");
}

// The effect of solids with a role.
Effect solids(const ViewScene& scene, SolidRole role, const std::string& name, const std::string& key,
              const std::string& otherwise) {
    Finder found(scene);
    if (scene.solids)
        for (const Solid& solid : scene.solids->all())
            if (solid.has(role))
                found.add(quoted(solid.name),
                          solid.light ? "light." + solid.name + ".visible" : "mesh." + solid.name + key);
    return found.effect(name, "of ", otherwise);
}

Effect backdrop(const ViewScene& scene) {
    Finder found(scene);
    for (const Light& light : scene.lights)
        if (light.visible) found.add(quoted(light.name), "light." + light.name + ".visible");
    if (scene.solids)
        for (const Solid& solid : scene.solids->all())
            if (solid.color) found.add(quoted(solid.name), "mesh." + solid.name + ".color");
    return found.effect("backdrop", "of ", "no light is visible, and no mesh has a color");
}

Effect heldVolumes(const ViewScene& scene) {
    return volumesThat(scene, ".holdout", [](const ViewVolume& v) { return nameIf(v.holdout, v.name); })
        .effect("volumes held out", "", "every volume is seen");
}

Effect depthPicture(const ViewScene& scene) {
    Finder found(scene);
    if (scene.depths)
        found.add(scene.depths->thin ? "it is deep: samples hide by their alpha" : "rays end at its depths",
                  "output.holdout");
    return found.effect("depths of a picture", "", "[output] has no holdout");
}

std::string extent(const Light& light) {
    if (light.dome())
        return !light.slide ? "a dome" : light.slide->sky ? "a dome with a clear sky" : "a dome with a picture";
    if (!light.area()) return fmt::format("a sun of {:.3g} degrees", std::get<Light::Distant>(light.kind).angle);
    constexpr const char* kShapes[] = {"a rectangle", "a disk", "a sphere", "a cylinder", "a mesh"};
    return kShapes[std::size_t(light.area()->shape)];
}

// " and 2 suns in its picture of 0.53 and 1.2 degrees"
std::string sunsText(const SkyParts& parts) {
    std::vector<std::string> angles;
    for (const SkySun& sun : parts.suns) angles.push_back(fmt::format("{:.2g}", sun.angle));
    if (!parts.suns.front().rows.empty()) return fmt::format(" and a sun of {} degrees", angles.front());
    return fmt::format(" and {} sun{} in its picture, of {} degrees", angles.size(), angles.size() == 1 ? "" : "s",
                       fmt::join(angles, ", "));
}

Effect extendedLights(const ViewScene& scene, const Plan& plan) {
    const auto say = [&](const Light& light) {
        if (!light.extended()) return std::string();
        const auto i = static_cast<std::size_t>(&light - scene.lights.data());
        const bool cells = plan.cellLights.has(i);
        const int count = cells ? pointsOnCells(scene, light) : plan.subLights.countOf(static_cast<int>(i));
        const std::string what = fmt::format("{} ({}): {}", quoted(light.name), extent(light), count);
        std::string text = cells ? fmt::format("{} {} on cells", what, light.area() ? "points" : "directions")
                                 : fmt::format("{} sub-light{}", what, count == 1 ? "" : "s");
        if (light.dome() && light.slide && light.slide->parts && !light.slide->parts->suns.empty())
            text += sunsText(*light.slide->parts);
        return text;
    };
    const bool any = std::ranges::any_of(scene.lights, &Light::extended);
    const char* none = any ? "every extended light is culled" : "every light shines from one point or direction";
    Effect effect = lightsThat(scene, plan, "", say).effect("extended lights", "", none);
    if (effect.on && !plan.cellLights.unfit.empty())
        effect.reason += fmt::format("; shadow buffers for each, since {}", plan.cellLights.unfit);
    return effect;
}

Effect lightsOnCells(const ViewScene& scene, const Plan& plan) {
    Finder found(scene);
    int lamps = 0;
    for (std::size_t i = 0; i < plan.cellLights.lights.size(); ++i) {
        const Light& light = scene.lights[std::size_t(plan.cellLights.lights[i])];
        lamps += isLampOnCells(scene, light) ? 1 : 0;
        const char* why = light.shadow == ShadowMethod::cells ? "the scene sets it"
                          : light.extended()                  ? "it shines from many places"
                                                              : "it is among the volumes";
        std::vector<std::string> edges;
        for (const CellLevel& level : plan.cellLights.levels)
            edges.push_back(fmt::format("{:.3g}", level.edges[i] / plan.voxel));
        found.add(fmt::format("{}: {}, cells of {} voxels", quoted(light.name), why, fmt::join(edges, ", ")),
                  "light." + light.name);
    }
    Effect effect = found.effect("lights on cells", "", "shadow buffers serve every light");
    if (lamps > 0 && lampsShareCells(scene))
        effect.reason += fmt::format("; {} lamps share cells, and have their own only near them", lamps);
    for (const CellLevel& level : plan.cellLights.levels)
        if (level.coarser > 1)
            effect.reason += fmt::format(
                "; cells of {:.3g} voxels are {:.2g} times as large as they should be, which "
                "would take too much memory, and blur shadows",
                level.smallest() / plan.voxel, level.coarser);
    if (effect.on) effect.reason += setsText(scene, plan.cellLights) + "; about " + bytesText(plan.cellLights.bytes);
    return effect;
}

Effect culledLights(const ViewScene& scene, const Plan& plan) {
    Finder found(scene);
    for (std::size_t i = 0; i < plan.culledLights.size(); ++i)
        if (!plan.culledLights[i].empty())
            found.add(fmt::format("{}: {}", quoted(scene.lights[i].name), plan.culledLights[i]),
                      "light." + scene.lights[i].name);
    return found.effect("lights culled", "", "every light lights something in view");
}

Effect culledVolumes(const ViewScene& scene) {
    Finder found(scene);
    for (const auto& [name, reason] : scene.culled)
        found.add(fmt::format("{}: {}", quoted(name), reason), "volume." + name);
    return found.effect("volumes culled", "", "every volume is in view or casts a shadow into it");
}

Effect surfaces(const ViewScene& scene) {
    return volumesThat(scene, ".classified", [](const ViewVolume& v) { return nameIf(bool(v.classified), v.name); })
        .effect("surfaces", "gradients and a transfer function of ",
                "no volume is classified: no gradients, no transfer function");
}

// An effect of media; classified volumes have none of these.
template <class Say>
Effect ofMedia(const ViewScene& scene, const std::string& key, const Say& say, const std::string& name,
               const std::string& before, const std::string& otherwise) {
    return volumesThat(scene, key,
                       [&](const ViewVolume& v) { return v.classified ? std::string() : std::string(say(v)); })
        .effect(name, before, otherwise);
}

std::string phaseName(const Phase& phase) {
    if (phase.isotropic()) return "";
    if (phase.type == PhaseType::twoLobe) return phase.alpha > 0 ? "Draine" : "two lobes";
    return phase.type == PhaseType::rayleigh ? "Rayleigh" : fmt::format("g = {}", phase.g);
}

Effect emission(const ViewScene& scene) {
    Finder found(scene);
    const bool lights = anyScattersFully(scene);
    for (const ViewVolume& volume : scene.volumes) {
        if (volume.emission.empty()) continue;
        const std::string medium = "volume." + volume.name + ".medium.";
        found.add(fmt::format("{}: {} field{}{}", quoted(volume.name), volume.emission.size(),
                              volume.emission.size() > 1 ? "s" : "", lights ? "" : ", which light nothing else"),
                  medium + "emission");
        found.addPlace(medium + "blackbody");
    }
    return found.effect("emission", "of ", "no medium has emission or blackbody");
}

// The parts of space in which scattered light would be solved for if no solid stopped it.
std::size_t partsWithoutSolids(ViewScene scene) {
    scene.solids = nullptr;
    return scatterDomains(scene, scene.dials.scatterCell.value_or(kScatterCell)).size();
}

Effect multipleScattering(const ViewScene& scene, const Plan& plan) {
    Finder found(scene);
    for (const ViewVolume& v : scene.volumes)
        if (const char* kind = v.classified ? "classified" : "medium"; scattersFully(v))
            found.add(quoted(v.name), fmt::format("volume.{}.{}.scattering", v.name, kind));
    Effect out = found.effect("multiple scattering", "in ", "no volume has scattering = \"full\": light scatters once");
    const TransportPlan& t = plan.transport;
    const std::size_t solves = solvesOf(scene, t);
    if (out.on) {
        std::vector<std::string> edges;  // of all domains, each once
        for (const ScatterDomain& domain : t.domains)
            if (std::string edge = fmt::format("{:.4g}", domain.edge); std::ranges::find(edges, edge) == edges.end())
                edges.push_back(std::move(edge));
        out.reason += fmt::format("; {} solve{} along {} directions, cells of {} world units, about {}", solves,
                                  solves == 1 ? "" : "s", t.ordinates, fmt::join(edges, ", "), bytesText(t.bytes));
        if (t.domains.size() > 1)
            out.reason +=
                fmt::format("; each solve in {} parts of space, for voxels of their own size", t.domains.size());
        else if (const std::size_t parts = scene.solids ? partsWithoutSolids(scene) : 1; parts > 1)
            out.reason += fmt::format(
                "; all space has cells for the smallest voxels, since meshes stop this light: {} parts of space would "
                "have their own without them",
                parts);
    }
    if (const std::string skies = blurredSkies(scene, t); !skies.empty()) out.reason += "; " + skies;
    if (out.on && solidsBlock(scene))
        for (const Solid& solid : scene.solids->all())
            if (solid.shadows)
                out.reason += fmt::format("; mesh {} stops this light{}", quoted(solid.name),
                                          solid.sendsBack() ? " and sends part of it back" : "");
    return out;
}

void addMediumEffects(const ViewScene& scene, const Plan& plan, std::vector<Effect>& effects) {
    Effect tints = ofMedia(
        scene, ".medium.extinction_tint",
        [](const ViewVolume& v) { return nameIf(v.medium.relativeTint() != Rgb(1), v.name); }, "coloured extinction",
        "of ", "every extinction_tint is grey: one optical depth for all channels");
    if (tints.on)
        tints.reason +=
            fmt::format("; {} extinction channel{}", plan.extinction.count(), plan.extinction.count() > 1 ? "s" : "");
    effects.push_back(tints);
    effects.push_back(ofMedia(
        scene, ".medium.albedo.grid",
        [](const ViewVolume& v) { return v.scatter.empty() ? "" : quoted(v.name) + ": three more fields"; },
        "albedo grids", "of ", "every albedo is one colour"));
    effects.push_back(emission(scene));
    effects.push_back(ofMedia(
        scene, ".medium.phase",
        [](const ViewVolume& v) {
            const std::string name = phaseName(v.medium.phase);
            return name.empty() ? name : fmt::format("{} ({})", quoted(v.name), name);
        },
        "directional scattering", "of ", "every phase function is isotropic"));
    Effect octaves = ofMedia(
        scene, ".medium.octaves",
        [](const ViewVolume& v) {
            const int count = v.medium.octaves.count;
            return count > 1 ? fmt::format("{} ({})", quoted(v.name), count) : std::string();
        },
        "octaves", "of ", "no medium has octaves");
    // Measured on a cloud of 0.4 M voxels under a dome: 8 octaves take 10 times as long as the full solution.
    if (octaves.on && std::ranges::any_of(scene.lights, &Light::dome))
        octaves.reason += "; scattering = \"full\" is the light itself and, under a dome, takes less time";
    effects.push_back(std::move(octaves));
    effects.push_back(multipleScattering(scene, plan));
}

// What links lights to volumes: `lights` holds those of a volume, or nothing for all.
Effect linking(const ViewScene& scene, const char* key, std::vector<bool> ViewVolume::*lights, const std::string& name,
               const std::string& verb, const std::string& none) {
    const auto linked = [&](const ViewVolume& v) {
        const std::vector<bool>& of = v.*lights;
        const auto count = std::count(of.begin(), of.end(), true);
        return of.empty() ? "" : fmt::format("{} {} {} of {} lights", quoted(v.name), verb, count, of.size());
    };
    return volumesThat(scene, key, linked).effect(name, "", none);
}

Effect crossFade(const ViewScene& scene, const Plan& plan) {
    for (const GroupPlan& group : plan.groups)
        for (const PlannedLight& light : group.lights)
            if (light.share < 1) {
                const std::string reason = fmt::format(
                    "light '{}' is within {} degrees of perpendicular to the eye, and swept from both sides",
                    ownerOf(scene, plan, light.light).name, scene.dials.crossFade.value_or(kCrossFade));
                return {"cross-fade", true, reason, {}};
            }
    if (scene.dials.crossFade == 0.0) return {"cross-fade", false, "nothing moves, or the dial is 0", {}};
    return {"cross-fade", false, "no light is perpendicular to the eye", {}};
}

Effect layers(const ViewScene& scene) {
    Finder found(scene);
    for (const Layer layer : scene.layers) found.add(nameOf(layer), "output.layers");
    Effect effect = found.effect("layers", "", "no layers are requested");
    if (effect.where.size() > 1) effect.where.resize(1);
    return effect;
}

Effect deepPicture(const ViewScene& scene) {
    Finder found(scene);
    if (scene.deep)
        found.add(scene.deep->tolerance > 0 ? fmt::format("samples merged within {:g}", scene.deep->tolerance)
                                            : "a sample for every sheet",
                  "output.deep");
    return found.effect("deep picture", "", "none is requested");
}

Effect motionBlur(const ViewScene& scene) {
    if (!scene.shutter) return {"motion blur", false, "[camera] has no shutter", {}};
    Finder found(scene);
    found.addPlace("camera.shutter");
    const ViewShutter& s = *scene.shutter;
    if (!s.moves) return {"motion blur", false, "nothing moves while the shutter is open", found.where()};
    return {"motion blur", true,
            fmt::format("{} render{} of the frame while the shutter is open, from {:g} to {:g} frames; the longest "
                        "motion is {:.3g} pixels",
                        s.samples, s.samples == 1 ? "" : "s", s.open, s.close, s.path),
            found.where()};
}

Effect depthOfField(const ViewScene& scene) {
    if (!scene.lens) return {"depth of field", false, "[camera] has neither fstop nor lens_radius", {}};
    Finder found(scene);
    for (const char* key : {"camera.fstop", "camera.lens_radius", "camera.focus_distance"}) found.addPlace(key);
    const ViewLens& l = *scene.lens;
    return {"depth of field", true,
            fmt::format("{} render{} from places on a lens of radius {:.3g}, sharp at {:.4g}; a point is blurred to "
                        "{:.3g} pixels at most",
                        l.samples, l.samples == 1 ? "" : "s", l.lens.radius, l.lens.focus, l.blur),
            found.where()};
}

// An effect that one key of [render] decides.
Effect ofDial(const ViewScene& scene, const std::string& name, const std::string& key, bool on,
              const std::string& reason) {
    Finder found(scene);
    found.add(reason, key);
    return {name, on, reason, found.where()};
}

Effect culledTiles(const Plan& plan) {
    double needed = 0, all = 0;
    for (const GroupPlan& group : plan.groups) {
        const double tiles = double(group.sheets.tilesX()) * group.sheets.tilesY() * group.sheets.count;
        needed += group.needed.share(group.sheets) * tiles;
        all += tiles;
    }
    if (all == 0 || plan.perView) return {"tiles culled", false, "every sheet is the view's own", {}};
    const bool some = needed < 0.999 * all;
    const std::string part =
        fmt::format("{:.0f} % of all: neither eye nor light passes them", 100 * (1 - needed / all));
    return {"tiles culled", some, some ? part : "eye or light may pass all of them", {}};
}

}  // namespace

std::string coarserRasters(const ViewScene& scene, const Plan& plan) {
    constexpr double kClearly = 1.05;
    std::vector<double> most(scene.lights.size(), 1);
    for (const GroupPlan& group : plan.groups)
        for (const PlannedLight& light : group.lights) {
            double& own = most[std::size_t(plan.subLights.ownerOf(light.light))];
            if (light.shadowed) own = std::max(own, light.coarser);
        }
    Finder found(scene);
    for (std::size_t i = 0; i < most.size(); ++i)
        if (most[i] > kClearly) found.add(fmt::format("{} {:.2g} times", quoted(scene.lights[i].name), most[i]), "");
    return found.texts();
}

std::vector<Effect> effectsOf(const ViewScene& scene, const Plan& plan) {
    std::vector<Effect> effects{shadows(scene, plan), extendedLights(scene, plan), slides(scene, plan),
                                surfaces(scene)};
    addMediumEffects(scene, plan, effects);
    effects.push_back(
        linking(scene, ".lights", &ViewVolume::lights, "light linking", "by", "all lights light all volumes"));
    effects.push_back(linking(scene, ".shadows", &ViewVolume::shadows, "shadow linking", "in",
                              "all volumes cast shadows in all lights"));
    effects.push_back(ofDial(scene, "ambient light", "ambient", scene.ambient != Rgb(0),
                             scene.ambient != Rgb(0) ? "[ambient] has a color" : "[ambient] is black"));
    effects.push_back(solids(scene, SolidRole::holdout, "holdouts", "", "no mesh hides volumes"));
    effects.push_back(depthPicture(scene));
    effects.push_back(heldVolumes(scene));
    effects.push_back(solids(scene, SolidRole::shadow, "shadows of solids", "", "no mesh casts shadows"));
    effects.push_back(solids(scene, SolidRole::catcher, "caught shadows", ".catch", "no mesh catches shadows"));
    effects.push_back(backdrop(scene));
    effects.push_back(layers(scene));
    effects.push_back(deepPicture(scene));
    effects.push_back(motionBlur(scene));
    effects.push_back(depthOfField(scene));
    effects.push_back(crossFade(scene, plan));
    const Dials& dials = scene.dials;
    effects.push_back(ofDial(scene, "antialiasing", "render.antialias", dials.antialias > 1,
                             fmt::format("{0} x {0} rays a pixel", dials.antialias)));
    effects.push_back(ofDial(scene, "level of detail", "render.lod", dials.lod > 0,
                             dials.lod > 0 ? fmt::format("voxels may shrink to {} pixels", *dials.lod)
                                           : "voxels are as the files have them"));
    const std::string inParts = fmt::format("its rays are swept in {} parts", plan.eyeParts.size());
    const bool wide = plan.eyeParts.size() > 1;
    effects.push_back({"wide eye", wide, wide ? inParts : "one sweep holds all of its rays", {}});
    effects.push_back(ofDial(scene, "per-view splatting", "render.splat", plan.perView,
                             plan.perView ? "the scene sets it: a splat for the eye and one for every shadow"
                                          : "all views share one splat"));
    effects.push_back(ofDial(scene, "shading at pixels", "render.shade", plan.shadeAtPixels,
                             plan.groups.empty() ? "there is nothing to shade" : plan.shadeReason));
    effects.push_back(lightsOnCells(scene, plan));
    effects.push_back(culledLights(scene, plan));
    effects.push_back(culledVolumes(scene));
    effects.push_back(culledTiles(plan));
    return effects;
}

}  // namespace scrim
