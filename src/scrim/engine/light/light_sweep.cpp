// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/light/light_sweep.h>

#include <scrim/base/parallel.h>
#include <scrim/engine/light/view_shadow.h>
#include <scrim/scene/light_at.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace scrim {
namespace {

// Fraction of a sheet's thickness below which the irradiance of a light without a radius stays
// constant, since 1/r^2 has no bound.
constexpr double kLeastRadius = 0.25;

// A light that crosses sheets at more than this slant (85 degrees) passes through far more than the extinction at one
// place tells. Only the attenuation by the sheets before counts for it, as in the paper (ZC02 eq. 5).
constexpr double kSteepestPath = 11.5;

// World length of a distant light's path through a sheet, in thicknesses.
double pathInSheets(const LightView& view) {
    const Vec2 slope = view.slopeAt(0, 0);
    return std::sqrt(1 + glm::dot(slope, slope));
}

// A light that shines from a point at this distance from a sheet's plane.
NearOnSheet nearLight(const Light& light, const PlannedLight& plan, const Sheets& sheets, double distanceW) {
    NearOnSheet out;
    out.texelU = static_cast<Real>(plan.view.tsSource.x);
    out.texelV = static_cast<Real>(plan.view.tsSource.y);
    out.distanceW = static_cast<Real>(distanceW);
    out.decay = light.point().decay;
    const double radius = std::max(light.point().radius, kLeastRadius * sheets.thickness);
    out.radius2 = static_cast<Real>(radius * radius);
    out.ownRadius2 = static_cast<Real>(light.point().radius * light.point().radius);
    const Vec3 axis = sheets.ssFromWs * light.wsDirection;
    out.axisU = static_cast<Real>(axis.x);
    out.axisV = static_cast<Real>(axis.y);
    out.axisW = static_cast<Real>(axis.z);
    if (light.luminaire) {
        NearOnSheet::Profile& profile = out.profile.emplace();
        profile.table = light.luminaire->profile.get();
        const Mat3 frame = sheets.ssFromWs * lightFrame(light);
        for (int c = 0; c < 3; ++c) profile.frame[c] = frame[c];
    }
    if (light.slide) {
        out.slideAngle = static_cast<Real>(slideHalfAngle(light));
        out.slideEnds = light.slide->outside == SlideOutside::black;
    }
    if (const Light::Element* element = light.element()) {
        const Spread spread(element->spread);
        out.face = {static_cast<Real>(spread.tangent()), static_cast<Real>(spread.scale())};
    }
    if (const Light::Spot* spot = light.spot()) {
        const SpotEdges edges(*spot);
        out.cone = {static_cast<Real>(edges.outer), static_cast<Real>(edges.inner)};
    }
    if (!plan.ssWindows.empty()) out.window = {&plan.ssWindows, plan.window, static_cast<Real>(std::cos(kWindowAngle))};
    return out;
}

}  // namespace

// The data of one light's shadows; empty for an unshadowed one.
struct LightSweep::Caster {
    std::vector<int> channels;                     // the extinction channels that attenuate it
    std::vector<std::unique_ptr<Shadow>> shadows;  // one for each extinction channel; null for others
    std::unique_ptr<ExtinctionSum> ownSheets;      // only if the light has its own lattice
    std::optional<SolidShadow> solids;
};

LightSweep::~LightSweep() = default;

// Shadows of solids are as fine as pixels show them, unless they are those of many lights, which blur each other's.
SolidDetail LightSweep::solidDetail(const ViewScene& scene, const Plan& plan, const GroupPlan& group) {
    constexpr double kOfPixel = 0.25;
    const double distance = glm::distance(scene.camera.wsPosition, wsBounds(scene).center());
    const double pixel = pixelAt(scene.camera, distance) / scene.dials.antialias;
    const double cell = scene.dials.shadowTexel * group.sheets.texel;
    const int most = sharpShadows(scene) ? SolidRaster::kMostParts : 1;
    SolidDetail out;
    while (out.parts < most && kOfPixel * pixel * out.parts < cell) out.parts *= 2;
    // Pixels' rays end at surfaces, and look up shadows no further. Texels behind a surface are
    // looked up together with those in front of it.
    constexpr double kAtPixels = 0.6, kAtTexels = 2;
    out.margin = plan.shadeAtPixels ? kAtPixels : kAtTexels;
    return out;
}

LightSweep::LightSweep(const ViewScene& scene, const Plan& plan, const GroupPlan& group)
    : m_group(group),
      m_subLights(plan.subLights),
      m_channels(plan.extinction.count()),
      m_passSolids(solidsBlock(scene)),
      m_simd(plan.simd) {
    const ShadowFilter filter = scene.dials.shadowFilter;
    const int lookUps = plan.shadeAtPixels ? 1 : 2;
    const SolidDetail detail = solidDetail(scene, plan, group);
    for (const PlannedLight& light : group.lights) {
        Caster& caster = m_casters.emplace_back();
        if (!light.shadowed) continue;
        caster.channels = plan.extinction.castIn(std::size_t(plan.subLights.ownerOf(light.light)));
        caster.shadows.resize(std::size_t(m_channels));
        if (m_passSolids)
            caster.solids.emplace(*scene.solids, light.view, group.sheets, scene.camera, detail, plan.simd);
        if (!light.lattice.shared() && !caster.channels.empty())
            caster.ownSheets = std::make_unique<ExtinctionSum>(scene, plan, group.sheets, light.lattice,
                                                               group.batchSheets, ExtinctionSum::For::light);
        for (const int i : caster.channels)
            if (light.lattice.shared())
                caster.shadows[std::size_t(i)] = std::make_unique<ShadowBuffer>(
                    light.view, group.sheets, filter, lookUps, group.batchSheets, plan.simd, anyClassified(scene));
            else
                caster.shadows[std::size_t(i)] =
                    std::make_unique<ViewShadow>(light.lattice, group.sheets, filter, group.batchSheets, plan.simd);
        for (const int i : caster.channels)
            if (!group.volumes.empty()) caster.shadows[std::size_t(i)]->lookUpAnywhere();
    }
}

// Determines how every light acts on each sheet of the batch.
void LightSweep::enterBatch(int firstSheet, int count) {
    m_onSheets.assign(std::size_t(count), {});
    for (int p = 0; p < count; ++p) {
        m_onSheets[p].sheet = firstSheet + p;
        for (std::size_t i = 0; i < m_casters.size(); ++i)
            if (const auto light = atSheet(i, firstSheet + p)) {
                OnSheet& here = m_onSheets[p];
                const Caster& caster = m_casters[i];
                here.lights.push_back(*light);
                here.lights.back().channels = caster.channels;
                here.numbers.push_back(i);
                for (int c = 0; c < m_channels; ++c)
                    here.shadows.push_back(caster.shadows.empty() ? nullptr : caster.shadows[c].get());
                if (m_passSolids) here.solids.push_back(caster.solids ? &*caster.solids : nullptr);
            }
    }
}

RenderWork LightSweep::attenuate(int firstSheet, int count, const ExtinctionSum& extinction) {
    enterBatch(firstSheet, count);
    RenderWork work;
    struct Shadowed {
        Shadow* shadow;
        const PlaneStack* extinction;
        const std::vector<const Surface*>* surfaces;
    };
    std::vector<Shadowed> shadowed;
    for (Caster& caster : m_casters) {
        // The paper's method (ZC02 Fig. 5, lines 10 and 17): footprints are splatted into the
        // light's own sheets, and these into its buffer.
        if (caster.ownSheets) work.footprints += caster.ownSheets->splat(firstSheet, count);
        const ExtinctionSum& sheets = caster.ownSheets ? *caster.ownSheets : extinction;
        for (const int channel : caster.channels) {
            const auto c = std::size_t(channel);
            // A channel may be empty where another one is looked up; light arrives there, too.
            const PlaneStack& planes = sheets.total(channel);
            caster.shadows[c]->beginBatch(firstSheet, count, planes, sheets.covered());
            shadowed.push_back({caster.shadows[c].get(), &planes, &sheets.surfacesAlone()});
        }
    }
    struct Task {
        Shadowed of;
        int row;
        std::uint64_t samples;
    };
    std::vector<Task> tasks;
    for (const Shadowed& of : shadowed)
        for (int row = 0; row < of.shadow->taskCount(); ++row) tasks.push_back({of, row, 0});
    parallelFor(tasks.size(), [&](std::size_t i) {
        tasks[i].samples = tasks[i].of.shadow->attenuate(tasks[i].row, *tasks[i].of.extinction, *tasks[i].of.surfaces);
    });
    const auto sheets = std::size_t(count);
    parallelFor(shadowed.size() * sheets,
                [&](std::size_t i) { shadowed[i / sheets].shadow->prefilter(static_cast<int>(i % sheets)); });
    for (const Task& task : tasks) work.lightSamples += task.samples;
    return work;
}

const Shadow* LightSweep::shadow(std::size_t light, int channel) const {
    const Caster& caster = m_casters[light];
    return caster.shadows.empty() ? nullptr : caster.shadows[std::size_t(channel)].get();
}

std::optional<SheetLight> LightSweep::atSheet(std::size_t i, int sheet) const {
    const PlannedLight& plan = m_group.lights[i];
    constexpr double kLeastPart = 1e-3;  // of a sheet
    const double part = plan.view.litPart(sheet);
    if (part < kLeastPart) return std::nullopt;
    const Light& light = m_subLights.of(plan.light);
    SheetLight out;
    out.shadowed = !m_casters[i].channels.empty();
    out.output = m_group.outputs.ofLights[i];
    out.index = plan.light;
    out.withinSheet = !plan.view.distant || pathInSheets(plan.view) < kSteepestPath;
    for (int c = 0; c < 3; ++c) out.intensity[c] = static_cast<Real>(part * plan.share * light.intensity[c]);
    const double stands = m_subLights.partOf(plan.light);
    out.part = static_cast<Real>(plan.view.distant ? capOf(stands) : stands);
    if (light.slide)
        out.slide = {light.slide->image.get(), light.slide->outside,
                     sheetMap(slideMap(light), m_group.sheets, sheet + 0.5), m_simd};
    if (plan.view.distant) {
        const Vec2 slope = plan.view.slopeAt(0, 0);
        out.source = DistantOnSheet{static_cast<Real>(slope.x), static_cast<Real>(slope.y)};
    } else {
        const double middle = sheet + 0.5 - plan.view.tsSource.z, away = part < 1 ? 0.5 * part : middle;
        NearOnSheet lamp = nearLight(light, plan, m_group.sheets, away * m_group.sheets.thickness);
        lamp.plane = static_cast<Real>((middle - away) * m_group.sheets.thickness);
        out.source = lamp;
    }
    return out;
}

namespace {

// How much longer than the sheet is thick the way of a ray through it is.
Real slantOf(const SampleTile& at, int k) {
    return std::sqrt(1 + at.eyeA[k] * at.eyeA[k] + at.eyeB[k] * at.eyeB[k]);
}

// Adds the optical depth of the surfaces along a light's rays through sheet p; `at` is as in Surface::meanExtinction.
void addDepth(int p, const SampleTile& at, const std::vector<const Surface*>& surfaces, Real thickness, int count,
              Real* tau) {
    thread_local ClassifiedTile through;
    through.count = count;
    for (const Surface* surface : surfaces) {
        through.leave();
        if (!surface->meanExtinction(p, at, through)) continue;
        for (int k = 0; k < count; ++k) tau[k] += through.extinction[k] * thickness * slantOf(at, k);
    }
}

// Tau at entry into sheet p on a light's rays. Between the cells of the buffer, those that have met a surface a sheet
// earlier darken the others, which meet it in this one: a lit surface would be covered with dark patches. So the buffer
// is asked some sheets earlier, and from there each ray finds its own way.
void enterAlongRays(int p, const SampleTile& at, const Shadow& shadow, const std::vector<const Surface*>& surfaces,
                    const Sheets& sheets, int count, Real* tau) {
    alignas(64) Real before[kTileSize], way[kTileSize];
    std::uint8_t known[kTileSize];
    const auto texels = static_cast<Real>(sheets.thickness / sheets.texel);
    thread_local SampleTile earlier;
    std::fill_n(way, count, Real(0));
    shadow.lookUpPoints(p, at.u, at.v, count, tau);
    for (int back = 1; back <= Shadow::kBefore; ++back) {
        shadow.lookUpBefore(p, back, at.u, at.v, count, before, known);
        if (std::none_of(known, known + count, [](std::uint8_t k) { return k != 0; })) return;
        const Real away = static_cast<Real>(back) * texels;
        for (int k = 0; k < kTileSize; ++k) {
            earlier.u[k] = at.u[k] - away * at.eyeA[k];
            earlier.v[k] = at.v[k] - away * at.eyeB[k];
            earlier.eyeA[k] = at.eyeA[k];
            earlier.eyeB[k] = at.eyeB[k];
        }
        addDepth(p - back, earlier, surfaces, static_cast<Real>(sheets.thickness), count, way);
        for (int k = 0; k < count; ++k)
            if (known[k] != 0) tau[k] = before[k] + way[k];
    }
}

}  // namespace

// Opaque matter is often thinner than a sheet. How much of its light is lost within the sheet then
// depends on the course of the light's own ray through it.
void LightSweep::lookUpEnds(int p, std::size_t number, const SampleTile& samples,
                            const std::vector<const Surface*>& surfaces, const Real* extinction, Real* first,
                            Real* last) const {
    const SheetLight& light = m_onSheets[p].lights[number];
    const Shadow& shadow = *m_onSheets[p].shadows[number];
    const auto thickness = static_cast<Real>(m_group.sheets.thickness);
    const Real texels = thickness / static_cast<Real>(m_group.sheets.texel);
    // The field at a few points does not tell the course of a light within the sheet, or of one
    // that crosses it at a steep slant. Both ends are then looked up in the middle.
    const NearOnSheet* const lamp = light.near();
    const DistantOnSheet sun = light.distant() ? *light.distant() : DistantOnSheet();
    const bool apart = light.withinSheet && (!lamp || lamp->distanceW > thickness);
    // Few of a tile's samples meet something in one sheet. Only theirs are looked up.
    thread_local SampleTile some, rays;
    int live[kTileSize], count = 0;
    for (int k = 0; k < kTileSize; ++k) {
        first[k] = last[k] = 0;
        if (extinction[k] > 0) live[count++] = k;
    }
    if (count == 0) return;
    for (int i = 0; i < kTileSize; ++i) {
        const int k = live[std::min(i, count - 1)];
        some.u[i] = samples.u[k];
        some.v[i] = samples.v[k];
        some.eyeA[i] = samples.eyeA[k];
        some.eyeB[i] = samples.eyeB[k];
    }
    const int looked = (count + kTileEdge - 1) / kTileEdge * kTileEdge;
    alignas(64) Real tau[kTileSize];
    for (const Real face : {Real(-0.5), Real(0.5)}) {
        const Real shift = apart ? face : Real(0);  // sheets from the middle plane
        const Real inverse = lamp ? 1 / (lamp->distanceW / thickness + shift) : Real(0);
        for (int k = 0; k < kTileSize; ++k) {
            const Real u = some.u[k] + shift * texels * some.eyeA[k];
            const Real v = some.v[k] + shift * texels * some.eyeB[k];
            const Real du = lamp ? (u - lamp->texelU) * inverse : sun.slopeA * texels;
            const Real dv = lamp ? (v - lamp->texelV) * inverse : sun.slopeB * texels;
            rays.u[k] = u - shift * du;
            rays.v[k] = v - shift * dv;
            rays.eyeA[k] = du / texels;
            rays.eyeB[k] = dv / texels;
        }
        if (apart)
            enterAlongRays(p, rays, shadow, surfaces, m_group.sheets, looked, tau);
        else
            shadow.lookUpPoints(p, rays.u, rays.v, looked, tau);
        for (int i = 0; i < count; ++i) (face < 0 ? first : last)[live[i]] = tau[i];
    }
    if (!light.withinSheet) return;
    if (apart)
        addDepth(p, rays, surfaces, thickness, looked, tau);
    else
        for (int i = 0; i < count; ++i) tau[i] += extinction[live[i]] * thickness * slantOf(rays, i);
    for (int i = 0; i < count; ++i) last[live[i]] = tau[i];
}

std::uint64_t LightSweep::solidRays() const {
    std::uint64_t sum = 0;
    for (const Caster& caster : m_casters)
        if (caster.solids) sum += caster.solids->rays();
    return sum;
}

std::size_t LightSweep::bytes() const {
    std::size_t sum = 0;
    for (const Caster& caster : m_casters) {
        for (const auto& shadow : caster.shadows) sum += shadow ? shadow->bytes() : 0;
        if (caster.ownSheets) sum += caster.ownSheets->bytes();
        if (caster.solids) sum += caster.solids->bytes();
    }
    return sum;
}

std::size_t LightSweep::shadowBytes(const ViewScene& scene, const PlannedLight& light, const Sheets& sheets,
                                    int batchSheets) {
    return light.lattice.shared() ? ShadowBuffer::bytes(light.view, sheets, batchSheets, anyClassified(scene))
                                  : ViewShadow::bytes(light.lattice, batchSheets);
}

}  // namespace scrim
