// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/plan/shading_place.h>

#include <scrim/engine/light/slide_map.h>

#include <optional>

#include <fmt/format.h>

namespace scrim {
namespace {

Bounds wsBounds(const ViewScene& scene) {
    Bounds ws;
    for (const Vec3& corner : wsCorners(scene)) ws.include(corner);
    return ws;
}

// Why a slide wants pixels: texels blur what is not at least two of them wide. (A slide of noise in smoke, its pixels as
// large as a texel: 5 to 7 % of error at texels, 1.5 % at pixels; four times as large: 2 % and 1.5 %.) Empty where none
// does.
std::string fineSlide(const ViewScene& scene, const Plan& plan, double texel) {
    const Vec3 center = wsBounds(scene).center();
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        const Light& light = scene.lights[i];
        if (!light.slide || !plan.culledLights[i].empty()) continue;
        const std::optional<double> pixel = slidePixel(light, center);
        if (pixel && *pixel < 2 * texel)
            return fmt::format(
                "a pixel of the slide of '{}' covers {:.3g} at the volume, less than two texels of {:.3g}", light.name,
                *pixel, texel);
    }
    return {};
}

// Optical depth of a sheet from which on media are shaded at pixels. What a texel shows, 1 - e^-tau, bends more and more as
// tau grows, and so does what lies between two texels. (Smoke of so many a voxel, error at texels and at pixels: 0.23: 0.5,
// 0.4 %; 0.46: 1.0, 0.7 %; 0.9: 1.9, 0.9 %; 2.3: 3.1, 1.8 %; 9: 8.2, 4.6 %, for a fifth more time.)
constexpr double kDenseSheet = 0.4;

// Empty where no medium is that dense.
std::string denseMedium(const ViewScene& scene, const Plan& plan) {
    for (const ViewVolume& volume : scene.volumes) {
        const double tau =
            volume.field->maxValue * volume.medium.mostExtinction() * plan.groups.front().sheets.thickness;
        if (!volume.classified && tau > kDenseSheet)
            return fmt::format("volume {} reaches an optical depth of {:.2g} a sheet, more than texels resolve",
                               volume.name, tau);
    }
    return {};
}

// Rays from an eye fan out: the slant of its rays, and with it the optical depth of a sheet, changes from a texel to the
// next by about texel / distance. Nearer than this, in texels, that is no longer a small part of either.
constexpr double kNearEye = 4;

bool eyeAmong(const ViewScene& scene, double texel) {
    if (scene.camera.type != CameraType::perspective) return false;
    Bounds ws = wsBounds(scene);
    ws.lower -= kNearEye * texel;
    ws.upper += kNearEye * texel;
    return ws.contains(scene.camera.wsPosition);
}

// What texels would spoil; empty where they serve as well as pixels.
std::string needOfPixels(const ViewScene& scene, const Plan& plan) {
    const double texel = plan.groups.front().sheets.texel;
    for (const ViewVolume& volume : scene.volumes)
        if (volume.classified)
            return fmt::format("volume {} is classified: surfaces are sharper than texels", volume.name);
    for (const GroupPlan& group : plan.groups)
        for (const LightPlan& light : group.lights)
            if (!light.ssWindows.empty())
                return fmt::format("light {} is so near that its light changes between texels",
                                   scene.lights[static_cast<std::size_t>(light.light)].name);
    if (eyeAmong(scene, texel)) return "the eye stands so near that what it sees of a sheet changes between texels";
    if (const std::string reason = fineSlide(scene, plan, texel); !reason.empty()) return reason;
    return denseMedium(scene, plan);
}

}  // namespace

ShadingPlace shadingPlace(const ViewScene& scene, const Plan& plan) {
    if (plan.groups.empty()) return {};
    if (plan.perView) return {true, "per-view splatting knows no other place"};
    if (scene.dials.shade != ShadeMode::automatic) return {scene.dials.shade == ShadeMode::pixel, "the scene says so"};
    if (const std::string need = needOfPixels(scene, plan); !need.empty()) return {true, need};

    // Shading at texels costs by texel, shading at pixels by pixel; for a thin medium both are equally exact. Counted are
    // the pixels of the whole picture: a crop must be shaded as the rest is.
    const double n = scene.dials.antialias;
    const double pixels = n * n * scene.camera.resolution.x * scene.camera.resolution.y;
    const Sheets& sheets = plan.groups.front().sheets;
    const double texels = double(sheets.width) * sheets.height;
    // A pixel's sample costs about twice a texel's: it gathers its extinction and its shadow.
    return {2 * pixels < texels, fmt::format("a sheet has {:.3g} texels, the picture {:.3g} pixels, and a thin medium "
                                             "looks the same either way",
                                             texels, pixels)};
}

}  // namespace scrim
