// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/check_scene.h>

#include <scrim/base/error.h>
#include <scrim/scene/quality.h>
#include <scrim/scene/read_ramp.h>
#include <scrim/scene/read_sections.h>
#include <scrim/scene/scene_keys.h>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

/// Tolerance for lengths and right angles of axes and directions: more than their error if they
/// were computed in floats.
constexpr double kRounding = 1e-4;

bool isFinite(const Vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

std::string textOf(const Vec3& v) {
    return fmt::format("{}, {}, {}", v.x, v.y, v.z);
}

/// Checks one item of the scene, which messages call `of`: "light 'key'".
class Check {
  public:
    Check(const Scene& scene, std::string of) : m_where(scene.file.empty() ? "" : scene.file + ": "), m_of(of) {}

    [[noreturn]] void refuse(const std::string& name, const std::string& found, const std::string& expected) const {
        throw Error(ErrorKind::input,
                    fmt::format("{}{}: '{}' is {}; expected {}", m_where, m_of, name, found, expected));
    }
    void number(const Key& key, double value, const Range& range) const {
        if (!range.holds(value)) refuse(key.name, fmt::format("{}", value), "a number" + range.text());
    }
    void number(const Key& key, double value) const { number(key, value, key.range); }
    /// Checks the members of `object` that keys of `section` set. Keys that are known in some cases only are left out.
    template <typename Object>
    void members(const SectionOf<Object>& section, const Object& object) const {
        for (const Key& key : section.keys())
            if (key.member && key.only.empty()) member(key, object);
    }
    template <typename Object>
    void member(const Key& key, const Object& object) const {
        const double value = key.member.get(object);
        if (key.type == Key::Type::number || key.type == Key::Type::integer) return number(key, value);
        const std::size_t count = key.type == Key::Type::boolean ? 2 : key.words.size();
        if (!(value >= 0 && value < static_cast<double>(count)))
            refuse(key.name, fmt::format("number {}", value), choices(key.words));
    }
    /// Checks all numbers of a key that has more than one.
    void numbers(const Key& key, const std::vector<double>& values) const {
        for (const double value : values)
            if (!key.range.holds(value))
                refuse(key.name, fmt::format("{}", fmt::join(values, ", ")),
                       fmt::format("{}, each{}", key.form, key.range.text()));
    }
    void point(const Key& key, const Vec3& p) const { numbers(key, {p.x, p.y, p.z}); }
    void direction(const Key& key, const Vec3& v) const {
        if (!isFinite(v) || v == Vec3(0)) refuse(key.name, textOf(v), "a direction");
    }
    void unit(const Key& key, const Vec3& v) const {
        if (!(std::abs(glm::length(v) - 1) <= kRounding)) refuse(key.name, textOf(v), "a direction of length 1");
    }
    /// Checks a colour of light. A colour of another space may have a negative component in the
    /// working space, but its sum must not be negative: no light takes light away.
    void light(const Key& key, const Rgb& rgb) const {
        if (!isFinite(rgb) || rgb.x + rgb.y + rgb.z < 0)
            refuse(key.name, textOf(rgb), "finite numbers with a sum of at least 0");
    }
    void colour(const Key& key, const Rgb& rgb, double most) const {
        for (int c = 0; c < 3; ++c)
            if (!(rgb[c] >= 0 && rgb[c] <= most))
                refuse(key.name, textOf(rgb), fmt::format("numbers from 0 to {:g}", most));
    }
    void transform(const Key& key, const Mat4& m) const {
        for (int column = 0; column < 4; ++column) numbers(key, {m[column][0], m[column][1], m[column][2]});
        if (m[0][3] != 0 || m[1][3] != 0 || m[2][3] != 0 || m[3][3] != 1 || !isInvertible(m))
            refuse(key.name, "not an invertible affine matrix", "a matrix with an inverse and the last row 0, 0, 0, 1");
    }
    /// Checks that the points of a ramp ascend, that their values are from 0 to `most`, and that
    /// the ramp is 0 at 0. `ends` gives the smallest and the largest component of a point's value.
    template <typename T, typename Ends>
    void ramp(const Key& key, const std::vector<std::pair<double, T>>& points, double most, const Ends& ends) const {
        if (points.empty()) return;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const auto [low, high] = ends(points[i].second);
            if (!std::isfinite(points[i].first) || (i > 0 && !(points[i].first > points[i - 1].first)))
                refuse(key.name, fmt::format("{} at its point {}", points[i].first, i + 1), "ascending values");
            if (!(low >= 0 && high <= most))
                refuse(key.name, fmt::format("{} at its point {}", low >= 0 ? high : low, i + 1),
                       fmt::format("numbers from 0 to {:g}", most));
        }
        if (points.size() < 2) refuse(key.name, "a list of one point", "at least two");
        if (!keepsZero(points)) refuse(key.name, "above 0 at grid value 0", "0 there, because empty space is skipped");
    }

  private:
    std::string m_where, m_of;
};

void checkCamera(const Check& check, const Scene& scene) {
    const CameraKeys& k = keysOf<CameraKeys>();
    const Camera& camera = scene.camera;
    check.point(k.position, camera.wsPosition);
    const Mat3 product = glm::transpose(camera.wsFromCamera) * camera.wsFromCamera;
    for (int i = 0; i < 3; ++i)
        if (!(glm::length(product[i] - Mat3(1.0)[i]) <= kRounding))
            check.refuse(k.matrix.name, "not orthonormal", "three perpendicular axes of length 1");
    if (!(glm::determinant(camera.wsFromCamera) > 0)) check.refuse(k.matrix.name, "mirrored", "a right-handed frame");
    check.members(k, scene);
    check.member(camera.type == CameraType::perspective ? k.fov : k.height, scene);
    check.numbers(k.resolution, {double(camera.resolution.x), double(camera.resolution.y)});
    check.numbers(k.shift, {camera.shift.x, camera.shift.y});
    if (scene.lens) {
        check.number(k.lensRadius, scene.lens->radius);
        check.number(k.focusDistance, scene.lens->focus);
        if (camera.type != CameraType::perspective)
            check.refuse(k.lensRadius.name, "of an orthographic camera", "a perspective camera");
    }
    if (!scene.shutter) return;
    check.numbers(k.shutter, {scene.shutter->open, scene.shutter->close});
    if (!(scene.shutter->close > scene.shutter->open))
        check.refuse(k.shutter.name, fmt::format("[{}, {}]", scene.shutter->open, scene.shutter->close),
                     "[open, close] with open < close");
}

void checkKind(const Check& check, const Light& light) {
    const LightKeys& k = keysOf<LightKeys>();
    if (const auto* sun = std::get_if<Light::Distant>(&light.kind)) return check.number(k.angle, sun->angle);
    if (const Light::Dome* dome = light.dome()) return check.number(k.rotation, dome->rotation);
    if (const Light::Area* area = light.area()) {
        if (area->shape == AreaShape::mesh) return;
        check.number(k.spread, area->spread);
        if (area->shape != AreaShape::rectangle) check.number(k.radius, area->radius, Range::positiveLength());
        if (area->shape == AreaShape::rectangle || area->shape == AreaShape::cylinder)
            check.number(k.width, area->width);
        if (area->shape != AreaShape::rectangle) return;
        return check.number(k.height, area->height);
    }
    check.number(k.radius, light.point().radius);
    const Light::Spot* spot = light.spot();
    if (spot == nullptr) return;
    check.number(k.cone, spot->coneAngle);
    check.number(k.blend, spot->blend);
}

void checkLight(const Check& check, const Light& light) {
    const LightKeys& k = keysOf<LightKeys>();
    checkKind(check, light);
    check.point(k.position, light.wsPosition);
    check.unit(k.direction, light.wsDirection);
    check.direction(k.up, light.wsUp);
    check.light(k.intensity, light.intensity);
    if (light.samples != 0) check.number(k.samples, light.samples);
    if (!light.slide) return;
    if (light.slide->sky) check.members(keysOf<SkyKeys>(), *light.slide->sky);
    const SlideKeys& s = keysOf<SlideKeys>();
    check.number(s.fov, light.slide->fov);
    check.number(s.width, light.slide->width);
    if (light.slide->height != 0) check.number(s.height, light.slide->height);
    check.number(s.roll, light.slide->roll);
}

void checkPhase(const Check& check, const Phase& phase) {
    const PhaseKeys& k = keysOf<PhaseKeys>();
    const bool twoLobe = phase.type == PhaseType::twoLobe;
    if (phase.type != PhaseType::rayleigh) check.member(twoLobe ? k.g1 : k.g, phase);
    if (twoLobe) check.member(k.g2, phase);
    check.member(k.blend, phase);
    check.number(k.alpha, phase.alpha);
    // Files cannot state the strength. Code may, for mixtures of Rayleigh's phase function with an isotropic one.
    if (!(phase.strength >= 0 && phase.strength <= 1))
        check.refuse("strength", fmt::format("{}", phase.strength), "a number from 0 to 1");
}

void checkRemap(const Check& check, const Remap& remap) {
    const RemapKeys& k = keysOf<RemapKeys>();
    check.members(k, remap);
    check.numbers(k.from, {remap.from[0], remap.from[1]});
    check.numbers(k.to, {remap.to[0], remap.to[1]});
    if (!(remap.from[0] < remap.from[1]))
        check.refuse(k.from.name, fmt::format("{}, {}", remap.from[0], remap.from[1]), "ascending numbers");
}

void checkNoise(const Check& check, const Noise& noise) {
    const NoiseKeys& k = keysOf<NoiseKeys>();
    check.members(k, noise);
    check.point(k.offset, noise.offset);
}

void checkShading(const Check& check, const SceneVolume& volume) {
    const DensityKeys& k = keysOf<DensityKeys>();
    const DensityShading& shading = volume.shading;
    if (volume.displacement) checkNoise(check, *volume.displacement);
    if (shading.noise) checkNoise(check, *shading.noise);
    if (shading.mask) checkRemap(check, shading.mask->remap);
    if (shading.edge) check.numbers(k.edge, {(*shading.edge)[0], (*shading.edge)[1]});
    if (!shading.remap) return;
    checkRemap(check, *shading.remap);
    if (shading.remap->at(0) != 0)
        check.refuse(k.remap.name, "above 0 at grid value 0", "0 there, because empty space is skipped");
}

void checkEmission(const Check& check, const Emission& emission) {
    const EmissionKeys& k = keysOf<EmissionKeys>();
    check.members(k, emission);
    if (emission.mask) checkRemap(check, emission.mask->remap);
    const auto ends = [](const Rgb& rgb) {
        return isFinite(rgb) ? std::pair(smallest(rgb), largest(rgb)) : std::pair(std::nan(""), std::nan(""));
    };
    if (!emission.blackbody) return check.ramp(k.ramp, emission.ramp, kMostLight, ends);
    check.members(keysOf<BlackbodyKeys>(), emission);
}

void checkMedium(const Check& check, const SceneVolume& volume) {
    const MediumKeys& k = keysOf<MediumKeys>();
    const Medium& medium = volume.medium;
    check.colour(k.albedo, medium.albedo, 1);
    check.colour(k.extinctionTint, medium.extinctionTint, kMostTint);
    checkPhase(check, medium.phase);
    check.members(keysOf<OctavesKeys>(), medium.octaves);
    if (volume.albedoGrid) check.members(keysOf<AlbedoGridKeys>(), *volume.albedoGrid);
    for (const Emission& emission : volume.emission) checkEmission(check, emission);
}

void checkClassified(const Check& check, const Classified& classified) {
    const ClassifiedKeys& k = keysOf<ClassifiedKeys>();
    const TransferKeys& t = keysOf<TransferKeys>();
    const std::vector<TransferPoint>& points = classified.transfer;
    for (std::size_t i = 0; i < points.size(); ++i) {
        check.members(t, points[i]);
        check.light(t.color, points[i].color);
        if (i > 0 && points[i].value < points[i - 1].value)
            check.refuse(k.transfer.name, fmt::format("{} after {}", points[i].value, points[i - 1].value),
                         "ascending values");
    }
    if (points.size() < 2) check.refuse(k.transfer.name, fmt::format("{} points", points.size()), "at least two");
    if (points.back().value <= 0) check.refuse(k.transfer.name, "without a value above 0", "a last value above 0");
    if (classify(classified, 0).extinction > 0)
        check.refuse(k.transfer.name, "above 0 at grid value 0", "extinction 0 there, because empty space is skipped");
    const auto& ramp = classified.gradientRamp;
    for (std::size_t i = 0; i < ramp.size(); ++i)
        if (!std::isfinite(ramp[i].first) || !(ramp[i].second >= 0 && ramp[i].second <= 1) ||
            (i > 0 && !(ramp[i].first > ramp[i - 1].first)))
            check.refuse(k.gradient.name, fmt::format("[{}, {}]", ramp[i].first, ramp[i].second),
                         "ascending lengths with factors from 0 to 1");
    check.members(k, classified);
    check.colour(k.albedo, classified.albedo, 1);
    if (const double most = mostScattered(classified); classified.scatters && !(most <= kMostScattered))
        check.refuse(k.albedo.name, fmt::format("{:.4g} times a colour of the transfer function", most), "at most 1");
}

void checkVolume(const Check& check, const SceneVolume& volume) {
    const DensityKeys& d = keysOf<DensityKeys>();
    check.transform(keysOf<TransformKeys>().matrix, volume.wsFromAsset);
    check.members(keysOf<FrameKeys>(), volume);
    check.members(d, volume);
    check.ramp(d.ramp, volume.ramp, std::numeric_limits<double>::max(), [](double v) { return std::pair(v, v); });
    if (volume.velocity) check.members(keysOf<VelocityKeys>(), *volume.velocity);
    if (volume.edit)
        for (const AxVariable& variable : volume.edit->variables)
            if (!variable.isFinite())
                check.refuse(variable.name, fmt::format("{}", fmt::join(variable.value, ", ")),
                             "finite numbers that fit into floats");
    checkShading(check, volume);
    checkMedium(check, volume);
    for (const HalfSpace& face : volume.clip) check.unit(keysOf<VolumeKeys>().clipPlane, face.normal);
    if (volume.classified) checkClassified(check, *volume.classified);
}

void checkOutput(const Check& check, const Scene& scene) {
    const OutputKeys& k = keysOf<OutputKeys>();
    const SceneOutput& output = scene.output;
    check.members(k, output);
    check.members(keysOf<HoldoutKeys>(), output.holdout);
    if (scene.lens && !output.deep.file.empty())
        check.refuse(k.deep.name, fmt::format("'{}'", output.deep.file), "none, since the camera has a lens");
}

}  // namespace

void checkScene(const Scene& scene) {
    const auto named = [&](const char* what, const std::string& name) {
        return Check(scene, fmt::format("{} '{}'", what, shortened(name, 60)));
    };
    checkCamera(Check(scene, "[camera]"), scene);
    for (const SceneVolume& volume : scene.volumes) checkVolume(named("volume", volume.name), volume);
    for (const SceneMesh& mesh : scene.meshes) {
        const Check check = named("mesh", mesh.name);
        check.transform(keysOf<TransformKeys>().matrix, mesh.wsFromMesh);
        check.colour(keysOf<MeshKeys>().albedo, mesh.albedo, 1);
        if (mesh.color) check.colour(keysOf<MeshKeys>().color, *mesh.color, 1);
    }
    for (const Light& light : scene.lights) {
        const Check check = named("light", light.name);
        checkLight(check, light);
        const auto shines = [&](const SceneMesh& mesh) { return mesh.name == light.area()->mesh; };
        if (light.area() && light.area()->shape == AreaShape::mesh && std::ranges::none_of(scene.meshes, shines))
            check.refuse(keysOf<LightKeys>().mesh.name, shortened(light.area()->mesh, 60), "the name of a mesh");
    }
    Check(scene, "[ambient]").light(keysOf<AmbientKeys>().color, scene.ambient);
    checkDials(scene.dials, scene.file.empty() ? "[render]" : scene.file + ": [render]");
    Check(scene, "[render]").members(keysOf<RenderKeys>(), scene);
    checkOutput(Check(scene, "[output]"), scene);
}

}  // namespace scrim
