// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/framed_scan.h>

#include <scrim/base/error.h>
#include <scrim/base/letter_case.h>
#include <scrim/scene/classified.h>
#include <scrim/scene/field_rays.h>
#include <scrim/scene/framing.h>
#include <scrim/scene/toml_text.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

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

/// True if the file gives the patient's position. Converters of test data (8 bit, a spacing of
/// exactly 1) write a space that the data never had.
bool isStated(const ScanInfo& info) {
    const bool converted =
        info.sampleType == "uint8" && lowerCase(info.path).ends_with(".nrrd") && Mat3(info.wsFromIs) == Mat3(1.0);
    return !info.space.empty() && !converted;
}

/// Skewness of a distribution over whole numbers, given as their weights.
double skewness(const std::vector<double>& weights) {
    double sum = 0, mean = 0, square = 0, cube = 0;
    for (std::size_t i = 0; i < weights.size(); ++i) {
        sum += weights[i];
        mean += weights[i] * double(i);
    }
    mean /= sum;
    for (std::size_t i = 0; i < weights.size(); ++i) {
        const double d = double(i) - mean;
        square += weights[i] * d * d / sum;
        cube += weights[i] * d * d * d / sum;
    }
    return square > 0 ? cube / std::pow(square, 1.5) : 0;
}

/// The direction, along an axis of the world, away from the end of the field where nearly all voxels of at least
/// `least` lie: what has one heavy end, such as a pot under a tree, stands on it. None where no end is clearly heavier.
std::optional<Vec3> wsAwayFromHeavyEnd(const SparseField& field, float least) {
    constexpr double kClear = 1;  // skewness; that of a tooth's crown and of a head is below 0.5
    const Bounds is = isOccupied(field);
    if (is.empty() || !(least > 0)) return {};
    std::array<std::vector<double>, 3> profiles;
    for (int axis = 0; axis < 3; ++axis)
        profiles[std::size_t(axis)].resize(std::size_t(is.upper[axis] - is.lower[axis]) + 1);
    const Vec3 first = is.lower + 0.5;
    for (std::size_t i = 0; i < field.blockCount(); ++i)
        for (int x = 0; x < kBlockEdge; ++x)
            for (int y = 0; y < kBlockEdge; ++y)
                for (int z = 0; z < kBlockEdge; ++z) {
                    if (field.block(i)[blockOffset(x, y, z)] < least) continue;
                    const Vec3 at = Vec3(field.blockOrigins[i] + Int3(x, y, z)) - first;
                    for (int axis = 0; axis < 3; ++axis) profiles[std::size_t(axis)][std::size_t(at[axis])] += 1;
                }
    double clearest = kClear;
    std::optional<Vec3> wsUp;
    for (int axis = 0; axis < 3; ++axis) {
        const double skew = skewness(profiles[std::size_t(axis)]);
        if (!(std::abs(skew) > clearest)) continue;
        clearest = std::abs(skew);
        const Vec3 ws = Vec3(field.wsFromIs[axis]) * (skew > 0 ? 1.0 : -1.0), size = glm::abs(ws);
        const int main = size.x > size.y && size.x > size.z ? 0 : size.y > size.z ? 1 : 2;
        wsUp = Vec3(0);
        (*wsUp)[main] = ws[main] > 0 ? 1 : -1;
    }
    return wsUp;
}

constexpr const char* kPhong =
    "ambient = 0.1\n"
    "diffuse = 0.75\n"
    "specular = 0.2\n"
    "exponent = 24\n";

ScanLook windowLook(const ScanInfo& info, const ScanMaterials& materials, const std::string& window) {
    const bool isPair = window.starts_with('[');
    if (!isPair && !materials.hounsfield)
        throw Error(ErrorKind::input,
                    fmt::format("{}: has values from {:g} to {:g}, which are not Hounsfield units, as the window {} "
                                "needs them; expected [centre, width] in the scan's own units, or a scene with "
                                "'rescale' among its parameters",
                                shortened(info.path), info.minValue, info.maxValue, window));
    ScanLook look;
    look.solid = static_cast<float>(materials.solid + (materials.hounsfield ? kHounsfieldZero : 0));
    look.parameters = {{"units", materials.hounsfield ? "hounsfield" : "scan"}};
    // Far below what these windows show. Air takes time and memory.
    if (!isPair && window.find("lung") == std::string::npos) look.parameters.push_back({"threshold", "-400"});
    look.classified = fmt::format("[volume.classified]\n{}{}", materials.hounsfield ? "" : "window_zero = 0\n", kPhong);
    return look;
}

}  // namespace

ScanLook scanLook(const ScanInfo& info, const std::string& window) {
    // Fraction of the way from the least value to tissue below which values are left out.
    constexpr double kBegins = 0.6;
    const ScanMaterials materials = materialsOf(info);
    if (!window.empty()) return windowLook(info, materials, window);
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
    look.solid = static_cast<float>(end * scale + offset);
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
        "transfer = [\n{}{}{}{}]\n{}",
        materials.hounsfield ? "In Hounsfield units: tissue as a veil, bone as a surface"
                             : "By the histogram: what is less dense as a veil, what is denser as a surface",
        at(begin, kTissue, 0), at(veil, kTissue, kVeil / size), at(end, kTissue, kVeil / size),
        at(surface, kBone, kSurface / voxel), kPhong);
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

Upright uprightOf(const ScanInfo& info, const SparseField& field, float solid) {
    Upright up{wsFromUpright({0, 0, 1}), UpFrom::slices};
    if (!isStated(info)) {
        if (const std::optional<Vec3> wsUp = wsAwayFromHeavyEnd(field, solid))
            return {wsFromUpright(*wsUp), UpFrom::weight};
        return up;
    }
    up.from = UpFrom::file;
    // In this space y leads towards the face, in all others away from it.
    if (info.space.starts_with("right-anterior")) {
        up.wsFromUpright[0] = -up.wsFromUpright[0];
        up.wsFromUpright[2] = -up.wsFromUpright[2];
    }
    return up;
}

}  // namespace scrim
