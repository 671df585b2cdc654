// SPDX-License-Identifier: Apache-2.0
#include "drawn_scene.h"

#include "support/meshes.h"
#include "support/slides.h"

#include <scrim/image/colour.h>
#include <scrim/image/light_profile.h>
#include <scrim/image/sky_parts.h>
#include <scrim/scene/scene_reader.h>
#include <scrim/shot/assemble.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <numbers>

#include <glm/trigonometric.hpp>

namespace scrim::test {
namespace {

constexpr double kVoxel = 0.125;  // of 16 voxels, so that a volume is 2 units wide

// Keys and values, a line each, and what they amount to.
class Lines {
  public:
    explicit Lines(std::set<std::string>& parts) : m_parts(parts) {}

    void section(const char* header, const char* name) {
        m_section = name;
        line(header);
    }
    template <typename T>
    void add(const std::string& key, const T& value) {
        m_parts.insert(m_section + "." + key);
        line(fmt::format("{} = {}", key, value));
    }
    void addWord(const std::string& key, const std::string& word) {
        m_parts.insert(m_section + "." + key + "." + word);
        add(key, "\"" + word + "\"");
    }
    void note(const std::string& part) { m_parts.insert(part); }
    void line(const std::string& text) { m_text += text + "\n"; }
    const std::string& text() const { return m_text; }

  private:
    std::set<std::string>& m_parts;
    std::string m_text, m_section;
};

void addCamera(Lines& out, Draws& d) {
    d.enter(0);
    out.section("[camera]", "camera");
    const bool orthographic = d.once(0.3);
    out.addWord("type", orthographic ? "orthographic" : "perspective");
    const double reach = d.between(5, 8), azimuth = d.of({0.0, 45.0, 90.0, 30.0, 200.0, 117.0});
    const double elevation = d.of({0.0, 20.0, 45.0, -30.0, 80.0});
    const double a = glm::radians(azimuth), e = glm::radians(elevation);
    out.add("position", fmt::format("[{:.6g}, {:.6g}, {:.6g}]", reach * std::sin(a) * std::cos(e), reach * std::sin(e),
                                    reach * std::cos(a) * std::cos(e)));
    out.add("target", d.once(0.3) ? d.point(0.3) : "[0, 0, 0]");
    if (orthographic)
        out.add("height", d.between(3, 2));
    else if (d.once(0.3)) {
        out.add("focal_length", 35);
        const bool film = d.once(0.7);
        out.add("aperture", film ? "[24, 20]" : "24");
        if (film && d.once(0.6)) out.addWord("fit", d.word({"horizontal", "vertical", "fill", "overscan"}));
    } else {
        out.add("fov", d.between(30, 50));
        if (d.once(0.2)) out.addWord("fov_axis", d.word({"horizontal", "vertical", "diagonal"}));
    }
    if (d.once(0.15)) out.add("up", d.word({"[0, 0, 1]", "[1, 1, 0]", "[0, -1, 0]"}));
    if (d.once(0.15)) out.add("near", d.between(0, reach));
    if (d.once(0.1)) out.add("pixel_aspect", d.logBetween(0.5, 2));
    if (d.once(0.1)) out.add("shift", d.word({"[0.1, 0]", "[-0.05, 0.2]"}));
    if (d.once(0.1)) out.add("overscan", 1 + d.below(9));
    const int width = 36 + d.below(13), height = 36 + d.below(13);
    out.add("resolution", fmt::format("[{}, {}]", width, height));
}

void addClassified(Lines& out, Draws& d) {
    out.note("volume.classified");
    out.section("[volume.classified]", "classified");
    const double most = d.logBetween(4, 60), from = d.between(0.1, 0.4);
    out.add("transfer",
            fmt::format("[ {{ value = {:.3g}, color = {}, extinction = 0 }}, {{ value = {:.3g}, color = {}, extinction "
                        "= {:.4g} }} ]",
                        from, d.colour(), from + d.between(0.5, 0.05), d.colour(), most));
    out.note("transfer.value");
    out.note("transfer.color");
    out.note("transfer.extinction");
    out.add("ambient", d.between(0.2, 1));
    out.add("diffuse", d.between(0.7, 0));
    out.add("specular", d.between(0, 0.5));
    out.add("exponent", d.between(20, 0));
    if (d.once(0.3)) out.add("two_sided", true);
    if (d.once(0.2)) out.add("gradient", "[[0.02, 0], [0.3, 1]]");
    if (d.once(0.3)) {
        out.addWord("scattering", "full");
        out.add("albedo", d.colour());
    }
}

void addPhase(Lines& out, Draws& d) {
    const auto add = [&](const char* type, const std::string& rest) {
        out.add("phase", fmt::format("{{ type = \"{}\"{} }}", type, rest));
        out.note(std::string("phase.type.") + type);
    };
    switch (d.below(8)) {
        case 1:
        case 2:
            out.note("phase.g");
            return add("hg", fmt::format(", g = {:.3g}", d.of({0.3, 0.6, -0.5, 0.8, 0.9})));
        case 3:
            out.note("phase.g1"), out.note("phase.g2"), out.note("phase.blend");
            return add("two-lobe", fmt::format(", g1 = {:.3g}, g2 = {:.3g}, blend = {:.3g}", d.between(0.2, 0.9),
                                               d.between(0.1, -0.6), d.unit()));
        case 4:
            return add("rayleigh", "");
        case 5:
            out.note("phase.alpha");
            return add("draine", fmt::format(", g = {:.3g}, alpha = {:.3g}", d.between(0.1, 0.85), d.between(0, 8)));
        case 6:
            out.note("phase.size");
            return add("droplets", fmt::format(", size = {:.3g}", d.logBetween(0.3, 30)));
        default:
            return;
    }
}

std::string names(Draws& d, std::size_t lights) {
    std::string list;
    for (std::size_t i = 0; i < lights; ++i)
        if (d.once(0.5)) list += fmt::format("{}\"l{}\"", list.empty() ? "" : ", ", i);
    return "[" + list + "]";
}

void addTransform(Lines& out, Draws& d, double reach) {
    if (d.once(0.5)) out.add("transform.translate", d.point(reach));
    if (d.once(0.2)) out.add("transform.rotate", d.word({"[0, 0, 45]", "[90, 0, 0]", "[13, 57, 140]"}));
    if (d.once(0.2)) out.add("transform.scale", d.word({"0.75", "[1, 0.5, 1.25]", "[-1, 1, 1]"}));
}

void addVolume(Lines& out, Draws& d, std::size_t number, const std::vector<std::string>& lights, bool linked) {
    out.section("[[volume]]", "volume");
    out.line("file = \"made.vdb\"");
    out.add("name", fmt::format("\"v{}\"", number));
    if (number > 0 || d.once(0.3)) addTransform(out, d, 0.8);
    if (d.once(0.15)) out.add("lights", names(d, lights.size()));
    if (linked && d.once(0.7)) {
        const int kind = d.below(3);
        out.add("shadows", kind == 0 ? names(d, lights.size()) : kind == 1 ? "false" : "[]");
    }
    if (number > 0 && d.once(0.1)) out.add("holdout", true);
    if (d.once(0.1)) out.addWord("interpolation", d.word({"linear", "smooth"}));
    const double scale = d.of({4.0, 1.0, 10.0, 0.02, 40.0});
    const bool ramp = d.once(0.1);
    out.add("density", fmt::format("{{ scale = {:.4g}{} }}", scale, ramp ? ", ramp = [[0, 0], [1, 0.7]]" : ""));
    out.note("density.scale");
    if (ramp) out.note("density.ramp");
    if (d.once(0.2)) return addClassified(out, d);
    out.note("volume.medium");
    out.section("[volume.medium]", "medium");
    const bool grid = d.once(0.1);
    out.add("albedo", grid ? std::string("{ grid = \"Cd\" }") : d.colour());
    if (grid) out.note("albedo.grid");
    addPhase(out, d);
    if (d.once(0.15)) out.add("extinction_tint", d.colour());
    const int kind = d.of({0, 0, 1, 2});
    if (kind == 2 && !linked) {
        out.addWord("scattering", "full");
    } else if (kind == 1) {
        out.add("octaves", fmt::format("{{ count = {}, extinction = {:.3g}, contribution = {:.3g}, phase = {:.3g} }}",
                                       2 + d.below(3), d.between(0.5, 1), d.between(0.5, 0.2), d.unit()));
        for (const char* key : {"count", "extinction", "contribution", "phase"})
            out.note(std::string("octaves.") + key);
    }
    if (d.once(0.15)) {
        out.add("emission", fmt::format("{{ grid = \"glow\", scale = {:.3g} }}", d.logBetween(0.1, 4)));
        out.note("emission.scale");
    }
}

void addMesh(Lines& out, Draws& d, std::size_t number) {
    out.section("[[mesh]]", "mesh");
    out.line("file = \"made.obj\"");
    out.add("name", fmt::format("\"m{}\"", number));
    if (d.once(0.6)) addTransform(out, d, 1.2);
    out.add("holdout", !d.once(0.4));
    out.add("shadows", !d.once(0.3));
    if (d.once(0.2)) out.add("catch", true);
    if (d.once(0.7)) out.add("albedo", d.colour());
}

void addLight(Lines& out, Draws& d, std::size_t number, std::size_t meshes) {
    const std::string type = d.word({"distant", "point", "dome", "area", "spot", "area", "projector", "dome"});
    out.section("[[light]]", "light");
    out.add("name", fmt::format("\"l{}\"", number));
    out.addWord("type", type);
    out.add("color", d.colour());
    out.add("intensity", d.logBetween(1, 20));
    if (d.once(0.12)) out.add("shadows", false);
    if (d.once(0.3)) out.addWord("shadow", d.word({"auto", "buffers", "cells"}));
    if (d.once(0.15)) out.add("group", "\"together\"");
    if (d.once(0.1)) out.add("exposure", d.between(0, -2));
    if (d.once(0.1)) out.add("temperature", d.between(3000, 9000));
    const bool slide = type == "projector" || ((type == "distant" || type == "spot") && d.once(0.2));
    const std::string shape =
        type != "area" ? "" : d.word({"rectangle", "disk", "sphere", "cylinder", meshes > 0 ? "mesh" : "sphere"});
    const std::string place = d.point(d.of({3.0, 1.5, 8.0, 0.5})), way = d.direction();
    if (type != "dome" && type != "distant" && shape != "mesh") out.add("position", place);
    if (type == "distant" || type == "spot" || type == "projector" || shape == "rectangle" || shape == "disk" ||
        shape == "cylinder")
        out.add("direction", way);
    if (type == "distant" && slide) out.add("position", d.point(0.5));
    if (type == "distant" && !slide && d.once(0.4)) out.add("angle", d.of({5.0, 0.5, 40.0, 120.0}));
    if (type == "dome" && d.once(0.4)) {
        const bool whole = d.once(0.5);
        if (!whole && number % 2 == 1)  // without a draw, which would change all scenes that were known before
            out.add("sky", "{ sun_elevation = 40 }");
        else
            out.add("texture", whole ? "{ file = \"made.exr\", split = false }" : "{ file = \"made.exr\" }");
        out.note("light.dome.picture");
        if (d.once(0.4)) out.add("rotation", d.between(0, 360));
    }
    if (type == "area") {
        out.addWord("shape", shape);
        const double size = d.of({0.8, 0.2, 2.5});
        if (shape == "rectangle" || shape == "cylinder") out.add("width", size);
        if (shape == "rectangle") out.add("height", d.once(0.3) ? 0.3 * size : size);
        if (shape == "disk" || shape == "sphere" || shape == "cylinder") out.add("radius", 0.5 * size);
        if (shape == "mesh") out.add("mesh", "\"m0\"");
        if (d.once(0.3)) out.add("normalize", true);
        if ((shape == "rectangle" || shape == "disk") && d.once(0.3)) out.add("spread", d.of({90.0, 45.0, 20.0}));
    }
    if (type == "point" || type == "spot" || type == "projector") {
        if (d.once(0.5)) out.add("radius", d.between(0, 0.4));
        if (d.once(0.35)) out.addWord("decay", "none");
    }
    if (type == "spot") {
        out.add("cone", d.between(45, 120));
        out.add("blend", d.between(0.15, 1));
    }
    if ((type == "point" || type == "spot") && d.once(0.15)) {
        out.add("ies", "\"made.ies\"");
        if (type == "point") out.add("direction", d.direction());
    }
    if ((type == "area" || type == "dome" || type == "distant") && d.once(0.8)) out.add("samples", d.of({12, 24, 6}));
    if (!slide) return;
    out.add("slide.file", "\"made.png\"");
    if (type == "distant")
        out.add("slide.width", d.logBetween(2, 0.7));
    else
        out.add("slide.fov", d.logBetween(30, 90));
    if (d.once(0.3)) out.add("slide.roll", d.between(0, 360));
    if (type != "projector" && d.once(0.5)) out.addWord("slide.outside", d.word({"black", "clamp", "repeat"}));
}

void addDials(Lines& out, Draws& d) {
    d.enter(1);
    if (d.once(0.3)) {
        out.section("[ambient]", "ambient");
        out.add("color", d.colour());
        if (d.once(0.5)) out.add("intensity", d.between(1, 0.1));
    }
    out.section("[render]", "render");
    const double texel = d.of({1.0, 0.7, 1.4});
    out.add("texel", texel);
    out.add("sheet_thickness", d.once(0.3) ? 1.5 : texel);
    out.add("light_error", d.of({0.02, 0.05}));
    if (d.once(0.1)) out.add("footprint_steps", 16);
    if (d.once(0.2)) out.add("shadow_texel", d.of({1.0, 0.5, 2.0}));
    if (d.once(0.15)) out.add("max_slant", d.of({60.0, 30.0, 45.0, 75.0}));
    if (d.once(0.15)) out.add("cross_fade", d.of({2.0, 0.0, 10.0}));
    if (d.once(0.15)) out.add("opacity_cutoff", d.of({1e-3, 0.0, 0.05}));
    if (d.once(0.1)) out.add("antialias", 2);
    if (d.once(0.4)) out.add("light_cell", d.of({1.0, 0.5, 2.0}));
    if (d.once(0.5)) out.add("scatter_cell", d.of({1.0, 2.0}));
    if (d.once(0.3)) out.add("scatter_directions", d.of({64, 128}));
    out.add("scatter_error", d.once(0.3) ? 0.002 : 0.005);
    if (d.once(0.15)) out.addWord("kernel", d.word({"linear", "gaussian", "bspline"}));
    if (d.once(0.1)) out.addWord("splat", "per-view");
    if (d.once(0.4)) out.addWord("shade", d.word({"pixel", "texel"}));
    if (d.once(0.08)) out.addWord("sheets", "image-aligned");
    if (d.once(0.1)) out.addWord("shadow_filter", "nearest");
    if (d.once(0.1)) out.addWord("shadow_plane", "image");
    if (d.once(0.1)) out.addWord("simd", d.word({"sse4", "avx2"}));
}

void addOutput(Lines& out, Draws& d) {
    d.enter(2);
    const std::vector<std::string> known{"light",         "ambient", "emission", "albedo", "depth",
                                         "transmittance", "volume",  "motion",   "direct", "indirect"};
    std::string list;
    for (const std::string& layer : known)
        if (d.once(0.2)) {
            list += fmt::format("{}\"{}\"", list.empty() ? "" : ", ", layer);
            out.note("layer." + layer);
        }
    const bool deep = d.once(0.15);
    if (list.empty() && !deep) return;
    out.section("[output]\ntype = \"float\"", "output");
    if (!list.empty()) out.add("layers", "[" + list + "]");
    if (!deep) return;
    out.add("deep", "\"made.deep.exr\"");
    out.add("deep_tolerance", d.of({0.0, 0.01}));
}

double shapeAt(int kind, const Vec3& p, std::uint32_t& noise) {
    noise = noise * 1664525 + 1013904223;
    const double random = double(noise >> 8) / 16777216.0, r = glm::length(p) / 8;
    switch (kind) {
        case 0:
            return std::max(1 - r * r, 0.0);
        case 1:
            return largest(glm::abs(p)) < 6 ? 1 : 0;
        case 2:
            return std::max((1 - r) * (0.4 + 1.2 * random), 0.0);
        case 3:
            return std::max(0.5 + 0.5 * std::sin(0.9 * p.x) * std::cos(0.7 * p.y + 0.4 * p.z) - r * r, 0.0);
        case 4:
            return std::abs(p.y) < 2 ? 1 : 0;
        default:
            return p == Vec3(-0.5) ? 1 : 0;  // one voxel
    }
}

// 16^3 voxels around the origin: a ball, a box, noise, bumps, a slab or one voxel; now and then a tile beside them.
std::shared_ptr<const SparseField> madeField(Draws& d, const char* name) {
    auto field = std::make_shared<SparseField>();
    auto values = std::make_shared<std::vector<float>>();
    field->name = name;
    const int kind = d.of({0, 1, 2, 3, 3, 4, 5});
    for (int axis = 0; axis < 3; ++axis) field->wsFromIs[axis][axis] = kVoxel;
    if (d.once(0.1)) field->wsFromIs[1][1] = 1.6 * kVoxel;
    if (d.once(0.08)) field->wsFromIs[1][0] = 0.4 * kVoxel;
    for (int axis = 0; axis < 3; ++axis) field->wsFromIs[3][axis] = 0.5 * kVoxel;
    std::uint32_t noise = static_cast<std::uint32_t>(d.below(1000)) + 1;
    for (int b = 0; b < 8; ++b) {
        const Int3 origin(8 * (b / 4) - 8, 8 * (b / 2 % 2) - 8, 8 * (b % 2) - 8);
        std::vector<float> block(kBlockVoxels);
        bool any = false;
        for (int x = 0; x < 8; ++x)
            for (int y = 0; y < 8; ++y)
                for (int z = 0; z < 8; ++z) {
                    const double v = shapeAt(kind, Vec3(origin + Int3(x, y, z)) + 0.5, noise);
                    block[std::size_t(blockOffset(x, y, z))] = static_cast<float>(v);
                    any = any || v > 0;
                    field->activeVoxels += v > 0 ? 1 : 0;
                    field->maxValue = std::max(field->maxValue, static_cast<float>(v));
                }
        if (!any) continue;
        field->blockOrigins.push_back(origin);
        values->insert(values->end(), block.begin(), block.end());
    }
    if (d.once(0.1)) {
        field->tiles.push_back({Int3(8, 0, -8), 8, field->maxValue});
        field->activeVoxels += kBlockVoxels;
    }
    field->blockValues = std::shared_ptr<const float>(values, values->data());
    return field;
}

std::shared_ptr<const Texture> madePicture(Draws& d, int width, int height, double sun) {
    const Rgb low(d.between(1, 0.2), d.between(1, 0.2), d.between(1, 0.2)), high(d.unit(), d.unit(), 1);
    return makeTexture(width, height, [&](int x, int y) {
        const double t = double(y) / height;
        if (sun > 0 && x == width / 3 && y == height / 4) return Rgb(sun);
        return (1 - t) * low + t * high * (x % 2 == 0 ? 1.0 : 0.7);
    });
}

// A sky as a clear one is: its sun, redder below, is not in the picture.
std::shared_ptr<const SkyParts> skyPartsBeside(const std::shared_ptr<const Texture>& picture, double brightness) {
    SkyParts parts{{}, picture};
    if (brightness > 0) {
        const Rgb low(6, 3, 1), high(6, 6, 6);
        const double angle = 2, solidAngle = 2 * std::numbers::pi * (1 - std::cos(glm::radians(0.5 * angle)));
        parts.suns.push_back({0.5, 0.3, angle, 0.5 * (low + high), {low / solidAngle, high / solidAngle}});
    }
    return std::make_shared<const SkyParts>(parts);
}

std::shared_ptr<const LightProfile> madeProfile() {
    FilePhotometry file;
    file.vertical = {0, 30, 60, 90, 180};
    file.horizontal = {0};
    file.candela = {10, 9, 4, 1, 0};
    return std::make_shared<const LightProfile>(file);
}

void loadLights(ViewScene& view, const std::vector<Solid>& solids, Draws& d) {
    for (Light& light : view.lights) {
        if (light.slide) {
            const double sun = light.dome() && d.once(0.5) ? 400 : 0;
            light.slide->image =
                light.dome() ? madePicture(d, 24, 12, light.slide->sky ? 0 : sun) : madePicture(d, 7, 5, 0);
            if (light.slide->sky)
                light.slide->parts = skyPartsBeside(light.slide->image, sun);
            else if (light.dome() && light.slide->split)
                light.slide->parts = std::make_shared<const SkyParts>(skyParts(*light.slide->image));
        }
        if (light.luminaire) light.luminaire->profile = madeProfile();
        if (light.area() && light.area()->shape == AreaShape::mesh && !solids.empty())
            shineFrom(light, *solids.front().mesh, solids.front().wsFromMesh);
    }
}

}  // namespace

DrawnScene drawnScene(const std::vector<double>& numbers) {
    static const ColourConfig colour = ColourConfig::open("");
    Draws d(numbers);
    DrawnScene out;
    Lines lines(out.parts);
    const std::size_t firstVolume = 3, firstMesh = firstVolume + kMostVolumes, firstLight = firstMesh + kMostMeshes;
    const auto present = [&](std::size_t first, std::size_t most, double share) {
        std::vector<std::size_t> there;
        for (std::size_t i = 0; i < most; ++i) {
            d.enter(first + i);
            if (d.once(share)) there.push_back(first + i);
        }
        return there;
    };
    std::vector<std::size_t> volumes = present(firstVolume, kMostVolumes, 0.5);
    if (volumes.empty()) volumes.push_back(firstVolume);
    const std::vector<std::size_t> meshes = present(firstMesh, kMostMeshes, 0.3);
    const std::vector<std::size_t> lights = present(firstLight, kMostLights, 0.5);
    std::vector<std::string> lightNames;
    for (std::size_t i = 0; i < lights.size(); ++i) lightNames.push_back(fmt::format("l{}", i));
    addCamera(lines, d);
    const bool linked = d.once(0.35);  // volumes that do not cast all shadows: not beside full scattering
    const auto open = [&](std::size_t section) {
        d.enter(section);
        d.unit();  // its presence
    };
    for (std::size_t i = 0; i < volumes.size(); ++i) open(volumes[i]), addVolume(lines, d, i, lightNames, linked);
    for (std::size_t i = 0; i < meshes.size(); ++i) open(meshes[i]), addMesh(lines, d, i);
    for (std::size_t i = 0; i < lights.size(); ++i) open(lights[i]), addLight(lines, d, i, meshes.size());
    addDials(lines, d);
    addOutput(lines, d);
    out.toml = lines.text();

    const Scene scene = readScene({"drawn.toml", "", out.toml}, 1, {}, colour);
    std::vector<VolumeFields> fields;
    for (std::size_t i = 0; i < scene.volumes.size(); ++i) {
        // Fields have numbers of their own, at the end of the volume's section.
        VolumeFields& of = fields.emplace_back();
        std::vector<double> own(
            numbers.begin() +
                std::ptrdiff_t(std::min(numbers.size(), volumes[i] * Draws::kPerSection + Draws::kPerSection - 16)),
            numbers.begin() + std::ptrdiff_t(std::min(numbers.size(), (volumes[i] + 1) * Draws::kPerSection)));
        Draws f(own);
        f.enter(0);
        of.density = madeField(f, "density");
        if (scene.volumes[i].albedoGrid) of.albedo = {of.density, madeField(f, "g"), of.density};
        for (std::size_t e = 0; e < scene.volumes[i].emission.size(); ++e) of.emission.push_back(madeField(f, "glow"));
    }
    out.view = assemble(scene, fields, {}, std::size_t{1} << 30);
    if (!scene.output.deep.file.empty()) out.view.deep = ViewDeep{scene.output.deep.tolerance};
    std::vector<Solid> solids;
    for (std::size_t i = 0; i < scene.meshes.size(); ++i) {
        const SceneMesh& mesh = scene.meshes[i];
        open(meshes[i]);
        d.enter(meshes[i]);
        const double kind = numbers.size() > (meshes[i] + 1) * Draws::kPerSection - 1
                                ? numbers[(meshes[i] + 1) * Draws::kPerSection - 1]
                                : 0;
        const auto shape = kind < 0.4   ? squareMesh({0, -1.2, 0}, {0, 1, 0}, 1.5)
                           : kind < 0.7 ? ballMesh(Vec3(0.4, 0.2, 0), 0.5, 12)
                                        : roomMesh(Vec3(-1.4), Vec3(1.4), 2, Vec2(0.25), Vec2(0.75));
        solids.push_back({mesh.name, shape, mesh.wsFromMesh, mesh.holdout, mesh.shadows, mesh.catches, mesh.albedo});
    }
    d.enter(2);
    loadLights(out.view, solids, d);
    if (!solids.empty()) out.view.solids = std::make_shared<const Solids>(solids);
    for (const Light& light : out.view.lights)
        if (light.area()) out.parts.insert("area." + std::to_string(static_cast<int>(light.area()->shape)));
    return out;
}

const std::vector<std::pair<std::string, std::string>>& undrawnKeys() {
    static const std::string files = "of files, which are read before there is a view";
    static const std::string time = "of time and lenses: moments are whole renders (truth/effects, unit/shot)";
    static const std::string behind = "behind the volumes, which it does not change (truth/effects/backdrop)";
    static const std::string same = "another way to write what is drawn";
    static const std::string levels = "of volumes whose cells differ in size (unit/verify/promise)";
    static const std::vector<std::pair<std::string, std::string>> keys{{"scene.", same},
                                                                       {"orbit.", same},
                                                                       {"camera.matrix", same},
                                                                       {"camera.orbit", same},
                                                                       {"camera.exr", files},
                                                                       {"camera.ndc", files},
                                                                       {"camera.shutter", time},
                                                                       {"camera.fstop", time},
                                                                       {"camera.world_unit", time},
                                                                       {"camera.lens_radius", time},
                                                                       {"camera.focus_distance", time},
                                                                       {"slide.colorspace", files},
                                                                       {"slide.height", same},
                                                                       {"texture.", files},
                                                                       {"sky.", files},
                                                                       {"light.target", same},
                                                                       {"light.orbit", same},
                                                                       {"light.up", same},
                                                                       {"ambient.", same},
                                                                       {"keys.", time},
                                                                       {"colour.", same},
                                                                       {"render.quality", same},
                                                                       {"render.tolerance", same},
                                                                       {"render.lod", files},
                                                                       {"render.light_cell_others", levels},
                                                                       {"render.shutter_samples", time},
                                                                       {"transform.matrix", same},
                                                                       {"frame.", files},
                                                                       {"density.grid", files},
                                                                       {"density.remap", files},
                                                                       {"density.edge", files},
                                                                       {"density.mask", files},
                                                                       {"density.noise", files},
                                                                       {"density.noise_mode", files},
                                                                       {"velocity.", time},
                                                                       {"points.", files},
                                                                       {"albedo.", files},
                                                                       {"blackbody.", same},
                                                                       {"emission.grid", files},
                                                                       {"emission.colors", files},
                                                                       {"emission.ramp", same},
                                                                       {"emission.range", same},
                                                                       {"emission.mask", files},
                                                                       {"medium.transparency", same},
                                                                       {"medium.transparency_depth", same},
                                                                       {"medium.blackbody", same},
                                                                       {"classified.window", same},
                                                                       {"classified.window_zero", same},
                                                                       {"mesh.file", files},
                                                                       {"mesh.color", behind},
                                                                       {"light.visible", behind},
                                                                       {"grids.", files},
                                                                       {"remap.", files},
                                                                       {"mask.", files},
                                                                       {"noise.", files},
                                                                       {"volume.file", files},
                                                                       {"volume.grids", files},
                                                                       {"volume.frame", files},
                                                                       {"volume.source", files},
                                                                       {"volume.parameters", files},
                                                                       {"volume.clip", files},
                                                                       {"volume.clip_plane", files},
                                                                       {"volume.resample", files},
                                                                       {"volume.detail", files},
                                                                       {"volume.ax", files},
                                                                       {"volume.ax_file", files},
                                                                       {"volume.displacement", files},
                                                                       {"volume.velocity", time},
                                                                       {"volume.points", files},
                                                                       {"preview.", files},
                                                                       {"holdout.", files},
                                                                       {"files.", files},
                                                                       {"output.", files}};
    return keys;
}

}  // namespace scrim::test
