// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/plan/report.h>

#include <scrim/base/error.h>
#include <scrim/engine/balls/ball_sheets.h>
#include <scrim/engine/plan/effects.h>
#include <scrim/engine/plan/expected_cost.h>
#include <scrim/image/light_profile.h>
#include <scrim/scene/quality.h>

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>
#include <string>
#include <vector>

namespace scrim {
namespace {

using Json = nlohmann::ordered_json;

Json vector(const Vec3& v) {
    return Json::array({v.x, v.y, v.z});
}

/// The axis of a group's sweep in world space: the third row of the rotation into sweep space.
Vec3 axisOf(const GroupPlan& group) {
    const Mat3& m = group.sheets.ssFromWs;
    return {m[0][2], m[1][2], m[2][2]};
}

Json lightJson(const ViewScene& scene, const Plan& plan, const PlannedLight& light) {
    Json out{{"name", ownerOf(scene, plan, light.light).name}, {"shadowed", light.shadowed}};
    if (light.shadowed) out["shadow_raster"] = {light.view.width, light.view.height};
    if (const auto& slide = plan.subLights.of(light.light).slide)
        out["slide"] = {{"file", slide->file}, {"pixels", {slide->image->width(), slide->image->height()}}};
    if (const auto& luminaire = plan.subLights.of(light.light).luminaire; luminaire && !luminaire->file.empty())
        out["ies"] = luminaire->file;
    if (!light.ssWindows.empty()) {
        out["window"] = light.window;
        out["windows"] = light.ssWindows.size();
    }
    return out;
}

// The names of the volumes of a level.
std::vector<std::string> namesOf(const ViewScene& scene, const std::vector<bool>& volumes) {
    std::vector<std::string> names;
    for (std::size_t v = 0; v < volumes.size(); ++v)
        if (volumes[v]) names.push_back(scene.volumes[v].name);
    return names;
}

Json groupJson(const ViewScene& scene, const Plan& plan, const GroupPlan& group) {
    Json lights = Json::array();
    for (const PlannedLight& light : group.lights) lights.push_back(lightJson(scene, plan, light));
    Json levels = Json::array();
    if (!group.finer.empty())
        group.forLevels([&](const GroupPlan& level) {
            levels.push_back({{"volumes", namesOf(scene, level.volumes)},
                              {"sheets", level.sheets.count},
                              {"sheet_thickness", level.sheets.thickness},
                              {"raster", {level.sheets.width, level.sheets.height}},
                              {"texel", level.sheets.texel}});
        });
    return {{"primary", group.primary > 0},
            {"eye_part", group.eyePart},
            {"axis", vector(axisOf(group))},
            {"s", group.sameSide ? 1 : -1},
            {"slant", glm::degrees(group.slant)},
            {"sheets", group.sheets.count},
            {"needed_sheets", {group.needed.first, group.needed.last}},
            {"pass", group.pass},
            {"passes", group.passes},
            {"sheet_thickness", group.sheets.thickness},
            {"raster", {group.sheets.width, group.sheets.height}},
            {"texel", group.sheets.texel},
            {"batch_sheets", group.batchSheets},
            {"bytes", group.bytes},
            {"lights", lights},
            {"levels", levels}};
}

/// The [render] block that renders as this plan does. What stays "auto" depends on the frame or the machine.
Json renderJson(Dials dials) {
    if (!dials.crossFade) dials.crossFade = kCrossFade;
    Json out = Json::object();
    for (const DialInfo& dial : dialTable()) {
        const std::string text = dialText(dials, dial.name);
        const bool isWord = std::isdigit(static_cast<unsigned char>(text.front())) == 0;
        out[dial.name] = isWord ? Json(text) : Json::parse(text);
    }
    return out;
}

std::string lightLine(const ViewScene& scene, const Plan& plan, const PlannedLight& light) {
    std::string line = fmt::format("  light '{}'", ownerOf(scene, plan, light.light).name);
    if (!light.ssWindows.empty()) line += fmt::format(", part {}", light.window + 1);
    if (const auto& slide = plan.subLights.of(light.light).slide)
        line += fmt::format(", slide of {} x {} pixels", slide->image->width(), slide->image->height());
    if (const auto& luminaire = plan.subLights.of(light.light).luminaire; luminaire && !luminaire->file.empty())
        line += fmt::format(", profile that reaches {:.3g} degrees", luminaire->profile->reach());
    line += light.shadowed ? fmt::format(": shadow raster {} x {} cells\n", light.view.width, light.view.height)
                           : std::string(": no shadows\n");
    return line;
}

// The number of points that are seen as balls.
std::uint64_t ballsOf(const ViewScene& scene) {
    std::uint64_t sum = 0;
    for (const ViewVolume& volume : scene.volumes) sum += volume.balls ? volume.balls->radius->activeVoxels : 0;
    return sum;
}

std::string placesText(const std::vector<std::string>& where) {
    constexpr std::size_t kMostNamed = 12;
    if (where.empty()) return "";
    const auto end = where.begin() + static_cast<std::ptrdiff_t>(std::min(where.size(), kMostNamed));
    return fmt::format(" ({}{})", fmt::join(where.begin(), end, ", "), where.size() > kMostNamed ? ", …" : "");
}

std::string passText(const GroupPlan& group) {
    if (group.passes == 1) return "";
    return fmt::format(" (pass {} of {}: the memory limit holds {} of their lights at a time)", group.pass,
                       group.passes, group.lights.size());
}

std::string groupLines(const ViewScene& scene, const Plan& plan, const GroupPlan& group, std::size_t number) {
    const Vec3 axis = axisOf(group);
    std::string text = fmt::format("group {}{}{}: axis [{:.4f}, {:.4f}, {:.4f}], s = {}, slant {:.1f} degrees\n",
                                   number, group.primary > 0 ? " (primary: alpha and ambient)" : "", passText(group),
                                   axis.x, axis.y, axis.z, group.sameSide ? "+1" : "-1", glm::degrees(group.slant));
    group.forLevels([&](const GroupPlan& level) {
        const std::string whose = level.volumes.empty() ? "" : placesText(namesOf(scene, level.volumes));
        text += fmt::format("  sheets   {} x {:.6g}, {} a batch{}\n", level.sheets.count, level.sheets.thickness,
                            level.batchSheets, whose);
        text += fmt::format("  raster   {} x {} texels of {:.6g}\n", level.sheets.width, level.sheets.height,
                            level.sheets.texel);
    });
    text += fmt::format("  memory   {}\n", bytesText(group.bytes));
    // The first few of many sub-lights show what the others are like.
    constexpr std::size_t kMostLines = 24;
    for (std::size_t i = 0; i < std::min(group.lights.size(), kMostLines); ++i)
        text += lightLine(scene, plan, group.lights[i]);
    if (group.lights.size() > kMostLines) text += fmt::format("  and {} more\n", group.lights.size() - kMostLines);
    return text;
}

}  // namespace

std::string planAsJson(const ViewScene& scene, const Plan& plan) {
    Json effects = Json::array();
    for (const Effect& e : effectsOf(scene, plan))
        effects.push_back({{"name", e.name}, {"on", e.on}, {"reason", e.reason}, {"where", e.where}});
    Json groups = Json::array();
    for (const GroupPlan& group : plan.groups) groups.push_back(groupJson(scene, plan, group));
    const PixelWindow& r = plan.region;
    const double times = renderCount(scene);
    const int rays = scene.dials.antialias;
    Json out{{"voxel", plan.voxel},
             {"render", renderJson(scene.dials)},
             {"window", {r.x0 / rays, r.y0 / rays, r.x1 / rays, r.y1 / rays}},
             {"region", {r.x0, r.y0, r.x1, r.y1}},
             {"splat", plan.perView ? "per-view" : "shared"},
             {"shade", plan.shadeAtPixels ? "pixel" : "texel"},
             {"shade_reason", plan.shadeReason},
             {"effects", effects},
             {"groups", groups},
             {"bytes", plan.bytes},
             {"expected_work",
              {{"footprints", times * double(plan.work.footprints)},
               {"texels", times * double(plan.work.texelsShaded)},
               {"light_samples", times * double(plan.work.lightSamples)},
               {"pixel_sheets", times * double(plan.work.pixelSheets)}}}};
    if (scene.deep) out["deep_bytes"] = plan.deepBytes;
    if (seesBalls(scene, plan)) out["balls"] = ballsOf(scene);
    return out.dump(-1, ' ', false, Json::error_handler_t::replace);
}

std::string planAsTable(const ViewScene& scene, const Plan& plan) {
    std::string text;
    const double times = renderCount(scene);
    for (const Effect& e : effectsOf(scene, plan))
        text += fmt::format("{:<23} {:<4} {}{}\n", e.name, e.on ? "on" : "off", e.reason, placesText(e.where));
    text += fmt::format("{:<23} {:.6g} world units\n", "voxel", plan.voxel);
    if (seesBalls(scene, plan))
        text +=
            fmt::format("{:<23} {} are seen by themselves, each a ball or disc of its own\n", "points", ballsOf(scene));
    text += fmt::format("{:<23} {} x {} rays\n", "picture", plan.region.width(), plan.region.height());
    for (std::size_t i = 0; i < plan.groups.size(); ++i) text += groupLines(scene, plan, plan.groups[i], i + 1);
    if (plan.groups.empty()) text += "nothing to render: no volume has active voxels\n";
    text += fmt::format("{:<23} {}\n", "memory without fields", bytesText(plan.bytes));
    if (scene.deep) text += fmt::format("{:<23} {} of it at most\n", "deep picture", bytesText(plan.deepBytes));
    text += fmt::format("{:<23} {:.3g} footprints, {:.3g} texels, {:.3g} light samples, {:.3g} pixel sheets\n",
                        "expected work", times * double(plan.work.footprints), times * double(plan.work.texelsShaded),
                        times * double(plan.work.lightSamples), times * double(plan.work.pixelSheets));
    return text;
}

}  // namespace scrim
