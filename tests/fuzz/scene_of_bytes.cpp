// SPDX-License-Identifier: Apache-2.0
#include "scene_of_bytes.h"

#include <scrim/image/colour.h>
#include <scrim/render/assemble.h>
#include <scrim/scene/scene_reader.h>

#include <array>
#include <cmath>
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
    double unit() { return (byte() * 256 + byte()) / 65535.0; }
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

std::string cameraText(Choices& c) {
    const bool orthographic = c.once(3);
    std::string text = fmt::format("[camera]\ntype = \"{}\"\n", orthographic ? "orthographic" : "perspective");
    text += fmt::format("target = {}\nposition = {}\n", c.point(8), c.point(c.logBetween(40, 4)));
    text += orthographic ? fmt::format("height = {}\n", c.logBetween(30, 0.5)) : fmt::format("fov = {}\n", c.between(40, 150));
    text += fmt::format("near = {}\n", c.once(4) ? c.between(0, 40) : 0.0);
    if (c.once(4)) text += fmt::format("up = {}\n", c.point(1));
    if (c.once(6)) text += fmt::format("pixel_aspect = {}\n", c.logBetween(0.5, 2));
    return text + fmt::format("resolution = [{}, {}]\n", 1 + (c.below(24) + 15) % 24, 1 + (c.below(24) + 11) % 24);
}

std::string transferText(Choices& c) {
    std::string text = "transfer = [ { value = 0, extinction = 0 }";
    double value = 0;
    for (int i = 1 + c.below(4); i > 0; --i) {
        value += c.once(4) ? 0 : c.between(0.1, 0.5);
        // A step at 0 would give empty space an extinction.
        const double extinction = value > 0 ? c.logBetween(0.5, 50) * (c.once(3) ? 0 : 1) : 0;
        text += fmt::format(", {{ value = {}, color = {}, extinction = {} }}", value, c.colour(), extinction);
    }
    text += fmt::format(", {{ value = {}, extinction = 1 }} ]\n", value + 0.1);
    return text + fmt::format("ambient = {}\ndiffuse = {}\nspecular = {}\nexponent = {}\ntwo_sided = {}\n", c.unit(),
                              c.unit(), c.unit(), c.between(20, 0), c.once(2));
}

std::string volumeText(Choices& c) {
    std::string text = "[[volume]]\nfile = \"made.vdb\"\n";
    const double scale = c.once(5) ? c.logBetween(1e-30, 1e30) : c.logBetween(0.1, 20);
    text += fmt::format("density = {{ scale = {}{} }}\n", scale, c.once(5) ? ", ramp = [[0, 0], [0.3, 1], [0.6, 0.2]]" : "");
    if (c.once(3)) {
        const double far = c.once(4) ? 1e5 : 10;
        text += fmt::format("transform = {{ rotate = {}, scale = [{}, {}, {}], translate = {} }}\n", c.point(180),
                            c.logBetween(1, 4), c.logBetween(1, 0.25), c.logBetween(1, 2), c.point(far));
    }
    if (c.once(3)) return text + "[volume.classified]\n" + transferText(c);
    text += fmt::format("[volume.medium]\nalbedo = {}\n", c.colour());
    if (c.once(2)) text += fmt::format("phase = {{ type = \"hg\", g = {} }}\n", c.between(-0.95, 0.95));
    return text;
}

std::string lightText(Choices& c, int i) {
    const char* type = c.word({"distant", "point", "spot", "projector"});
    const bool distant = type[0] == 'd';
    const bool projector = std::string(type) == "projector", slide = projector || c.once(5);
    std::string text = fmt::format("[[light]]\nname = \"l{}\"\ntype = \"{}\"\n", i, type);
    text += fmt::format("color = {}\nintensity = {}\nshadows = {}\n", c.colour(),
                        c.once(6) ? c.logBetween(1e-30, 1e30) : c.logBetween(1, 100), !c.once(5));
    if (!distant || slide) text += fmt::format("position = {}\n", c.point(c.logBetween(30, 3)));
    if (!distant) {
        text += fmt::format("radius = {}\n", c.once(4) ? 0.0 : c.between(0.1, 5));
        if (c.once(3)) text += "decay = \"none\"\n";
    }
    if (distant || slide || std::string(type) == "spot") text += fmt::format("direction = {}\n", c.point(1));
    if (std::string(type) == "spot") text += fmt::format("cone = {}\nblend = {}\n", c.between(60, 179), c.unit());
    if (slide)
        text += fmt::format("slide = {{ file = \"made.png\", {} = {}, roll = {}{} }}\n", distant ? "width" : "fov",
                            distant ? c.logBetween(20, 0.5) : c.between(40, 170), c.between(0, 360),
                            projector ? "" : fmt::format(", outside = \"{}\"", c.word({"black", "clamp", "repeat"})));
    return text;
}

std::string dialsText(Choices& c) {
    // Per-view splatting takes seconds to tabulate the footprints of coarse texels, for each view.
    const bool perView = c.once(3);
    const double coarsest = perView ? 2 : 64;
    std::string text = fmt::format("[render]\nsplat = \"{}\"\n", perView ? "per-view" : "shared");
    if (c.once(2)) text += fmt::format("texel = {}\n", c.logBetween(0.3, coarsest));
    if (c.once(2)) text += fmt::format("sheet_thickness = {}\n", c.logBetween(0.2, coarsest));
    if (c.once(3)) text += fmt::format("shadow_texel = {}\n", c.logBetween(0.3, 64));
    if (c.once(3)) text += fmt::format("footprint_steps = {}\n", 2 << c.below(7));
    if (c.once(4)) text += fmt::format("max_slant = {}\n", c.between(10, 85));
    if (c.once(4)) text += fmt::format("cross_fade = {}\n", c.between(0, 20));
    if (c.once(4)) text += fmt::format("opacity_cutoff = {}\n", c.between(0, 0.5));
    if (c.once(4)) text += fmt::format("lod = {}\n", c.logBetween(0.1, 64));
    if (c.once(6)) text += fmt::format("antialias = {}\n", 1 + c.below(3));
    text += fmt::format("kernel = \"{}\"\n", c.word({"linear", "gaussian", "bspline"}));
    text += fmt::format("shade = \"{}\"\n", c.word({"auto", "texel", "pixel"}));
    text += fmt::format("sheets = \"{}\"\n", c.word({"half-way", "image-aligned"}));
    text += fmt::format("shadow_filter = \"{}\"\n", c.word({"bilinear", "nearest"}));
    text += fmt::format("shadow_plane = \"{}\"\n", c.word({"light", "image"}));
    return text + fmt::format("simd = \"{}\"\n", c.word({"auto", "sse4", "avx2", "avx512"}));
}

/// Some blocks around the origin, of one value, of noise or of lone voxels; a tile now and then; voxels of any shape.
std::shared_ptr<const SparseField> madeField(Choices& c) {
    auto field = std::make_shared<SparseField>();
    auto values = std::make_shared<std::vector<float>>();
    field->name = "density";
    for (int axis = 0; axis < 3; ++axis) field->wsFromIs[axis][axis] = c.once(4) ? c.logBetween(0.5, 2) : 1.0;
    if (c.once(6)) field->wsFromIs[1][0] = c.between(-0.5, 0.5);
    const int blocks = c.once(8) ? 0 : 1 + c.below(kMostBlocks), pattern = c.below(3);
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
        field->tiles.push_back({Int3(8 * c.below(3) - 8, 8, 0), 8, most});
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
    out.toml = cameraText(c);
    for (int i = 1 + (c.once(4) ? c.below(3) : 0); i > 0; --i) out.toml += volumeText(c);
    for (int i = (c.below(5) + 1) % 5; i > 0; --i) out.toml += lightText(c, i);
    if (c.once(2)) out.toml += fmt::format("[ambient]\ncolor = {}\n", c.colour());
    out.toml += dialsText(c);

    const Scene scene = readScene({"fuzz.toml", "", out.toml}, 1, {}, colour);
    std::vector<std::shared_ptr<const SparseField>> fields;
    for (std::size_t i = 0; i < scene.volumes.size(); ++i) fields.push_back(madeField(c));
    out.view = assemble(scene, fields, {}, kMemoryLimit);
    for (Light& light : out.view.lights)
        if (light.slide) light.slide->image = madePicture(c);
    return out;
}

}  // namespace scrim::fuzz
