// SPDX-License-Identifier: Apache-2.0
#include "laws.h"

#include "changed_scenes.h"
#include "support/meshes.h"

#include <scrim/base/error.h>
#include <scrim/engine/model/sub_lights.h>
#include <scrim/engine/plan/transport_plan.h>
#include <scrim/engine/sweep.h>
#include <scrim/engine/solve/scattered_light.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <functional>
#include <numbers>
#include <stdexcept>

namespace scrim::test {
namespace {

using Broken = std::optional<std::string>;

// Where both sides have the same sheets, cells and sub-lights, they differ by the rounding of floats: of sums of some
// thousand terms, and of exponentials of optical depths that are sums of some hundred.
constexpr double kRounding = 1e-4;
// What a picture may be off without anyone's fault, beside what finer dials say.
constexpr double kLittle = 2e-3;

struct TooWrong : std::runtime_error {
    using std::runtime_error::runtime_error;
};

thread_local int renderCount = 0;

double mostOf(const Light& light, int c) {
    constexpr double kPi = std::numbers::pi;
    if (light.dome()) return 4 * kPi * light.intensity[c] * (light.slide ? 1e4 : 1);
    if (const Light::Area* area = light.area())
        return (area->shape == AreaShape::sphere || area->shape == AreaShape::mesh ? 4 : 2) * kPi * light.intensity[c] *
               1e4;
    if (light.distant() || !light.point().decay) return light.intensity[c];
    return light.intensity[c] == 0 ? 0 : light.intensity[c] / (light.point().radius * light.point().radius);
}

// No pixel is negative, NaN, or brighter than if all light reached all of it, and scattered towards the eye as well as
// can be.
void checkSane(const ViewScene& scene, const Image& image) {
    double most = 0, narrowest = 0;
    for (const ViewVolume& volume : scene.volumes) {
        if (!volume.emission.empty()) most = std::numeric_limits<double>::infinity();
        narrowest = std::max({narrowest, phaseValue(volume.medium.phase, 1), phaseValue(volume.medium.phase, -1)});
        if (volume.classified) narrowest = std::max(narrowest, 1.0);
    }
    for (const Light& light : scene.lights)
        for (int c = 0; c < 3; ++c) most += 16 * mostOf(light, c) * narrowest;
    most += 16 * largest(scene.ambient);
    for (std::size_t i = 0; i < image.rgba.size(); ++i) {
        const double v = image.rgba[i];
        const bool colour = i % 4 != 3;
        if (std::isfinite(v) && v >= 0 && v <= (colour ? most : 1 + 1e-6)) continue;
        const std::size_t pixel = i / 4, width = std::size_t(image.window.width());
        throw TooWrong(fmt::format("channel {} of pixel {},{} is {}, and may be at most {}", i % 4, pixel % width,
                                   pixel / width, v, colour ? most : 1));
    }
}

// A scene may take `patience` times the usual work.
Plan planOf(const ViewScene& scene, int threads = 1, double patience = 1) {
    const Plan plan = makePlan(scene, threads);
    const RenderWork& w = plan.work;
    const double work = double(w.footprints) + double(w.texelsShaded) + double(w.lightSamples) + double(w.pixelSheets);
    // A pass over the cells for each point or direction of the lights that are kept there.
    double passes = 0;
    for (std::size_t i = 0; i < plan.cellLights.lights.size(); ++i) {
        const Vec3 cells = wsBounds(scene).size() / plan.cellLights.edge(i) + 4.0;
        passes +=
            pointsOnCells(scene, scene.lights[std::size_t(plan.cellLights.lights[i])]) * cells.x * cells.y * cells.z;
    }
    constexpr double kMostGroups = 16;  // each fills tables of footprints of its own
    const double solves = plan.transport.cells * plan.transport.ordinates * double(plan.transport.targets.size());
    if (work > patience * 2e7 || double(plan.groups.size()) > patience * kMostGroups || solves > patience * 1.2e7 ||
        passes > patience * 2e7)
        throw Skipped();
    return plan;
}

Frame rendered(const ViewScene& scene, const Plan& plan) {
    ++renderCount;
    Frame frame = render(scene, plan);
    checkSane(scene, frame.image);
    return frame;
}

Frame rendered(const ViewScene& scene) {
    return rendered(scene, planOf(scene));
}

bool counts(const Image& image, std::size_t i) {
    return image.rgba[i + 3] > 1e-3f || image.rgba[i] > 0 || image.rgba[i + 1] > 0 || image.rgba[i + 2] > 0;
}

// RMS over the mean, of the pixels in which either shows something, and the largest difference over the brightest.
struct Apart {
    double rms = 0, worst = 0, alpha = 0, mean = 0, other = 0;
    std::size_t at = 0;
};
Apart apart(const Image& a, const Image& b) {
    Apart out;
    double squares = 0, sum = 0, most = 0, other = 0;
    std::size_t count = 0;
    for (std::size_t i = 0; i < b.rgba.size(); i += 4) {
        if (!counts(a, i) && !counts(b, i)) continue;
        ++count;
        out.alpha = std::max(out.alpha, std::abs(double(a.rgba[i + 3]) - double(b.rgba[i + 3])));
        for (std::size_t c = 0; c < 3; ++c) {
            const double d = std::abs(double(a.rgba[i + c]) - double(b.rgba[i + c]));
            if (d > out.worst) out.worst = d, out.at = i / 4;
            squares += d * d;
            sum += double(b.rgba[i + c]);
            other += double(a.rgba[i + c]);
            most = std::max(most, double(b.rgba[i + c]));
        }
    }
    if (count == 0) return out;
    const double n = 3 * double(count);
    out.mean = sum / n;
    out.other = other / n;
    const double unit = std::max(out.mean, 1e-12);
    out.rms = std::sqrt(squares / n) / unit;
    out.worst /= std::max(most, 1e-12);
    return out;
}

std::string textOf(const Apart& a, double bound) {
    return fmt::format("{:.3g} by RMS, {:.3g} at most, alpha {:.3g}, means {:.6g} and {:.6g}; bound {:.3g}", a.rms,
                       a.worst, a.alpha, a.other, a.mean, bound);
}

Broken same(const Image& a, const Image& b, double bound) {
    const Apart difference = apart(a, b);
    if (difference.worst <= bound && difference.alpha <= bound) return std::nullopt;
    return textOf(difference, bound);
}

// Two pictures of `scene` that share axis, cells and sub-lights. Where light scatters fully, each solve may end a sweep
// later, with an error of scatter_error. Extrapolation from cells twice as large takes 1.5 of one solve and 0.5 of
// another, 2 and 1 where surfaces scatter.
Broken same(const Image& a, const Image& b, const ViewScene& scene) {
    if (!anyScattersFully(scene)) return same(a, b, kRounding);
    const Apart difference = apart(a, b);
    const double solves = scattersInSurfaces(scene) ? 3 : 2;
    const double bound = kRounding + 2 * solves * scene.dials.scatterError;
    if (difference.rms <= bound && difference.alpha <= kRounding) return std::nullopt;
    return textOf(difference, bound);
}

// Errors fall at least in proportion to texels, sheets and cells: what is left of one is at most twice its change.
double errorOf(const ViewScene& scene, const Image& image) {
    constexpr double kPatience = 3;
    const ViewScene fine = refined(scene);
    return 2 * apart(image, rendered(fine, planOf(fine, 1, kPatience)).image).rms;
}

Broken alike(const ViewScene& a, const Image& ofA, const ViewScene& b, const Image& ofB, double more = 0) {
    const Apart difference = apart(ofA, ofB);
    double bound = kLittle + more;
    if (difference.rms <= bound) return std::nullopt;
    bound += errorOf(a, ofA);
    if (difference.rms <= bound) return std::nullopt;
    bound += errorOf(b, ofB);
    return difference.rms <= bound ? std::nullopt : Broken(textOf(difference, bound));
}

// The same scene in another way: equal where both sides have the same sheets and cells, and else as much alike as finer
// ones say. Cells lie along the voxels of the first volume.
Broken sameOrAlike(const ViewScene& a, const ViewScene& b, bool cellsMove) {
    const Plan ofA = planOf(a), ofB = planOf(b);
    const auto axes = [](const Plan& plan) {
        std::vector<std::array<double, 3>> all;
        for (const GroupPlan& group : plan.groups) all.push_back({group.wsAxis.x, group.wsAxis.y, group.wsAxis.z});
        std::ranges::sort(all);
        return all;
    };
    const bool moved = cellsMove && (!ofA.cellLights.lights.empty() || anyScattersFully(a));
    const Image imageA = rendered(a, ofA).image, imageB = rendered(b, ofB).image;
    return moved || axes(ofA) != axes(ofB) || ofA.cellLights.lights.size() != ofB.cellLights.lights.size()
               ? alike(a, imageA, b, imageB)
               : same(imageA, imageB, a);
}

void require(bool holds) {
    if (!holds) throw Skipped();
}

// So that both sides shade in the same places and have cells of one size.
ViewScene settled(ViewScene scene) {
    const Plan plan = planOf(scene);
    scene.dials.shade = plan.shadeAtPixels ? ShadeMode::pixel : ShadeMode::texel;
    if (!plan.cellLights.lights.empty() && !scene.dials.lightCell)
        scene.dials.lightCell = std::clamp(smallestCell(scene, plan.cellLights), 0.25, 16.0);
    return scene;
}

ViewScene plain(const DrawnScene& drawn) {
    ViewScene scene = drawn.view;
    scene.layers.clear();
    scene.deep.reset();
    return scene;
}

std::vector<std::size_t> allLights(const ViewScene& scene) {
    std::vector<std::size_t> all;
    for (std::size_t i = 0; i < scene.lights.size(); ++i) all.push_back(i);
    return all;
}

Image sumOf(const Image& a, const Image& b) {
    Image out = a;
    for (std::size_t i = 0; i < out.rgba.size(); ++i)
        if (i % 4 != 3) out.rgba[i] += b.rgba[i];
    return out;
}

// What has more optical depth in a voxel keeps no promise, and is warned of.
void thin(ViewScene& scene) {
    constexpr double kThick = 0.5;
    double depth = depthOfVoxel(scene);
    for (const ViewVolume& volume : scene.volumes) {
        if (!volume.classified) continue;
        double most = 0;
        for (const TransferPoint& point : volume.classified->transfer) most = std::max(most, point.extinction);
        depth = std::max(depth, most * volume.classified->densityScale * voxelUnit(scene));
    }
    for (ViewVolume& volume : scene.volumes) scaleDensity(volume, std::min(1.0, kThick / depth));
}

// Parts of light are solved for one by one, and each is extrapolated from larger cells, but no further than to twice
// its value: where that limit acts, in what is too thick for cells, parts do not add up.
ViewScene additive(ViewScene scene) {
    if (anyScattersFully(scene)) thin(scene);
    return scene;
}

// All light = the sum of each alone. Lights alone have other axes.
Broken lightAddsUp(const DrawnScene& drawn, Draws&) {
    const ViewScene scene = plain(drawn);
    require(!scene.lights.empty() && scene.lights.size() + (scene.ambient == Rgb(0) ? 0 : 1) > 1);
    const Image all = rendered(scene).image;
    Image sum = rendered(withLights(scene, {})).image;
    double bound = kLittle;
    for (std::size_t i = 0; i < scene.lights.size(); ++i)
        sum = sumOf(sum, rendered(withoutOtherLight(withLights(scene, {i}))).image);
    const Apart difference = apart(sum, all);
    if (difference.rms <= bound) return std::nullopt;
    // Errors of the parts are in proportion to their light.
    bound += errorOf(scene, all);
    for (std::size_t i = 0; i < scene.lights.size() && difference.rms > bound; ++i) {
        const ViewScene alone = withoutOtherLight(withLights(scene, {i}));
        const Image one = rendered(alone).image;
        const Apart part = apart(one, all);
        bound += errorOf(alone, one) * part.other / std::max(part.mean, 1e-12);
    }
    return difference.rms <= bound ? std::nullopt : Broken(textOf(difference, bound));
}

// Half a light twice = one.
Broken halfALightTwice(const DrawnScene& drawn, Draws& d) {
    const ViewScene scene = settled(plain(drawn));
    require(!scene.lights.empty());
    std::vector<std::size_t> twice = allLights(scene);
    const auto which = std::size_t(d.below(static_cast<int>(scene.lights.size())));
    twice.push_back(which);
    ViewScene other = withLights(scene, twice);
    other.lights[which].intensity *= 0.5;
    other.lights.back().intensity *= 0.5;
    // From the fifth lamp on, lamps share cells.
    // Frames fade from axis to axis as the lights lie, of which there are more.
    return lampsShareCells(other) == lampsShareCells(scene) && scene.dials.crossFade == 0
               ? same(rendered(other).image, rendered(scene).image, scene)
               : alike(other, rendered(other).image, scene, rendered(scene).image);
}

// Layers of lights, ambient light and emission sum to the picture; so do those of volumes; and none changes it.
Broken layersAddUp(const DrawnScene& drawn, Draws& d) {
    const ViewScene bare = additive(plain(drawn));
    ViewScene scene = bare;
    const Image whole = rendered(scene).image;
    scene.layers = drawn.view.layers;
    const bool volumes = d.once(0.3);
    for (const Layer layer : volumes ? std::vector<Layer>{Layer::volume, Layer::cryptomatte}
                                     : std::vector<Layer>{Layer::light, Layer::ambient, Layer::emission})
        if (!wants(scene, layer)) scene.layers.push_back(layer);
    std::sort(scene.layers.begin(), scene.layers.end());
    const Frame frame = rendered(scene);
    // Layers are solved for one by one, and each may stop a sweep later. Caught shadows of their own need all
    // sub-lights in shadow buffers.
    const bool otherWay = planOf(scene).cellLights.lights != planOf(bare).cellLights.lights;
    if (Broken broken = otherWay ? alike(scene, frame.image, bare, whole) : same(frame.image, whole, scene))
        return "layers change the picture: " + *broken;
    Image sum = emptyImage(frame.image.window);
    for (std::size_t i = 3; i < sum.rgba.size(); i += 4) sum.rgba[i] = frame.image.rgba[i];
    for (const FrameLayer& layer : frame.layers) {
        const bool part =
            volumes ? layer.layer == Layer::volume
                    : layer.layer == Layer::light || layer.layer == Layer::ambient || layer.layer == Layer::emission;
        for (std::size_t i = 0; part && i < sum.rgba.size() / 4; ++i)
            for (std::size_t c = 0; c < 3; ++c) sum.rgba[4 * i + c] += layer.data[3 * i + c];
        for (const float v : layer.data)
            if (!std::isfinite(v)) return fmt::format("layer {} holds {}", int(layer.layer), v);
    }
    if (Broken broken = same(sum, frame.image, 1e-5)) return "layers do not sum to the picture: " + *broken;
    return std::nullopt;
}

// The layer of a group is the sum of those of its lights.
Broken groupsAddUp(const DrawnScene& drawn, Draws&) {
    ViewScene scene = additive(plain(drawn));
    require(scene.lights.size() > 1);
    scene.layers = {Layer::light};
    for (Light& light : scene.lights) light.group.clear();
    const Frame apartFrame = rendered(scene);
    ViewScene grouped = scene;
    for (Light& light : grouped.lights) light.group = "all";
    const Frame together = rendered(grouped);
    Image sum = emptyImage(apartFrame.image.window), one = sum;
    for (const auto& [frame, to] : {std::pair(&apartFrame, &sum), std::pair(&together, &one)})
        for (const FrameLayer& layer : frame->layers)
            for (std::size_t i = 0; layer.layer == Layer::light && i < to->rgba.size() / 4; ++i)
                for (std::size_t c = 0; c < 3; ++c) to->rgba[4 * i + c] += layer.data[3 * i + c];
    return same(one, sum, scene);
}

// Two volumes of half the density in one place = one.
Broken halfTheDensityTwice(const DrawnScene& drawn, Draws& d) {
    const ViewScene scene = settled(plain(drawn));
    require(!scene.volumes.empty());
    const auto which = std::size_t(d.below(static_cast<int>(scene.volumes.size())));
    ViewScene other = scene;
    scaleDensity(other.volumes[which], 0.5);
    other.volumes.push_back(other.volumes[which]);
    other.volumes.back().name += "b";
    other.volumes.back().place = static_cast<int>(other.volumeCount++);
    const Image one = rendered(scene).image, two = rendered(other).image;
    // Surfaces that are alone are followed along rays, beside media or each other they are not.
    return anyClassified(scene) ? alike(other, two, scene, one) : same(two, one, scene);
}

// A volume of no density, a light of no intensity, a mesh out of sight.
Broken nothingChangesNothing(const DrawnScene& drawn, Draws& d) {
    const ViewScene scene = settled(plain(drawn));
    require(!scene.volumes.empty());
    ViewScene other = scene;
    const int kind = d.of({0, 0, 1, 2, 3});
    if (kind == 0) {
        ViewVolume nothing = other.volumes.front();
        nothing.medium = Medium();
        nothing.medium.densityScale = 0;
        nothing.medium.phase.g = d.of({0.0, 0.4});
        nothing.classified.reset();
        nothing.scatter.clear();
        nothing.emission.clear();
        nothing.holdout = false;
        nothing.lights.clear();
        nothing.shadows.clear();
        nothing.place = static_cast<int>(other.volumeCount++);
        other.volumes.push_back(nothing);
    } else if (kind == 1) {
        Light dark;
        dark.name = "dark";
        dark.kind =
            d.once(0.5)
                ? std::variant<Light::Distant, Light::Point, Light::Spot, Light::Element, Light::Area, Light::Dome>(
                      Light::Dome())
                : Light::Point();
        dark.intensity = Rgb(0);
        other.lights.push_back(dark);
        for (ViewVolume& volume : other.volumes)
            for (std::vector<bool>* list : {&volume.lights, &volume.shadows})
                if (!list->empty()) list->push_back(list == &volume.shadows);
    } else {
        std::vector<Solid> all;
        if (scene.solids) all = scene.solids->all();
        const bool shadows = kind == 3;
        all.push_back({"far", squareMesh({1013, 997, 1031}, {1, 1, 1}, shadows ? 1e-3 : 1), Mat4(1.0), true, shadows});
        other.solids = std::make_shared<const Solids>(std::move(all));
        if (shadows) return alike(other, rendered(other).image, scene, rendered(scene).image);
    }
    const Image with = rendered(other).image, without = rendered(scene).image;
    if (anyClassified(scene) && kind == 0) return alike(other, with, scene, without);
    if (Broken broken = same(with, without, scene))
        return fmt::format("{}: {}", kind == 0 ? "a volume" : kind == 1 ? "a light" : "a mesh", *broken);
    return std::nullopt;
}

bool pictured(const ViewScene& scene) {
    return std::ranges::any_of(scene.lights, [](const Light& light) { return light.slide.has_value(); });
}

// Unit, place and turn of the world do not matter, and mirror images are mirror images.
Broken theWorldMayMove(const DrawnScene& drawn, Draws& d) {
    const ViewScene scene = settled(plain(drawn));
    const auto turn = [&](int axis) {
        const Vec3 e[3] = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
        return axis == 0 ? Mat3(e[0], e[2], -e[1]) : axis == 1 ? Mat3(-e[2], e[1], e[0]) : Mat3(e[1], -e[0], e[2]);
    };
    const int kind = pictured(scene) ? 0 : d.of({0, 1, 2});
    const bool far = d.once(0.5), large = d.once(0.6) || (!far && kind == 0);
    const Mat3 axes = kind == 0 ? Mat3(1.0) : kind == 1 ? turn(d.below(3)) : Mat3(-1, 0, 0, 0, 1, 0, 0, 0, 1);
    const ViewScene other = movedScene(scene, large ? 37 : 1, axes, far ? Vec3(1234) : Vec3(0));
    const Image here = rendered(scene).image;
    Image there = rendered(other).image;
    if (kind == 2) there = mirrored(there);
    const Broken broken = alike(other, there, scene, here);
    if (!broken) return std::nullopt;
    return fmt::format("{}{}{}{}", large ? "times 37, " : "", far ? "1234 away, " : "",
                       kind == 1   ? "turned, "
                       : kind == 2 ? "mirrored, "
                                   : "",
                       *broken);
}

// Each colour has passes and solves of its own, which end when that colour is done, so the rounding of sums is all that
// may differ.
Broken channelsMayBeExchanged(const DrawnScene& drawn, Draws&) {
    ViewScene scene = settled(plain(drawn));
    scene.solids = coloured(scene.solids);
    return same(exchanged(rendered(exchanged(scene)).image), rendered(scene).image, kRounding);
}

// Volumes and lights in another order are the same scene.
Broken orderDoesNotMatter(const DrawnScene& drawn, Draws&) {
    const ViewScene scene = settled(plain(drawn));
    require(scene.volumes.size() > 1 || scene.lights.size() > 1);
    const ViewScene other = reversed(scene);
    return sameOrAlike(other, scene, scene.volumes.size() > 1);
}

// A list that names all lights is no list, and a light without shadows is one that no volume's list names.
Broken listsSayWhatSwitchesSay(const DrawnScene& drawn, Draws& d) {
    ViewScene scene = settled(plain(drawn));
    require(!scene.lights.empty() && !scene.volumes.empty());
    const bool linked = !anyScattersFully(scene) && !solidsBlock(scene);
    const auto which = std::size_t(d.below(static_cast<int>(scene.lights.size())));
    if (linked) scene.lights[which].shadows = false;
    ViewScene other = scene;
    for (ViewVolume& volume : other.volumes) {
        if (volume.lights.empty()) volume.lights.assign(scene.lights.size(), true);
        if (volume.shadows.empty()) volume.shadows.assign(scene.lights.size(), true);
        if (linked) volume.shadows[which] = false;
    }
    if (linked) other.lights[which].shadows = true;
    return sameOrAlike(other, scene, false);
}

Light whiteDome(bool shadows) {
    Light dome;
    dome.name = "white";
    dome.kind = Light::Dome();
    dome.shadows = shadows;
    return dome;
}

// The scene's media without anything that takes light away or adds some, in a white world.
ViewScene furnace(const DrawnScene& drawn, Draws& d, Scattering scattering, double albedo) {
    ViewScene scene = plain(drawn);
    std::erase_if(scene.volumes, [](const ViewVolume& volume) { return volume.classified != nullptr; });
    require(!scene.volumes.empty());
    scene = withoutOtherLight(withLights(scene, {}));
    scene.solids.reset();
    scene.dials.texel = std::min(scene.dials.texel, Dials().texel);
    scene.dials.sheetThickness = std::min(scene.dials.sheetThickness, Dials().sheetThickness);
    for (ViewVolume& volume : scene.volumes) {
        volume.scatter.clear();
        volume.lights.clear();
        volume.shadows.clear();
        volume.holdout = false;
        volume.medium.albedo = Rgb(albedo);
        volume.medium.extinctionTint = Rgb(1);
        volume.medium.scattering = scattering;
        volume.medium.octaves = {};
    }
    if (scattering == Scattering::full && d.once(0.3))
        scene.ambient = Rgb(1);
    else
        scene.lights = {whiteDome(scattering == Scattering::full)};
    return scene;
}

// The difference between radiance and `factor` times alpha by RMS, over the mean of the latter, as promises measure it,
// and over its RMS: what is off by a part of itself in each pixel is off by no more than that.
struct FurnaceError {
    double overMean = 0, overRms = 0;
};
FurnaceError errorOfFurnace(const Image& image, double factor) {
    double squares = 0, sum = 0, shown = 0, expectedSquares = 0;
    for (std::size_t i = 0; i < image.rgba.size(); i += 4) {
        const double expected = factor * double(image.rgba[i + 3]);
        squares += std::pow(double(image.rgba[i]) - expected, 2);
        expectedSquares += expected * expected;
        sum += expected;
        shown += expected > 0 ? 1 : 0;
    }
    if (sum == 0) return {};
    return {std::sqrt(squares * shown) / sum, std::sqrt(squares / expectedSquares)};
}

// Albedo 1, all scattering, a white sky: radiance = alpha, whatever else of no weight is in the scene. The solve keeps
// even light as it is; what is left is what it ends with, and what `standard` promises where light scatters fully.
Broken whiteFurnace(const DrawnScene& drawn, Draws& d) {
    ViewScene scene = furnace(drawn, d, Scattering::full, 1);
    thin(scene);
    const bool beside = d.once(0.6);
    if (beside) {
        ViewVolume light = scene.volumes.front();
        light.medium = Medium();
        light.medium.densityScale = 1e-7;
        light.place = static_cast<int>(scene.volumeCount++);
        scene.volumes.push_back(light);
    }
    constexpr double kPromise = 0.02;
    const double error = errorOfFurnace(rendered(scene).image, 1).overMean, bound = kPromise + scene.dials.scatterError;
    if (error <= bound) return std::nullopt;
    return fmt::format("radiance{} differs from alpha by {:.3g}; bound {:.3g}",
                       beside ? " beside a volume of no weight" : "", error, bound);
}

// An unshadowed white dome on single scattering: radiance = albedo x alpha, whatever the phase function.
Broken unshadowedDomeShowsAlbedo(const DrawnScene& drawn, Draws& d) {
    constexpr double kAlbedo = 0.9;
    ViewScene scene = furnace(drawn, d, Scattering::single, kAlbedo);
    thin(scene);
    // light_error is of the light that arrives, and so of each pixel. Over the mean of few bright pixels it is more:
    // one voxel, 0.0111 off in all of its pixels, is 0.0265 off.
    const double error = errorOfFurnace(rendered(scene).image, kAlbedo).overRms, bound = scene.dials.lightError;
    if (error <= bound) return std::nullopt;
    return fmt::format("radiance differs from {} alpha by {:.3g}; bound {}", kAlbedo, error, bound);
}

// Shadow buffers and cells agree, whoever casts shadows in a light.
Broken buffersAndCellsAgree(const DrawnScene& drawn, Draws& d) {
    ViewScene scene = withoutOtherLight(plain(drawn));
    std::vector<std::size_t> either;
    for (const std::size_t i : allLights(scene)) {
        const Light& light = scene.lights[i];
        if (light.extended() || (!light.distant() && !light.spot() && !light.slide)) either.push_back(i);
    }
    require(!either.empty());
    scene = withLights(scene, {either[std::size_t(d.below(static_cast<int>(either.size())))]});
    Light& light = scene.lights.front();
    light.shadows = true;
    light.shadow = ShadowMethod::buffers;
    scene.dials.sheets = Dials().sheets;
    constexpr int kFewPoints = 12;  // so that a sweep for each does not take long
    if (light.extended()) light.samples = kFewPoints;
    if (!scene.dials.lightCell) scene.dials.lightCell = 1;
    for (ViewVolume& volume : scene.volumes) {
        if (volume.medium.scattering == Scattering::full) volume.medium.scattering = Scattering::single;
        // Lobes so narrow that less than one point falls into them.
        const Phase& phase = volume.medium.phase;
        const double peak = std::max(phaseValue(phase, 1), phaseValue(phase, -1));
        if (light.extended() && peak * 4 * std::numbers::pi > kFewPoints) volume.medium.phase = Phase();
    }
    std::erase_if(scene.volumes, [](const ViewVolume& volume) { return volume.classified != nullptr; });
    require(!scene.volumes.empty());
    thin(scene);
    const auto volumes = static_cast<int>(scene.volumes.size());
    if (volumes > 1 && d.once(0.7)) scene.volumes[std::size_t(d.below(volumes))].shadows = {false};
    ViewScene cells = scene;
    cells.lights.front().shadow = ShadowMethod::cells;
    require(!planOf(cells).cellLights.lights.empty());
    return alike(cells, rendered(cells).image, scene, rendered(scene).image);
}

// Hardly any light scatters twice where the albedo is near 0.
Broken fullAndSingleAgreeNearBlack(const DrawnScene& drawn, Draws&) {
    constexpr double kAlbedo = 1e-3;
    ViewScene single = plain(drawn);
    single.ambient = Rgb(0);
    single.solids.reset();
    std::erase_if(single.volumes, [](const ViewVolume& volume) { return volume.classified != nullptr; });
    for (ViewVolume& volume : single.volumes) {
        volume.shadows.clear();
        volume.lights.clear();
        volume.emission.clear();
        volume.scatter.clear();
        volume.medium.octaves = {};
        volume.medium.scattering = Scattering::single;
        volume.medium.albedo *= kAlbedo;
    }
    // A solve's sky is what comes in through its border, and so what volumes hold back.
    for (Light& light : single.lights) light.shadows = light.shadows || light.dome();
    ViewScene full = single;
    for (ViewVolume& volume : full.volumes) volume.medium.scattering = Scattering::full;
    require(anyScattersFully(full));
    return alike(full, rendered(full).image, single, rendered(single).image, 10 * kAlbedo);
}

// An area light or a sky is its many points.
Broken wideLightIsItsPoints(const DrawnScene& drawn, Draws& d) {
    ViewScene scene = withoutOtherLight(plain(drawn));
    std::vector<std::size_t> wide;
    for (const std::size_t i : allLights(scene)) {
        const Light& light = scene.lights[i];
        if (light.slide) continue;
        if (light.dome() ||
            (light.area() && light.area()->shape != AreaShape::mesh && light.area()->shape != AreaShape::cylinder))
            wide.push_back(i);
    }
    require(!wide.empty() && !anyScattersFully(scene));
    scene = withLights(scene, {wide[std::size_t(d.below(static_cast<int>(wide.size())))]});
    scene.dials.sheets = Dials().sheets;
    scene.dials.crossFade = 0;
    scene.dials.antialias = 1;
    const Light whole = scene.lights.front();
    // A spiral of points over the surface, as the golden section turns them.
    constexpr int kPoints = 150;
    std::vector<std::size_t> many(kPoints, 0);
    ViewScene points = withLights(scene, many);
    const Mat3 frame = lightFrame(whole);
    for (int i = 0; i < kPoints; ++i) {
        Light& light = points.lights[std::size_t(i)];
        const double u = (i + 0.5) / kPoints, turn = 2 * std::numbers::pi * i / std::numbers::phi;
        const Vec3 ball(std::sqrt(1 - (1 - 2 * u) * (1 - 2 * u)) * std::cos(turn),
                        std::sqrt(1 - (1 - 2 * u) * (1 - 2 * u)) * std::sin(turn), 1 - 2 * u);
        light.samples = 0;
        light.shadow = ShadowMethod::buffers;
        if (whole.dome()) {
            light.kind = Light::Distant();
            light.wsDirection = ball;
            light.intensity = whole.intensity * (4 * std::numbers::pi / kPoints);
            continue;
        }
        const Light::Area& area = *whole.area();
        Light::Element element;
        element.spread = area.spread;
        element.radius = std::sqrt(area.area() / kPoints / (2 * std::numbers::pi));
        Vec3 offset(0);
        if (area.shape == AreaShape::sphere) {
            offset = area.radius * ball;
            light.wsDirection = ball;
        } else if (area.shape == AreaShape::disk) {
            offset = frame * (area.radius * std::sqrt(u) * Vec3(std::cos(turn), std::sin(turn), 0));
        } else {
            offset = frame * Vec3((u - 0.5) * area.width,
                                  (i / std::numbers::phi - std::floor(i / std::numbers::phi) - 0.5) * area.height, 0);
        }
        light.kind = element;
        light.wsPosition = whole.wsPosition + offset;
        light.intensity = whole.intensity * (area.area() / kPoints);
    }
    scene.dials.lightError = std::min(scene.dials.lightError, 0.01);
    scene.lights.front().samples = 0;
    constexpr double kPatience = 4;
    return alike(points, rendered(points, planOf(points, 1, kPatience)).image, scene, rendered(scene).image,
                 2 * scene.dials.lightError);
}

// A deep picture, flattened, is the flat one.
Broken deepIsFlat(const DrawnScene& drawn, Draws& d) {
    ViewScene scene = plain(drawn);
    scene.deep = ViewDeep{d.of({0.0, 0.01})};
    const Frame frame = rendered(scene);
    Image flat = frame.image;
    for (int y = flat.window.y0; y < flat.window.y1; ++y)
        for (int x = flat.window.x0; x < flat.window.x1; ++x) {
            const auto curve = frame.deep->curve(x, y);
            for (std::size_t c = 0; c < 4; ++c)
                flat.rgba[flat.indexOf(x, y) + c] = curve.empty() ? 0 : curve.back().shown[c];
        }
    // The part of a sample that is held out is a byte for each colour, rounded once when it is stored, and once when
    // samples are merged. Where extinction has one colour, it has 24 bits.
    constexpr double kByte = 1.0 / 255;
    const bool bytes = holdsOut(scene) && makePlan(scene, 1).extinction.coloured;
    return same(flat, frame.image, kRounding + (bytes ? kByte : 0));
}

Broken bits(const Image& a, const Image& b, const char* what) {
    for (int y = a.window.y0; y < a.window.y1; ++y)
        for (int x = a.window.x0; x < a.window.x1; ++x)
            if (std::memcmp(&a.rgba[a.indexOf(x, y)], &b.rgba[b.indexOf(x, y)], 4 * sizeof(float)) != 0)
                return fmt::format("{} change pixel {},{}: {} {} and {} {}", what, x, y, a.rgba[a.indexOf(x, y)],
                                   a.rgba[a.indexOf(x, y) + 3], b.rgba[b.indexOf(x, y)], b.rgba[b.indexOf(x, y) + 3]);
    return std::nullopt;
}

// Tiles, threads and limits of memory give the same bits.
Broken partsHaveTheBitsOfTheWhole(const DrawnScene& drawn, Draws& d) {
    ViewScene scene = plain(drawn);
    scene.layers = drawn.view.layers;
    if (!scene.volumes.empty() && d.once(0.5)) scene = inARow(scene);
    const Image whole = rendered(scene).image;
    const PixelWindow& w = scene.region;
    ViewScene part = scene;
    part.picture = w;
    part.region = {w.x0 + d.below(w.width() / 2), w.y0 + d.below(w.height() / 2), w.x1 - d.below(w.width() / 3),
                   w.y1 - d.below(w.height() / 3)};
    if (Broken broken = bits(rendered(part).image, whole, "tiles")) return broken;
    if (Broken broken = bits(rendered(scene, planOf(scene, 3)).image, whole, "threads")) return broken;
    const Plan plan = planOf(scene);
    ViewScene small = scene;
    small.memoryLimit = std::size_t(double(plan.bytes) * d.between(0.9, 0.3));
    try {
        const Plan less = planOf(small);
        // Cells that would take too much give way to shadow buffers, and the plan says so.
        if (less.cellLights.lights != plan.cellLights.lights) return std::nullopt;
        // Lights in passes of their own are added in another order.
        if (less.groups.size() != plan.groups.size()) return same(rendered(small, less).image, whole, 1e-5);
        return bits(rendered(small, less).image, whole, "limits of memory");
    } catch (const Error& error) {
        if (error.kind() == ErrorKind::memory) return std::nullopt;
        throw;
    }
}

// More density, less transmittance.
Broken moreDensityHidesMore(const DrawnScene& drawn, Draws& d) {
    const ViewScene scene = withoutOtherLight(withLights(settled(plain(drawn)), {}));
    require(std::ranges::none_of(scene.volumes, [](const ViewVolume& v) { return v.holdout || v.classified; }));
    ViewScene dense = scene;
    const double factor = d.of({1.5, 1.01, 4.0});
    for (ViewVolume& volume : dense.volumes) scaleDensity(volume, factor);
    const Image thin = rendered(scene).image, thick = rendered(dense).image;
    const double bound = scene.dials.opacityCutoff + 1e-5;
    for (std::size_t i = 3; i < thin.rgba.size(); i += 4)
        if (double(thick.rgba[i]) < double(thin.rgba[i]) - bound)
            return fmt::format("alpha falls from {} to {} with {} times the density", thin.rgba[i], thick.rgba[i],
                               factor);
    return std::nullopt;
}

}  // namespace

const std::vector<Law>& laws() {
    static const std::vector<Law> all{
        {"lightAddsUp", lightAddsUp, 0.4},
        {"halfALightTwice", halfALightTwice, 0.6},
        {"layersAddUp", layersAddUp, 0.7},
        {"groupsAddUp", groupsAddUp, 0.5},
        {"halfTheDensityTwice", halfTheDensityTwice, 0.7},
        {"nothingChangesNothing", nothingChangesNothing, 0.7},
        {"theWorldMayMove", theWorldMayMove, 0.7, {"light.decay.none"}},
        {"channelsMayBeExchanged", channelsMayBeExchanged, 0.7, {"medium.scattering.full", "mesh.shadows"}},
        {"orderDoesNotMatter", orderDoesNotMatter, 0.6, {"volume.shadows"}},
        {"listsSayWhatSwitchesSay", listsSayWhatSwitchesSay, 0.7},
        {"whiteFurnace", whiteFurnace, 0.9},
        {"unshadowedDomeShowsAlbedo", unshadowedDomeShowsAlbedo, 0.9},
        {"buffersAndCellsAgree", buffersAndCellsAgree, 0.3, {"volume.shadows"}},
        {"fullAndSingleAgreeNearBlack", fullAndSingleAgreeNearBlack, 0.7},
        {"wideLightIsItsPoints", wideLightIsItsPoints, 0.2},
        {"deepIsFlat", deepIsFlat, 0.7},
        {"partsHaveTheBitsOfTheWhole", partsHaveTheBitsOfTheWhole, 0.25},  // three laws in one
        {"moreDensityHidesMore", moreDensityHidesMore, 0.6}};
    return all;
}

namespace {

enum class Outcome { holds, skipped, refused, broken };

// The law is asked with the numbers of its own section.
Outcome outcomeOf(const std::vector<double>& numbers, const Law& law, std::string& what, std::string& toml) {
    try {
        const DrawnScene scene = drawnScene(numbers);
        toml = scene.toml;
        Draws draws(numbers);
        draws.enter(kLawSection);
        const Broken broken = law.check(scene, draws);
        if (!broken) return Outcome::holds;
        what = *broken;
        return Outcome::broken;
    } catch (const Skipped&) {
        return Outcome::skipped;
    } catch (const TooWrong& wrong) {
        what = wrong.what();
        return Outcome::broken;
    } catch (const Error& error) {
        // Too wide a view, too little memory, linking beside full scattering: said, not drawn wrongly.
        what = error.what();
        const bool refused =
            error.kind() == ErrorKind::input || error.kind() == ErrorKind::memory ||
            what.find("field of view") != std::string::npos || what.find("image-aligned") != std::string::npos ||
            what.find("cannot be aligned") != std::string::npos || what.find("too many") != std::string::npos;
        return refused ? Outcome::refused : Outcome::broken;
    }
}

}  // namespace

std::optional<BrokenLaw> checkSeed(std::uint64_t seed, int count, Coverage& coverage) {
    const std::vector<double> numbers = Draws::numbersOf(seed, kSections + 1);
    const int before = renderCount;
    ++coverage.scenes;
    DrawnScene scene;
    try {
        scene = drawnScene(numbers);
        for (auto a = scene.parts.begin(); a != scene.parts.end(); ++a) {
            ++coverage.parts[*a];
            for (auto b = std::next(a); b != scene.parts.end(); ++b) ++coverage.pairs[{*a, *b}];
        }
    } catch (const Error&) {
        ++coverage.refused;
        return std::nullopt;
    }
    // Laws in an order by chance, those of more weight sooner (P. Efraimidis and P. Spirakis, Weighted random sampling
    // with a reservoir, 2006): a choice among those that apply, since others are passed over.
    const auto weight = [&](const Law& law) {
        constexpr double kMatters = 6;
        const bool matters = !law.parts.empty() &&
                             std::ranges::all_of(law.parts, [&](const std::string& part) { return scene.has(part); });
        return (matters ? kMatters : 1) / law.share;
    };
    std::vector<std::pair<double, const Law*>> walk;
    std::uint64_t state = splitMix(~seed);
    for (const Law& law : laws())
        walk.emplace_back(std::pow(double(splitMix(state += kSplitMixStep) >> 11) * 0x1p-53, 1 / weight(law)), &law);
    std::ranges::sort(walk, std::greater());
    std::optional<BrokenLaw> found;
    for (std::size_t tried = 0; tried < walk.size() && count > 0 && !found; ++tried) {
        const Law& law = *walk[tried].second;
        std::string what, toml;
        const Outcome outcome = outcomeOf(numbers, law, what, toml);
        if (outcome == Outcome::skipped || outcome == Outcome::refused) {
            ++coverage.lawsSkipped[law.name];
            continue;
        }
        ++coverage.lawsChecked[law.name];
        --count;
        if (outcome == Outcome::broken) found = BrokenLaw{seed, law.name, what, toml};
    }
    coverage.renders += renderCount - before;
    return found;
}

BrokenLaw shrunk(const BrokenLaw& broken) {
    const auto law = std::ranges::find(laws(), broken.law, &Law::name);
    std::vector<double> numbers = Draws::numbersOf(broken.seed, kSections + 1);
    BrokenLaw least = broken;
    const auto attempt = [&](std::vector<double> tried) {
        if (tried == numbers) return false;
        std::string what, toml;
        if (outcomeOf(tried, *law, what, toml) != Outcome::broken) return false;
        numbers = std::move(tried);
        least.what = what;
        least.toml = toml;
        return true;
    };
    // Whole sections first, then ever smaller parts of them, until nothing becomes plainer.
    for (std::size_t size = Draws::kPerSection; size > 0; size /= 4)
        for (std::size_t at = 0; at < numbers.size(); at += size) {
            std::vector<double> tried = numbers;
            std::fill_n(tried.begin() + std::ptrdiff_t(at), std::min(size, tried.size() - at), 0.0);
            attempt(std::move(tried));
        }
    return least;
}

Coverage& Coverage::operator+=(const Coverage& o) {
    scenes += o.scenes;
    refused += o.refused;
    renders += o.renders;
    for (const auto& [law, n] : o.lawsChecked) lawsChecked[law] += n;
    for (const auto& [law, n] : o.lawsSkipped) lawsSkipped[law] += n;
    for (const auto& [pair, n] : o.pairs) pairs[pair] += n;
    for (const auto& [part, n] : o.parts) parts[part] += n;
    return *this;
}

std::string Coverage::text() const {
    std::string out = fmt::format("{} scenes ({} refused), {} renders\n", scenes, refused, renders);
    for (const Law& law : laws()) {
        const auto count = [&](const std::map<std::string, int>& of) {
            return of.contains(law.name) ? of.at(law.name) : 0;
        };
        out += fmt::format("  {}: {} checked, {} skipped\n", law.name, count(lawsChecked), count(lawsSkipped));
    }
    const std::size_t all = parts.size() * (parts.size() - 1) / 2;
    out += fmt::format("{} keys and kinds; {} of their {} pairs\n", parts.size(), pairs.size(), all);
    // Pairs that chance alone would have made often.
    for (auto a = parts.begin(); a != parts.end(); ++a)
        for (auto b = std::next(a); b != parts.end(); ++b)
            if (!pairs.contains({a->first, b->first}) && double(a->second) * b->second > 12.0 * scenes)
                out += fmt::format("  never together: {} and {}\n", a->first, b->first);
    return out;
}

}  // namespace scrim::test
