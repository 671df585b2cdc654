// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/quality.h>

#include <scrim/base/error.h>
#include <scrim/scene/nearest_name.h>

#include <fmt/format.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <cmath>
#include <functional>
#include <limits>

namespace scrim {
namespace {

/// A dial with the functions that check, set and get it. Its value is a number between limits or one of some words.
struct Dial {
    DialInfo info;
    std::function<bool(double)> allows;  ///< tells which numbers are allowed; empty: the dial takes words only
    std::vector<std::string> words;
    std::function<void(Dials&, double)> setNumber;
    std::function<void(Dials&, std::size_t)> setWord;  ///< takes the index into `words`
    std::function<std::string(const Dials&)> get;
};

std::string text(double value) {
    return fmt::format("{}", value);
}

/// A dial that is a real number in [low, high].
Dial number(std::string name, std::string unit, double low, double high, double Dials::*member, std::string meaning) {
    Dial d;
    d.info = {std::move(name), std::move(unit), "", fmt::format("a number from {} to {}", low, high),
              std::move(meaning)};
    d.allows = [=](double v) { return v >= low && v <= high; };
    d.setNumber = [=](Dials& dials, double v) { dials.*member = v; };
    d.get = [=](const Dials& dials) { return text(dials.*member); };
    return d;
}

/// A dial that is a whole number for which `allows` holds.
Dial integer(std::string name, std::string unit, std::string allowed, bool (*allows)(double), int Dials::*member,
             std::string meaning) {
    Dial d;
    d.info = {std::move(name), std::move(unit), "", std::move(allowed), std::move(meaning)};
    d.allows = [=](double v) { return v == std::floor(v) && allows(v); };
    d.setNumber = [=](Dials& dials, double v) { dials.*member = static_cast<int>(v); };
    d.get = [=](const Dials& dials) { return std::to_string(dials.*member); };
    return d;
}

/// A dial that is one of `words`, which stand for the values 0, 1, 2 … of an enumeration.
template <typename Enum>
Dial choice(std::string name, std::vector<std::string> words, Enum Dials::*member, std::string meaning) {
    Dial d;
    d.info = {std::move(name), "", "", choices(words), std::move(meaning)};
    d.words = std::move(words);
    d.setWord = [=](Dials& dials, std::size_t i) { dials.*member = static_cast<Enum>(i); };
    d.get = [=, known = d.words](const Dials& dials) { return known[std::size_t(dials.*member)]; };
    return d;
}

bool isFootprintSteps(double v) {
    for (int steps = 2; steps <= 128; steps *= 2)
        if (v == steps) return true;
    return false;
}

Dial simd() {
    Dial d;
    d.words = {"auto", "sse4", "avx2", "avx512"};
    d.info = {
        "simd", "", "", choices(d.words),
        "instruction set: the machine's best, or the largest one allowed, for equal pictures on different machines"};
    d.setWord = [known = d.words](Dials& dials, std::size_t i) { dials.simd = known[i]; };
    d.get = [](const Dials& dials) { return dials.simd; };
    return d;
}

Dial crossFade() {
    Dial d;
    d.words = {"auto", "always"};
    d.info = {"cross_fade", "degrees", "", choices(d.words) + ", or a number from 0 to 20",
              fmt::format("lights within this angle of perpendicular to the eye are swept from both sides, which "
                          "avoids pops when they cross; always: {0}; auto: {0} where the scene has keys, or else 0",
                          kCrossFade)};
    d.allows = [](double v) { return v >= 0 && v <= 20; };
    d.setNumber = [](Dials& dials, double v) { dials.crossFade = v; };
    d.setWord = [](Dials& dials, std::size_t i) {
        dials.crossFade = i == 0 ? std::nullopt : std::optional<double>(kCrossFade);
    };
    d.get = [](const Dials& dials) {
        if (!dials.crossFade) return std::string("auto");
        return *dials.crossFade == kCrossFade ? "always" : text(*dials.crossFade);
    };
    return d;
}

Dial shutterSamples() {
    Dial d;
    d.words = {"auto"};
    d.info = {"shutter_samples", "renders", "", "'auto', or a whole number from 1 to 1024",
              "renders averaged for motion blur and depth of field; auto: as many as pilot renders say that the "
              "preset's error needs, or 1 if nothing moves; error of second order"};
    d.allows = [](double v) { return v == std::floor(v) && v >= 1 && v <= 1024; };
    d.setNumber = [](Dials& dials, double v) { dials.shutterSamples = static_cast<int>(v); };
    d.setWord = [](Dials& dials, std::size_t) { dials.shutterSamples.reset(); };
    d.get = [](const Dials& dials) {
        return dials.shutterSamples ? std::to_string(*dials.shutterSamples) : std::string("auto");
    };
    return d;
}

// A number from `low` to 64 that is chosen where none is said.
Dial chosenNumber(std::string name, std::string unit, double low, std::optional<double> Dials::*member,
                  std::string meaning) {
    Dial d;
    d.words = {"auto"};
    d.info = {std::move(name), std::move(unit), "", fmt::format("'auto', or a number from {:g} to 64", low),
              std::move(meaning)};
    d.allows = [=](double v) { return v >= low && v <= 64; };
    d.setNumber = [=](Dials& dials, double v) { dials.*member = v; };
    d.setWord = [=](Dials& dials, std::size_t) { (dials.*member).reset(); };
    d.get = [=](const Dials& dials) { return dials.*member ? text(*(dials.*member)) : std::string("auto"); };
    return d;
}

// The edge of cells.
Dial cellEdge(std::string name, std::optional<double> Dials::*member, std::string meaning) {
    return chosenNumber(std::move(name), "voxels", 0.25, member, std::move(meaning));
}

Dial scatterDirections() {
    Dial d;
    d.words = {"auto"};
    d.info = {"scatter_directions", "directions", "", "'auto', 64, 128 or 256",
              "discrete directions of multiple scattering, of the last sweep: the others have half of them, but at "
              "least 64; auto: chosen for the error that the preset promises"};
    d.allows = [](double v) { return v == 64 || v == 128 || v == 256; };
    d.setNumber = [](Dials& dials, double v) { dials.scatterDirections = static_cast<int>(v); };
    d.setWord = [](Dials& dials, std::size_t) { dials.scatterDirections.reset(); };
    d.get = [](const Dials& dials) {
        return dials.scatterDirections ? std::to_string(*dials.scatterDirections) : std::string("auto");
    };
    return d;
}

void addLightCells(std::vector<Dial>& all) {
    all.push_back(cellEdge(
        "light_cell", &Dials::lightCell,
        "edge of the cells that keep the light of extended lights and of lamps within a volume, the smallest of the "
        "scene; auto: 0.25 to 4 by the optical depth of a voxel and the size of the volumes, 0.7 of more than 1 for "
        "area lights, half for a light_error below 0.004; a preset takes up to 4 times that where the picture shows "
        "little of it, in scenes where these cells take most of a second; error of second order"));
    all.push_back(chosenNumber(
        "light_cell_others", "", 0.25, &Dials::lightCellOthers,
        "edge of the larger cells that other volumes may have, such as haze around smoke, relative to what is chosen "
        "for them; auto: 1, or a light_cell that is smaller than chosen makes them as much smaller; a preset takes up "
        "to 4, as for light_cell, and down to 0.25 where smoke throws shadows that they would miss"));
}

std::vector<Dial> makeDials() {
    std::vector<Dial> all;
    all.push_back(number("sheet_thickness", "voxels", 0.01, 64, &Dials::sheetThickness,
                         "thickness of a sheet, before the cosine of the worst slant; error of second order"));
    all.push_back(number("texel", "voxels", 0.05, 64, &Dials::texel,
                         "edge of a sheet's texel; along flat voxels, in their long edges; error of second order"));
    all.push_back(choice<SplatMode>(
        "splat", {"shared", "per-view"}, &Dials::splat,
        "rasters that receive footprints: one that all views share, or one for each view, as in the paper"));
    all.push_back(choice<ShadeMode>("shade", {"auto", "texel", "pixel"}, &Dials::shade,
                                    "where lighting is computed: at texels (many lights are cheap) or at pixels"));
    all.push_back(choice<Kernel>("kernel", {"linear", "gaussian", "bspline"}, &Dials::kernel,
                                 "reconstruction kernel that interpolates between voxels"));
    all.push_back(integer("footprint_steps", "steps a voxel", "a power of two from 2 to 128", isFootprintSteps,
                          &Dials::footprintSteps,
                          "positions a footprint is tabulated at, with slopes in between; up to 32 where linear "
                          "footprints lie along texels; error of second order"));
    all.push_back(number("shadow_texel", "texels", 0.1, 64, &Dials::shadowTexel,
                         "edge of a shadow buffer's cell; error of second order"));
    all.push_back(choice<ShadowFilter>("shadow_filter", {"bilinear", "nearest"}, &Dials::shadowFilter,
                                       "interpolation in shadow buffers"));
    all.push_back(choice<ShadowPlane>("shadow_plane", {"light", "image"}, &Dials::shadowPlane,
                                      "plane that a light's buffer is aligned with in per-view splatting"));
    all.push_back(choice<SheetAxis>("sheets", {"half-way", "image-aligned"}, &Dials::sheets,
                                    "axis of the sheets: between eye and lights, or along the view"));
    all.push_back(number("max_slant", "degrees", 10, 85, &Dials::maxSlant,
                         "largest angle between a ray and the axis of its sweep; a smaller angle is more accurate and "
                         "needs more sweeps"));
    all.push_back(crossFade());
    all.push_back(number("opacity_cutoff", "transmittance", 0, 0.5, &Dials::opacityCutoff,
                         "transmittance below which a pixel counts as opaque; bounds the error"));
    all.push_back(number("light_error", "relative RMSE", 1e-4, 0.5, &Dials::lightError,
                         "error allowed to the sub-lights of area lights, domes and suns with an angle; sets their "
                         "number if a light gives no samples"));
    addLightCells(all);
    all.push_back(chosenNumber(
        "lod", "pixels", 0, &Dials::lod,
        "size below which voxels are splatted from a coarser level of the grid; 0: never; auto: as large as the "
        "error that the preset promises allows, or 0 where texel or sheet_thickness is given"));
    all.push_back(integer(
        "antialias", "rays a pixel's edge", "a whole number from 1 to 16", [](double v) { return v >= 1 && v <= 16; },
        &Dials::antialias, "n x n rays a pixel"));
    all.push_back(cellEdge("scatter_cell", &Dials::scatterCell,
                           "edge of the cells for multiple scattering (scattering = 'full'); auto: chosen for the "
                           "error that the preset promises; error of first order, time and memory of third"));
    all.push_back(scatterDirections());
    all.push_back(number("scatter_error", "relative error", 1e-6, 0.1, &Dials::scatterError,
                         "part of the multiply scattered light that further sweeps may still change, by an estimate; "
                         "with more, it counts as not converged"));
    all.push_back(shutterSamples());
    all.push_back(simd());
    for (Dial& dial : all) {
        dial.info.defaultText = dial.get(Dials());
        dial.info.chosen = dial.info.name == "texel" || dial.info.name == "sheet_thickness";
    }
    return all;
}

const std::vector<Dial>& allDials() {
    static const std::vector<Dial> dials = makeDials();
    return dials;
}

const Dial& dialNamed(const std::string& name, const std::string& where) {
    std::vector<std::string> names;
    for (const Dial& dial : allDials()) {
        if (dial.info.name == name) return dial;
        names.push_back(dial.info.name);
    }
    throw Error(ErrorKind::input, fmt::format("{}: there is no dial '{}'{}; expected {}", where, shortened(name, 60),
                                              didYouMean(name, names), choices(names)));
}

/// The unit of a number, to follow its limits in a message: " (voxels)".
std::string unitOf(const Dial& dial) {
    return dial.info.unit.empty() ? "" : " (" + dial.info.unit + ")";
}

[[noreturn]] void refuse(const Dial& dial, const std::string& found, const std::string& where) {
    throw Error(ErrorKind::input, fmt::format("{}: '{}' is {}; expected {}{}", where, dial.info.name, found,
                                              dial.info.allowed, unitOf(dial)));
}

struct Preset {
    std::string name;
    double sheetThickness, texel;
    int footprintSteps;
    double error, classifiedError, scatteringError;
    double lightError() const { return 0.5 * error; }
};

const std::vector<Preset>& presets() {
    static const std::vector<Preset> all{{"draft", 3, 1, 4, 0.03, 0.05, 0.05},
                                         {"standard", 1.5, 0.7, 8, 0.01, 0.02, 0.02},
                                         {"high", 1, 0.5, 8, 0.003, 0.01, 0.01},
                                         {"ultra", 0.5, 0.3, 16, 0.001, 0.005, 0.005}};
    return all;
}

}  // namespace

const std::vector<DialInfo>& dialTable() {
    static const std::vector<DialInfo> table = [] {
        std::vector<DialInfo> infos;
        for (const Dial& dial : allDials()) infos.push_back(dial.info);
        return infos;
    }();
    return table;
}

void setDial(Dials& dials, const std::string& name, const DialValue& value, const std::string& where) {
    const Dial& dial = dialNamed(name, where);
    if (const double* v = std::get_if<double>(&value)) {
        if (!dial.allows || !dial.allows(*v)) refuse(dial, text(*v), where);
        dial.setNumber(dials, *v);
        return;
    }
    const std::string& word = std::get<std::string>(value);
    for (std::size_t i = 0; i < dial.words.size(); ++i)
        if (dial.words[i] == word) return dial.setWord(dials, i);
    refuse(dial, fmt::format("'{}'", shortened(word, 60)), where);
}

void setDialFromText(Dials& dials, const std::string& name, const std::string& text, const std::string& where) {
    if (!dialNamed(name, where).allows) return setDial(dials, name, text, where);
    double value = 0;
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error == std::errc() && stop == text.data() + text.size()) return setDial(dials, name, value, where);
    setDial(dials, name, text, where);
}

void checkDials(const Dials& dials, const std::string& where) {
    Dials turned;
    for (const Dial& dial : allDials()) setDialFromText(turned, dial.info.name, dial.get(dials), where);
}

std::string dialText(const Dials& dials, const std::string& name) {
    return dialNamed(name, "dialText").get(dials);
}

const std::vector<std::string>& presetNames() {
    static const std::vector<std::string> names = [] {
        std::vector<std::string> all;
        for (const Preset& preset : presets()) all.push_back(preset.name);
        return all;
    }();
    return names;
}

std::optional<Dials> presetDials(const std::string& name) {
    for (const Preset& preset : presets())
        if (preset.name == name) {
            Dials dials;
            dials.sheetThickness = preset.sheetThickness;
            dials.texel = preset.texel;
            dials.footprintSteps = preset.footprintSteps;
            dials.lightError = preset.lightError();
            return dials;
        }
    return std::nullopt;
}

double promisedError(const std::string& name, bool classified) {
    for (const Preset& preset : presets())
        if (preset.name == name) return classified ? preset.classifiedError : preset.error;
    return 0;
}

double promisedScatteringError(const std::string& name) {
    for (const Preset& preset : presets())
        if (preset.name == name) return preset.scatteringError;
    return 0;
}

std::string renderBlock(const Dials& dials) {
    // Starts from the preset that leaves the fewest dials to state. Texels and sheets are always
    // stated, since a scene without them would have its own chosen.
    std::string best;
    int leastDifferences = std::numeric_limits<int>::max();
    for (const std::string& preset : presetNames()) {
        int differences = 0;
        std::string text = fmt::format("[render]\nquality = \"{}\"\n", preset);
        for (const DialInfo& dial : dialTable()) {
            const std::string value = dialText(dials, dial.name);
            const bool same = value == dialText(*presetDials(preset), dial.name);
            differences += same ? 0 : 1;
            if (same && !dial.chosen) continue;
            const bool isWord = !std::isdigit(static_cast<unsigned char>(value.front()));
            const std::string quote = isWord ? "\"" : "";
            text += fmt::format("{} = {}{}{}\n", dial.name, quote, value, quote);
        }
        if (differences < leastDifferences) best = text;
        leastDifferences = std::min(leastDifferences, differences);
    }
    return best;
}

}  // namespace scrim
