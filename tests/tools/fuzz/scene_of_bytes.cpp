// SPDX-License-Identifier: Apache-2.0
#include "scene_of_bytes.h"

#include <scrim/image/colour.h>
#include <scrim/shot/assemble.h>
#include <scrim/scene/scene_reader.h>

#include <array>
#include <cmath>
#include <iterator>
#include <memory>
#include <vector>

#include <fmt/format.h>

namespace scrim::fuzz {
namespace {

constexpr std::size_t kMemoryLimit = std::size_t{256} << 20;
constexpr int kMostBlocks = 4;

/// The bytes, as choices.
class Choices {
  public:
    Choices(const std::uint8_t* data, std::size_t size) : m_data(data), m_end(data + size) {}

    unsigned byte() { return m_data == m_end ? 0 : *m_data++; }
    int below(int n) { return static_cast<int>(byte()) % n; }
    bool once(int in) { return below(in) == in - 1; }
    double unit() {
        const unsigned high = byte();
        return (high * 256 + byte()) / 65535.0;
    }
    double between(double a, double b) { return a + (b - a) * unit(); }
    double logBetween(double a, double b) { return a * std::pow(b / a, unit()); }
    template <std::size_t N>
    const char* word(const char* const (&words)[N]) {
        return words[below(static_cast<int>(N))];
    }
    std::string point(double reach) {
        const double x = between(-reach, reach), y = between(-reach, reach), z = between(-reach, reach);
        return fmt::format("[{}, {}, {}]", x, y, z);
    }
    std::string colour() {
        const double r = unit(), g = unit(), b = unit();
        return fmt::format("[{}, {}, {}]", r, g, b);
    }

  private:
    const std::uint8_t *m_data, *m_end;
};

/// Keys and values, a line each. (Compilers order the arguments of a call as they like: a choice stands alone.)
class Lines {
  public:
    template <typename T>
    void add(const char* key, const T& value) {
        m_text += fmt::format("{} = {}\n", key, value);
    }
    void addWord(const char* key, const char* word) { m_text += fmt::format("{} = \"{}\"\n", key, word); }
    void line(const std::string& text) { m_text += text + "\n"; }
    const std::string& text() const { return m_text; }

  private:
    std::string m_text;
};

void addCamera(Lines& out, Choices& c) {
    const bool orthographic = c.once(3);
    out.line("[camera]");
    out.addWord("type", orthographic ? "orthographic" : "perspective");
    out.add("target", c.point(8));
    const double reach = c.logBetween(40, 4);
    out.add("position", c.point(reach));
    if (orthographic)
        out.add("height", c.logBetween(30, 0.5));
    else
        out.add("fov", c.between(40, 150));
    if (c.once(4)) out.add("near", c.between(0, 40));
    if (c.once(4)) out.add("up", c.point(1));
    if (c.once(6)) out.add("pixel_aspect", c.logBetween(0.5, 2));
    const int width = 1 + (c.below(24) + 15) % 24, height = 1 + (c.below(24) + 11) % 24;
    out.add("resolution", fmt::format("[{}, {}]", width, height));
}

void addClassified(Lines& out, Choices& c) {
    std::string points = "[ { value = 0, extinction = 0 }";
    double value = 0;
    for (int i = 1 + c.below(4); i > 0; --i) {
        value += c.once(4) ? 0 : c.between(0.1, 0.5);
        const double most = c.logBetween(0.5, 50);
        const bool clear = c.once(3) || value == 0;  // a step at 0 would give empty space an extinction
        points += fmt::format(", {{ value = {}, color = {}, extinction = {} }}", value, c.colour(), clear ? 0 : most);
    }
    out.line("[volume.classified]");
    out.add("transfer", points + fmt::format(", {{ value = {}, extinction = 1 }} ]", value + 0.1));
    for (const char* part : {"ambient", "diffuse", "specular"}) out.add(part, c.unit());
    out.add("exponent", c.between(20, 0));
    out.add("two_sided", c.once(2));
    if (!c.once(5)) return;
    out.addWord("scattering", "full");
    out.add("albedo", c.colour());
}

void addPhase(Lines& out, Choices& c) {
    switch (c.below(7)) {
        case 0:
            return out.add("phase", fmt::format("{{ type = \"hg\", g = {} }}", c.between(-0.95, 0.95)));
        case 1:
            return out.add("phase", fmt::format("{{ type = \"two-lobe\", g1 = {}, g2 = {}, blend = {} }}",
                                                c.between(-0.95, 0.95), c.between(-0.95, 0.95), c.unit()));
        case 2:
            return out.add("phase", "{ type = \"rayleigh\" }");
        case 3:
            return out.add("phase", fmt::format("{{ type = \"draine\", g = {}, alpha = {} }}", c.between(-0.95, 0.95),
                                                c.between(0, 250)));
        case 4:
            return out.add("phase", fmt::format("{{ type = \"droplets\", size = {} }}", c.logBetween(0.01, 50)));
        default:
            return;  // isotropic
    }
}

// `edges`: how much larger voxels are; empty: by choice.
void addVolume(Lines& out, Choices& c, const std::string& edges = "") {
    out.line("[[volume]]\nfile = \"made.vdb\"");
    const double scale = c.once(5) ? c.logBetween(1e-30, 1e30) : c.logBetween(0.1, 20);
    out.add("density",
            fmt::format("{{ scale = {}{} }}", scale, c.once(5) ? ", ramp = [[0, 0], [0.3, 1], [0.6, 0.2]]" : ""));
    if (!edges.empty()) {
        out.add("transform.scale", edges);
        out.add("transform.translate", c.point(4));
    } else if (c.once(3)) {
        out.add("transform.rotate", c.point(180));
        const double x = c.logBetween(1, 4), y = c.logBetween(1, 0.25), z = c.logBetween(1, 2);
        out.add("transform.scale", fmt::format("[{}, {}, {}]", x, y, z));
        const double far = c.once(4) ? 1e5 : 10;
        out.add("transform.translate", c.point(far));
    }
    if (c.once(3)) return addClassified(out, c);
    out.line("[volume.medium]");
    const bool grid = c.once(6);
    out.add("albedo", grid ? std::string("{ grid = \"Cd\" }") : c.colour());
    addPhase(out, c);
    if (c.once(4)) out.add("extinction_tint", c.colour());
    if (c.once(5))
        out.addWord("scattering", "full");
    else if (c.once(4))
        out.add("octaves", fmt::format("{{ count = {}, extinction = {}, contribution = {}, phase = {} }}",
                                       1 + c.below(4), c.unit(), c.unit(), c.unit()));
    if (c.once(5)) out.add("emission", fmt::format("{{ grid = \"glow\", scale = {} }}", c.logBetween(0.1, 10)));
}

void addLight(Lines& out, Choices& c, int number) {
    const std::string type = c.word({"distant", "point", "spot", "projector"});
    const bool distant = type == "distant", projector = type == "projector", slide = projector || c.once(5);
    out.line("[[light]]");
    out.add("name", fmt::format("\"l{}\"", number));
    out.addWord("type", type.c_str());
    out.add("color", c.colour());
    out.add("intensity", c.once(6) ? c.logBetween(1e-30, 1e30) : c.logBetween(1, 100));
    out.add("shadows", !c.once(5));
    if (!distant || slide) {
        const double reach = c.logBetween(30, 3);
        out.add("position", c.point(reach));
    }
    if (!distant) {
        out.add("radius", c.once(4) ? 0.0 : c.between(0.1, 5));
        if (c.once(3)) out.addWord("decay", "none");
    }
    if (distant || slide || type == "spot") out.add("direction", c.point(1));
    if (type == "spot") {
        out.add("cone", c.between(60, 179));
        out.add("blend", c.unit());
    }
    if (!slide) return;
    out.addWord("slide.file", "made.png");
    if (distant)
        out.add("slide.width", c.logBetween(20, 0.5));
    else
        out.add("slide.fov", c.between(40, 170));
    out.add("slide.roll", c.between(0, 360));
    if (!projector) out.addWord("slide.outside", c.word({"black", "clamp", "repeat"}));
}

// A lamp with a surface, or a sky.
void addExtended(Lines& out, Choices& c, int number) {
    out.line("[[light]]");
    out.add("name", fmt::format("\"x{}\"", number));
    out.add("color", c.colour());
    out.add("intensity", c.logBetween(0.1, 10));
    out.add("shadows", !c.once(5));
    if (c.once(3)) return out.addWord("type", "dome");
    const std::string shape = c.word({"rectangle", "disk", "sphere", "cylinder"});
    out.addWord("type", "area");
    out.addWord("shape", shape.c_str());
    out.add("position", c.point(20));
    if (shape != "sphere") out.add("direction", c.point(1));
    if (shape == "rectangle" || shape == "cylinder") out.add("width", c.logBetween(0.3, 20));
    out.add(shape == "rectangle" ? "height" : "radius", c.logBetween(0.3, 8));
    if (c.once(4)) out.add("samples", 1 + c.below(8));
    out.addWord("shadow", c.word({"auto", "auto", "buffers", "cells"}));
}

// What came later than the corpus: lamps and skies, and a volume of much larger or smaller voxels.
void addMore(Lines& out, Choices& c) {
    if (c.once(2)) {
        const double scale = c.below(2) == 0 ? 0.125 : 8;
        addVolume(out, c, fmt::format("[{0}, {0}, {0}]", scale));
    }
    for (int i = c.below(3); i > 0; --i) addExtended(out, c, i);
}

void addDials(Lines& out, Choices& c) {
    // Fine tables of footprints in coarse texels take seconds.
    constexpr double kCoarsest = 4;
    out.line("[render]");
    out.add("footprint_steps", 4 << c.below(3));
    if (c.once(2)) out.add("texel", c.logBetween(0.3, kCoarsest));
    if (c.once(2)) out.add("sheet_thickness", c.logBetween(0.2, kCoarsest));
    if (c.once(3)) out.add("shadow_texel", c.logBetween(0.3, 64));
    if (c.once(4)) out.add("max_slant", c.between(10, 85));
    if (c.once(4)) out.add("cross_fade", c.between(0, 20));
    if (c.once(4)) out.add("opacity_cutoff", c.between(0, 0.5));
    if (c.once(4)) out.add("lod", c.logBetween(0.1, 64));
    if (c.once(6)) out.add("antialias", 1 + c.below(3));
    if (c.once(3)) out.add("scatter_cell", c.logBetween(0.5, 4));
    if (c.once(4)) out.add("scatter_directions", 64 << c.below(3));
    out.addWord("kernel", c.word({"linear", "gaussian", "bspline"}));
    out.addWord("splat", c.word({"shared", "shared", "per-view"}));
    out.addWord("shade", c.word({"auto", "texel", "pixel"}));
    out.addWord("sheets", c.word({"half-way", "image-aligned"}));
    out.addWord("shadow_filter", c.word({"bilinear", "nearest"}));
    out.addWord("shadow_plane", c.word({"light", "image"}));
    out.addWord("simd", c.word({"auto", "sse4", "avx2", "avx512"}));
}

/// Some blocks around the origin, of one value, of noise or of lone voxels; a tile now and then; voxels of any shape.
std::shared_ptr<const SparseField> madeField(Choices& c) {
    auto field = std::make_shared<SparseField>();
    auto values = std::make_shared<std::vector<float>>();
    field->name = "density";
    for (int axis = 0; axis < 3; ++axis) field->wsFromIs[axis][axis] = c.once(4) ? c.logBetween(0.5, 2) : 1.0;
    if (c.once(6)) field->wsFromIs[1][0] = c.between(-0.5, 0.5);
    const int blocks = c.once(8) ? 0 : 1 + c.below(kMostBlocks);
    const int pattern = c.below(3);
    const auto most = static_cast<float>(c.once(5) ? c.logBetween(1e-30, 1e30) : c.logBetween(1, 0.01));
    std::uint32_t noise = c.byte() + 1;
    for (int b = 0; b < blocks; ++b) {
        field->blockOrigins.push_back(Int3(8 * (b / 2) - 8, 8 * (b % 2) - 8, 8 * (c.below(3) - 1)));
        for (int i = 0; i < kBlockVoxels; ++i) {
            noise = noise * 1664525 + 1013904223;
            const float random = static_cast<float>(noise >> 8) / 16777216.0f;
            values->push_back(most * (pattern == 0 ? 1 : pattern == 1 ? random : random > 0.98f ? 1.0f : 0.0f));
            field->activeVoxels += values->back() > 0;
        }
    }
    if (c.once(4)) {
        field->tiles.push_back({Int3(8 * (c.below(3) - 1), 8, 0), 8, most});
        field->activeVoxels += kBlockVoxels;
    }
    field->blockValues = std::shared_ptr<const float>(values, values->data());
    field->maxValue = field->activeVoxels > 0 ? most : 0;
    return field;
}

std::shared_ptr<const Texture> madePicture(Choices& c) {
    const int width = 1 + c.below(9), height = 1 + c.below(9);
    Image image = emptyImage({0, 0, width, height});
    for (float& value : image.rgba) value = static_cast<float>(c.byte()) / 255;
    return std::make_shared<Texture>(image);
}

}  // namespace

ByteScene sceneOfBytes(const std::uint8_t* data, std::size_t size) {
    static const ColourConfig colour = ColourConfig::open("");
    Choices c(data, size);
    ByteScene out;
    Lines lines;
    addCamera(lines, c);
    for (int i = 1 + (c.once(4) ? c.below(3) : 0); i > 0; --i) addVolume(lines, c);
    for (int i = (c.below(5) + 1) % 5; i > 0; --i) addLight(lines, c, i);
    // Inputs that end so say more, from their end on.
    if (const std::vector<std::uint8_t> back(std::reverse_iterator(data + size), std::reverse_iterator(data));
        !back.empty() && back.front() == 'X') {
        Choices more(back.data() + 1, back.size() - 1);
        addMore(lines, more);
    }
    if (c.once(2)) {
        lines.line("[ambient]");
        lines.add("color", c.colour());
    }
    addDials(lines, c);
    if (c.once(3)) {
        lines.line("[output]\ntype = \"float\"");
        lines.add("layers", c.once(2) ? "[\"light\", \"depth\", \"transmittance\"]"
                                      : "[\"light\", \"ambient\", \"emission\", \"albedo\"]");
    }
    out.toml = lines.text();

    const Scene scene = readScene({"fuzz.toml", "", out.toml}, 1, {}, colour);
    std::vector<VolumeFields> fields;
    for (const SceneVolume& volume : scene.volumes) {
        VolumeFields& of = fields.emplace_back();
        of.density = madeField(c);
        if (volume.albedoGrid) of.albedo = {madeField(c), of.density, of.density};
        for (std::size_t i = 0; i < volume.emission.size(); ++i) of.emission.push_back(madeField(c));
    }
    out.view = assemble(scene, fields, {}, kMemoryLimit);
    for (Light& light : out.view.lights)
        if (light.slide) light.slide->image = madePicture(c);
    return out;
}

}  // namespace scrim::fuzz
