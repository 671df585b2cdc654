// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/model/plan.h>
#include <scrim/base/error.h>

#include <algorithm>
#include <limits>

#include <fmt/format.h>

namespace scrim {
namespace {

double rampAt(const Vec2& ramp, double position) {
    if (ramp.x == ramp.y) return 1;
    const double t = std::clamp((position - ramp.x) / (ramp.y - ramp.x), 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

// A volume's tint. Classified volumes are grey, since a transfer function has one extinction.
Rgb tintOf(const ViewVolume& volume) {
    return volume.classified ? Rgb(1) : volume.medium.relativeTint();
}

}  // namespace

SweepOutputs chooseOutputs(const ViewScene& scene, bool coloured, bool primary, const std::vector<int>& lights,
                           const std::vector<int>& scattered) {
    SweepOutputs outputs;
    OutputLayout& layout = outputs.layout;
    const auto wants = [&](Layer layer) { return scrim::wants(scene, layer); };
    const auto add = [&](Layer layer, int light = -1, int place = -1) {
        outputs.list.push_back({layer, light, place});
        return static_cast<int>(outputs.list.size());
    };
    for (const int light : lights) {
        const auto known = std::find_if(outputs.list.begin(), outputs.list.end(),
                                        [&](const Output& output) { return output.light == light; });
        const bool isNew = known == outputs.list.end();
        outputs.ofLights.push_back(!wants(Layer::light) ? 0
                                   : isNew              ? add(Layer::light, light)
                                                        : static_cast<int>(known - outputs.list.begin()) + 1);
    }
    // The sweeps that own alpha show the multiply scattered part of a light.
    for (const int light : scattered)
        if (primary && wants(Layer::light) &&
            std::find(outputs.list.begin(), outputs.list.end(), Output{Layer::light, light}) == outputs.list.end())
            add(Layer::light, light);
    const bool lit = scene.ambient != Rgb(0);
    if (primary && wants(Layer::ambient) && lit) layout.ambient = add(Layer::ambient);
    if (primary && wants(Layer::emission)) layout.emission = add(Layer::emission);
    layout.beautyParts = static_cast<int>(outputs.list.size()) + 1;
    if (wants(Layer::indirect)) layout.indirect = add(Layer::indirect);
    if (primary && wants(Layer::albedo)) layout.albedo = add(Layer::albedo);
    if (primary && wants(Layer::depth)) layout.depth = add(Layer::depth);
    if (primary && wants(Layer::motion)) layout.motion = add(Layer::motion);
    for (std::size_t v = 0; wants(Layer::volume) && v < scene.volumes.size(); ++v)
        outputs.ofVolumes.push_back(add(Layer::volume, -1, placeOf(scene, v)));
    for (std::size_t v = 0; primary && wants(Layer::cryptomatte) && v < scene.volumes.size(); ++v)
        outputs.opacities.push_back(add(Layer::cryptomatte, -1, placeOf(scene, v)));
    layout.outputs = static_cast<int>(outputs.list.size()) + 1;
    if (primary && holdsOut(scene)) layout.seen = layout.outputs++;
    layout.coloured = coloured;
    // An output that is the sum of other existing outputs needs no quad of its own.
    const bool ambientLeft = primary && lit && layout.ambient == 0;
    const bool emissionLeft = primary && anyEmits(scene) && layout.emission == 0;
    const bool lightsLeft = (!lights.empty() || (primary && !scattered.empty())) && !wants(Layer::light);
    layout.beauty = layout.beautyParts == 1 || ambientLeft || emissionLeft || lightsLeft;
    constexpr int kMostOutputs = 250;
    if (layout.outputs > kMostOutputs)
        throw Error(ErrorKind::usage, fmt::format("{} layers are requested; at most {} can be rendered at once",
                                                  layout.outputs - 1, kMostOutputs - 1));
    return outputs;
}

std::size_t layerCount(const ViewScene& scene) {
    std::size_t count = 0;
    for (const Layer layer : scene.layers)
        count += layer == Layer::light || layer == Layer::shadow         ? scene.lights.size()
                 : layer == Layer::volume || layer == Layer::cryptomatte ? placesOf(scene)
                                                                         : 1;
    return count;
}

ExtinctionChannels extinctionChannels(const ViewScene& scene) {
    std::vector<Rgb> tints;
    std::vector<std::vector<bool>> shadows;
    const auto addNew = [](auto& all, const auto& one) {
        if (std::find(all.begin(), all.end(), one) == all.end()) all.push_back(one);
    };
    for (const ViewVolume& volume : scene.volumes) {
        addNew(tints, tintOf(volume));
        addNew(shadows, volume.shadows);
    }
    if (scene.volumes.empty()) return {};
    constexpr std::size_t kColours = 3;
    const bool perTint = tints.size() <= kColours;
    if (!perTint) tints = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    ExtinctionChannels channels;
    channels.tints.clear();
    channels.shadows.clear();
    for (const std::vector<bool>& lights : shadows)
        for (const Rgb& tint : tints) {
            const bool occurs = std::ranges::any_of(scene.volumes, [&](const ViewVolume& volume) {
                return volume.shadows == lights && (!perTint || tintOf(volume) == tint);
            });
            if (!occurs) continue;
            channels.tints.push_back(tint);
            channels.shadows.push_back(lights);
        }
    if (channels.count() > ExtinctionChannels::kMost)
        throw Error(ErrorKind::usage,
                    fmt::format("the volumes have {} tints of extinction and cast shadows in {} sets "
                                "of lights, which takes {} channels; expected at most {}",
                                tints.size(), shadows.size(), channels.count(), ExtinctionChannels::kMost));
    // A light passes through one white channel or past it: either way all colours are attenuated alike.
    channels.coloured = channels.count() > 1 || tints.front() != Rgb(1);
    for (const ViewVolume& volume : scene.volumes) {
        const Rgb tint = tintOf(volume);
        std::vector<Real>& weights = channels.weights.emplace_back();
        for (int i = 0; i < channels.count(); ++i) {
            const bool own = channels.shadows[std::size_t(i)] == volume.shadows;
            const bool same = channels.tints[std::size_t(i)] == tint;
            weights.push_back(!own ? 0 : !perTint ? static_cast<Real>(tint[i % int(kColours)]) : same ? 1 : 0);
        }
    }
    return channels;
}

std::vector<int> ExtinctionChannels::castIn(std::size_t light) const {
    std::vector<int> channels;
    for (std::size_t i = 0; i < tints.size(); ++i)
        if (litBy(shadows[i], light)) channels.push_back(static_cast<int>(i));
    return channels;
}

std::vector<int> TransportPlan::lights() const {
    std::vector<int> all;
    for (const ScatterTarget& target : targets) all.insert(all.end(), target.lights.begin(), target.lights.end());
    return all;
}

bool CellLightPlan::has(std::size_t light) const {
    return std::find(lights.begin(), lights.end(), static_cast<int>(light)) != lights.end();
}

double CellLightPlan::edge(std::size_t i) const {
    double least = std::numeric_limits<double>::infinity();
    for (const CellLevel& level : levels) least = std::min(least, level.edges[i]);
    return least;
}

double CellLightPlan::coarser() const {
    double most = 1;
    for (const CellLevel& level : levels) most = std::max(most, level.coarser);
    return most;
}

bool Plan::onSameCells(std::size_t first, std::size_t second) const {
    const auto alike = [&](const auto& part) { return part.volumes[first] == part.volumes[second]; };
    return std::ranges::all_of(transport.domains, alike) && std::ranges::all_of(cellLights.levels, alike);
}

std::vector<int> Plan::lightsOnCells() const {
    std::vector<int> all = transport.lights();
    all.insert(all.end(), cellLights.lights.begin(), cellLights.lights.end());
    return all;
}

double EyePart::weight(double x, double y) const {
    if (whole) return 1;
    const auto falling = [](const Vec2& ramp, double position) {
        return ramp.x == ramp.y ? 1 : 1 - rampAt(ramp, position);
    };
    return rampAt(left, x) * falling(right, x) * rampAt(top, y) * falling(bottom, y);
}

Box2<int> NeededTiles::over(int from, int to) const {
    Box2<int> all;
    for (int n = std::max(from, 0); n < std::min(to, static_cast<int>(sheets.size())); ++n) all.include(sheets[n]);
    return all;
}

double NeededTiles::share(const Sheets& s) const {
    double tiles = 0;
    for (const Box2<int>& box : sheets)
        if (!box.empty()) tiles += double(box.width()) * box.height();
    return tiles / (double(s.tilesX()) * s.tilesY() * s.count);
}

}  // namespace scrim
