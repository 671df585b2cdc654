// SPDX-License-Identifier: Apache-2.0
#include <scrim/render/plan_text.h>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace scrim {
namespace {

using Json = nlohmann::ordered_json;

/// Something a scene may need or not, and why.
struct Effect {
    std::string name;
    bool on = false;
    std::string reason;
};

std::string quotedNames(const std::vector<std::string>& names) {
    return names.empty() ? "" : fmt::format("'{}'", fmt::join(names, "', '"));
}

Effect shadowEffect(const ViewScene& scene) {
    std::vector<std::string> with;
    for (const Light& light : scene.lights)
        if (light.shadows) with.push_back(light.name);
    if (scene.lights.empty()) return {"shadows", false, "there are no lights"};
    if (with.empty()) return {"shadows", false, "every light has shadows = false"};
    return {"shadows", true, fmt::format("of {}", quotedNames(with))};
}

Effect slideEffect(const ViewScene& scene) {
    std::vector<std::string> with;
    for (const Light& light : scene.lights)
        if (light.slide) with.push_back(light.name);
    if (with.empty()) return {"slides", false, "no light has a slide"};
    return {"slides", true, fmt::format("of {}", quotedNames(with))};
}

Effect classifiedEffect(const ViewScene& scene) {
    std::vector<std::string> names;
    for (const ViewVolume& volume : scene.volumes)
        if (volume.classified) names.push_back(volume.name);
    if (names.empty()) return {"surfaces", false, "no volume is classified: no gradients, no transfer function"};
    return {"surfaces", true, fmt::format("{} classified", quotedNames(names))};
}

Effect crossFadeEffect(const ViewScene& scene, const Plan& plan) {
    for (const GroupPlan& group : plan.groups)
        for (const LightPlan& light : group.lights)
            if (light.share < 1)
                return {"cross-fade", true,
                        fmt::format("light '{}' is within {} degrees of perpendicular to the eye, and swept from both "
                                    "sides",
                                    scene.lights[static_cast<std::size_t>(light.light)].name, scene.dials.crossFade)};
    return {"cross-fade", false, "no light is perpendicular to the eye"};
}

Effect phaseEffect(const ViewScene& scene) {
    std::vector<std::string> names;
    for (const ViewVolume& volume : scene.volumes)
        if (volume.medium.phase.g != 0) names.push_back(volume.name);
    if (names.empty()) return {"directional scattering", false, "every phase function is isotropic"};
    return {"directional scattering", true, fmt::format("of {}", quotedNames(names))};
}

std::vector<Effect> effectsOf(const ViewScene& scene, const Plan& plan) {
    std::vector<Effect> effects{shadowEffect(scene), slideEffect(scene), classifiedEffect(scene), phaseEffect(scene),
                                crossFadeEffect(scene, plan)};
    const bool ambient = scene.ambient != Rgb(0);
    effects.push_back({"ambient light", ambient, ambient ? "[ambient] has a color" : "[ambient] is black"});
    const int n = scene.dials.antialias;
    effects.push_back({"antialiasing", n > 1, fmt::format("{0} x {0} rays a pixel", n)});
    effects.push_back(
        {"level of detail", scene.dials.lod > 0,
         scene.dials.lod > 0 ? fmt::format("voxels may shrink to {} pixels", scene.dials.lod) : "lod is 0"});
    effects.push_back({"wide eye", plan.eyeParts.size() > 1,
                       plan.eyeParts.size() > 1 ? fmt::format("its rays are swept in {} parts", plan.eyeParts.size())
                                                : "one sweep holds all of its rays"});
    effects.push_back({"per-view splatting", plan.perView,
                       plan.perView ? "the scene says so: a splat for the eye and one for every shadow"
                                    : "all views share one splat"});
    effects.push_back({"shading at pixels", plan.shadeAtPixels,
                       plan.groups.empty() ? "there is nothing to shade" : plan.shadeReason});
    return effects;
}

Json vector(const Vec3& v) {
    return Json::array({v.x, v.y, v.z});
}

/// The axis of a group's sweep in world space: the third row of the rotation into sweep space.
Vec3 axisOf(const GroupPlan& group) {
    const Mat3& m = group.sheets.ssFromWs;
    return {m[0][2], m[1][2], m[2][2]};
}

const Light& lightOf(const ViewScene& scene, const LightPlan& light) {
    return scene.lights[static_cast<std::size_t>(light.light)];
}

const std::string& lightName(const ViewScene& scene, const LightPlan& light) {
    return lightOf(scene, light).name;
}

Json lightJson(const ViewScene& scene, const LightPlan& light) {
    Json out{{"name", lightName(scene, light)}, {"shadowed", light.shadowed}};
    if (light.shadowed) out["shadow_raster"] = {light.view.width, light.view.height};
    if (const auto& slide = lightOf(scene, light).slide)
        out["slide"] = {{"file", slide->file}, {"pixels", {slide->image->width(), slide->image->height()}}};
    if (!light.ssWindows.empty()) {
        out["window"] = light.window;
        out["windows"] = light.ssWindows.size();
    }
    return out;
}

Json groupJson(const ViewScene& scene, const GroupPlan& group) {
    Json lights = Json::array();
    for (const LightPlan& light : group.lights) lights.push_back(lightJson(scene, light));
    return {{"primary", group.primary > 0},
            {"eye_part", group.eyePart},
            {"axis", vector(axisOf(group))},
            {"s", group.sameSide ? 1 : -1},
            {"slant", glm::degrees(group.slant)},
            {"sheets", group.sheets.count},
            {"sheet_thickness", group.sheets.thickness},
            {"raster", {group.sheets.width, group.sheets.height}},
            {"texel", group.sheets.texel},
            {"batch_sheets", group.batchSheets},
            {"bytes", group.bytes},
            {"lights", lights}};
}

double megabytes(std::size_t bytes) {
    return static_cast<double>(bytes) / (1 << 20);
}

std::string lightLine(const ViewScene& scene, const LightPlan& light) {
    std::string line = fmt::format("  light '{}'", lightName(scene, light));
    if (!light.ssWindows.empty()) line += fmt::format(", part {}", light.window + 1);
    if (const auto& slide = lightOf(scene, light).slide)
        line += fmt::format(", slide of {} x {} pixels", slide->image->width(), slide->image->height());
    line += light.shadowed ? fmt::format(": shadow raster {} x {} cells\n", light.view.width, light.view.height)
                           : std::string(": no shadows\n");
    return line;
}

std::string groupLines(const ViewScene& scene, const GroupPlan& group, std::size_t number) {
    const Vec3 axis = axisOf(group);
    std::string text = fmt::format("group {}{}: axis [{:.4f}, {:.4f}, {:.4f}], s = {}, slant {:.1f} degrees\n", number,
                                   group.primary > 0 ? " (primary: alpha and ambient)" : "", axis.x, axis.y, axis.z,
                                   group.sameSide ? "+1" : "-1", glm::degrees(group.slant));
    text += fmt::format("  sheets   {} x {:.6g}, {} a batch\n", group.sheets.count, group.sheets.thickness,
                        group.batchSheets);
    text += fmt::format("  raster   {} x {} texels of {:.6g}\n", group.sheets.width, group.sheets.height,
                        group.sheets.texel);
    text += fmt::format("  memory   {:.1f} MB\n", megabytes(group.bytes));
    for (const LightPlan& light : group.lights) text += lightLine(scene, light);
    return text;
}

}  // namespace

std::string planAsJson(const ViewScene& scene, const Plan& plan) {
    Json effects = Json::array();
    for (const Effect& e : effectsOf(scene, plan))
        effects.push_back({{"name", e.name}, {"on", e.on}, {"reason", e.reason}});
    Json groups = Json::array();
    for (const GroupPlan& group : plan.groups) groups.push_back(groupJson(scene, group));
    const PixelWindow& r = plan.region;
    const Json out{{"voxel", plan.voxel},
                   {"region", {r.x0, r.y0, r.x1, r.y1}},
                   {"splat", plan.perView ? "per-view" : "shared"},
                   {"shade", plan.shadeAtPixels ? "pixel" : "texel"},
                   {"shade_reason", plan.shadeReason},
                   {"effects", effects},
                   {"groups", groups},
                   {"bytes", plan.bytes},
                   {"expected_work",
                    {{"footprints", plan.work.footprints},
                     {"texels", plan.work.texels},
                     {"light_samples", plan.work.lightSamples},
                     {"pixel_sheets", plan.work.pixelSheets}}}};
    return out.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string planAsTable(const ViewScene& scene, const Plan& plan) {
    std::string text;
    for (const Effect& e : effectsOf(scene, plan))
        text += fmt::format("{:<23} {:<4} {}\n", e.name, e.on ? "on" : "off", e.reason);
    text += fmt::format("{:<23} {:.6g} world units\n", "voxel", plan.voxel);
    text += fmt::format("{:<23} {} x {} rays\n", "picture", plan.region.width(), plan.region.height());
    for (std::size_t i = 0; i < plan.groups.size(); ++i) text += groupLines(scene, plan.groups[i], i + 1);
    if (plan.groups.empty()) text += "nothing to render: no volume has active voxels\n";
    text += fmt::format("{:<23} {:.1f} MB\n", "memory without fields", megabytes(plan.bytes));
    text += fmt::format("{:<23} {:.3g} footprints, {:.3g} texels, {:.3g} light samples, {:.3g} pixel sheets\n",
                        "expected work", plan.work.footprints, plan.work.texels, plan.work.lightSamples,
                        plan.work.pixelSheets);
    return text;
}

}  // namespace scrim
