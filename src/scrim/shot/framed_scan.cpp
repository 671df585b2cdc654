// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/framed_scan.h>

#include <scrim/scene/framing.h>
#include <scrim/scene/toml_text.h>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <glm/geometric.hpp>

namespace scrim {
namespace {

constexpr double kVeil = 1.2;     // optical depth of tissue that is as thick as the scan
constexpr double kSurface = 1.2;  // optical depth of one voxel of bone

std::string pointText(double value, const char* color, double extinction) {
    return fmt::format("    {{ value = {}, color = {}, extinction = {} }},\n", tomlSignificant(value, 4), color,
                       tomlSignificant(extinction, 3));
}

}  // namespace

ScanLook scanLook(const ScanInfo& info) {
    // Fraction of the way from the least value to tissue below which values are left out.
    constexpr double kBegins = 0.6;
    const ScanMaterials materials = materialsOf(info);
    // A scan of a single value has no materials, but is shown all the same.
    const double span = std::max(materials.solid - materials.soft, 1e-3 * std::max(std::abs(materials.solid), 1.0));
    ScanLook look;
    double low = std::max(info.minValue, materials.hounsfield ? 0.0 : -1e30);
    low += kBegins * (materials.soft - low);
    const double begin = std::max(materials.soft - 0.1 * span, low),
                 veil = std::max(materials.soft + 0.25 * span, begin),
                 end = std::max(materials.solid - 0.12 * span, veil),
                 surface = std::max(materials.solid + 0.12 * span, end + 0.1 * span);
    double scale = 1, offset = 0;  // convert scan values to values of the field
    if (low >= 0) {
        look.parameters = {{"units", "scan"}, {"threshold", tomlSignificant(low, 3)}};
    } else {
        look.parameters = {
            {"threshold", tomlSignificant(low, 4)},
            {"window", fmt::format("{}, {}", tomlSignificant(low, 4), tomlSignificant(info.maxValue, 4))}};
        scale = 1 / (info.maxValue - low);
        offset = -low * scale;
    }
    const Mat3 axes(info.wsFromIs);
    const double voxel = std::cbrt(glm::length(axes[0]) * glm::length(axes[1]) * glm::length(axes[2]));
    const double size = glm::length(axes * Vec3(info.size));
    const auto at = [&](double value, const char* color, double extinction) {
        return pointText(value * scale + offset, color, extinction);
    };
    constexpr const char *kTissue = "[0.85, 0.42, 0.3]", *kBone = "[0.95, 0.88, 0.76]";
    look.classified = fmt::format(
        "# {}\n"
        "[volume.classified]\n"
        "transfer = [\n{}{}{}{}]\n"
        "ambient = 0.1\n"
        "diffuse = 0.75\n"
        "specular = 0.2\n"
        "exponent = 24\n",
        materials.hounsfield ? "In Hounsfield units: tissue as a veil, bone as a surface"
                             : "By the histogram: what is less dense as a veil, what is denser as a surface",
        at(begin, kTissue, 0), at(veil, kTissue, kVeil / size), at(end, kTissue, kVeil / size),
        at(surface, kBone, kSurface / voxel));
    return look;
}

std::string scanVolumeText(const std::string& name, const std::string& file, const ScanLook& look) {
    std::string text = fmt::format(
        "[[volume]]\n"
        "name = {}\n"
        "source = \"scan\"\n"
        "[volume.parameters]\n"
        "file = {}\n",
        tomlString(name), tomlString(file));
    for (const auto& [key, value] : look.parameters)
        text += fmt::format("{} = {}\n", key, key == "threshold" ? value : tomlString(value));
    return text + look.classified;
}

Mat3 uprightOf(const ScanInfo& info) {
    Mat3 upright = wsFromUpright({0, 0, 1});
    // In this space y leads towards the face, in all others away from it.
    if (info.space.starts_with("right-anterior")) {
        upright[0] = -upright[0];
        upright[2] = -upright[2];
    }
    return upright;
}

}  // namespace scrim
