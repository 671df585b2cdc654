// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/light/light_sweep.h>

#include <scrim/base/parallel.h>
#include <scrim/engine/light/slide_map.h>

#include <algorithm>
#include <cmath>

namespace scrim {
namespace {

// Without a radius 1/r^2 has no bound: at less than this part of a sheet's thickness it stays what it is there.
constexpr double kLeastRadius = 0.25;

// A light that crosses sheets more slantingly than this (85 degrees) passes through far more than a sheet's extinction
// at one place tells: only what the sheets before did to it counts, as in the paper (ZC02 eq. 5).
constexpr double kSteepestPath = 11.5;

// World length of a distant light's way through a sheet, in thicknesses.
double pathInSheets(const LightView& view) {
    const double a = view.tsSource.x * view.slopeScale, b = view.tsSource.y * view.slopeScale;
    return std::sqrt(1 + a * a + b * b);
}

}  // namespace

BatchLights::BatchLights(const ViewScene& scene, const Plan& plan, const GroupPlan& group)
    : m_scene(scene), m_group(group), m_rows(plan.extinction), m_simd(plan.simd) {
    const ShadowFilter filter = scene.dials.shadowFilter;
    const int lookUps = plan.shadeAtPixels ? 1 : 2;
    m_shadows.resize(row(group.lights.size(), 0));
    m_ownSheets.resize(group.lights.size());
    for (std::size_t i = 0; i < group.lights.size(); ++i) {
        const LightPlan& light = group.lights[i];
        if (!light.shadowed) continue;
        if (plan.perView)
            m_ownSheets[i].reset(new OwnSheets{
                {scene, m_rows, group.sheets, light.raster, group.batchSheets, plan.voxel, SheetsFor::light}, {}});
        for (int r = 0; r < m_rows.count(); ++r) {
            if (plan.perView)
                m_ownSheets[i]->shadows.emplace_back(light.raster, group.sheets, filter, group.batchSheets, plan.simd);
            else
                m_shadows[row(i, r)] = std::make_unique<ShadowBuffer>(light.view, group.sheets, filter, lookUps,
                                                                      group.batchSheets, plan.simd);
        }
    }
}

// What every light does to each sheet of the batch.
void BatchLights::enterBatch(int firstSheet, int count) {
    m_onSheets.assign(static_cast<std::size_t>(count), {});
    for (int p = 0; p < count; ++p)
        for (std::size_t i = 0; i < m_group.lights.size(); ++i)
            if (const auto light = atSheet(m_group.lights[i], firstSheet + p)) {
                OnSheet& here = m_onSheets[static_cast<std::size_t>(p)];
                here.lights.push_back(*light);
                for (int r = 0; r < m_rows.count(); ++r) {
                    const ShadowLookup* shadow = m_shadows[row(i, r)].get();
                    if (m_ownSheets[i]) shadow = &m_ownSheets[i]->shadows[static_cast<std::size_t>(r)];
                    here.shadows.push_back(shadow);
                }
            }
}

// The paper's way (ZC02 Fig. 5, lines 10 and 17): footprints into each light's own sheets, and those into its buffer.
BatchLights::Work BatchLights::attenuateOwn(int firstSheet, int count) {
    Work work;
    for (const auto& own : m_ownSheets) {
        if (!own) continue;
        work.footprints += own->fields.splat(firstSheet, count).footprints;
        for (std::size_t r = 0; r < own->shadows.size(); ++r) {
            ViewShadow& shadow = own->shadows[r];
            shadow.beginBatch(firstSheet, count);
            std::vector<std::uint64_t> samples(static_cast<std::size_t>(shadow.taskCount()));
            parallelFor(samples.size(), [&](std::size_t task) {
                samples[task] = shadow.attenuate(static_cast<int>(task), own->fields.extinction(static_cast<int>(r)));
            });
            for (const std::uint64_t n : samples) work.samples += n;
        }
    }
    return work;
}

BatchLights::Work BatchLights::attenuate(int firstSheet, int count, const BatchFields& fields) {
    enterBatch(firstSheet, count);
    struct Shadowed {
        ShadowBuffer* shadow;
        const PlaneStack* extinction;
    };
    std::vector<Shadowed> shadowed;
    for (std::size_t i = 0; i < m_group.lights.size(); ++i)
        for (int r = 0; r < m_rows.count(); ++r)
            if (ShadowBuffer* shadow = m_shadows[row(i, r)].get()) {
                // A row may be empty where another is looked at: light arrives there, too.
                shadow->beginBatch(firstSheet, count, fields.extinction(r), fields.covered());
                shadowed.push_back({shadow, &fields.extinction(r)});
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
        tasks[i].samples = tasks[i].of.shadow->attenuate(tasks[i].row, *tasks[i].of.extinction);
    });
    const auto sheets = static_cast<std::size_t>(count);
    parallelFor(shadowed.size() * sheets,
                [&](std::size_t i) { shadowed[i / sheets].shadow->sharpen(static_cast<int>(i % sheets)); });
    Work work = attenuateOwn(firstSheet, count);
    for (const Task& task : tasks) work.samples += task.samples;
    return work;
}

std::optional<SheetLight> BatchLights::atSheet(const LightPlan& plan, int sheet) const {
    constexpr double kLeastPart = 1e-3;  // of a sheet
    const double part = plan.view.litPart(sheet);
    if (part < kLeastPart) return std::nullopt;
    const Light& light = m_scene.lights[static_cast<std::size_t>(plan.light)];
    const Sheets& sheets = m_group.sheets;
    SheetLight out;
    out.shadowed = plan.shadowed;
    out.picture = plan.picture;
    out.index = plan.light;
    out.withinSheet = !plan.view.distant || pathInSheets(plan.view) < kSteepestPath;
    out.decay = light.decay;
    for (int c = 0; c < 3; ++c) out.intensity[c] = static_cast<float>(part * plan.share * light.intensity[c]);
    out.distant = plan.view.distant;
    if (light.slide)
        out.slide = {light.slide->image.get(), light.slide->outside, sheetMap(slideMap(light), sheets, sheet + 0.5),
                     m_simd};
    if (out.distant) {
        out.slopeA = static_cast<float>(plan.view.tsSource.x * plan.view.slopeScale);
        out.slopeB = static_cast<float>(plan.view.tsSource.y * plan.view.slopeScale);
        return out;
    }
    out.texelU = static_cast<float>(plan.view.tsSource.x);
    out.texelV = static_cast<float>(plan.view.tsSource.y);
    const double away = part < 1 ? 0.5 * part : sheet + 0.5 - plan.view.tsSource.z;
    out.distanceW = static_cast<float>(away * sheets.thickness);
    const double radius = std::max(light.radius, kLeastRadius * sheets.thickness);
    out.radius2 = static_cast<float>(radius * radius);
    if (light.type == LightType::spot) {
        const double half = 0.5 * light.coneAngle * std::acos(-1.0) / 180;
        const Vec3 axis = sheets.ssFromWs * light.wsDirection;
        out.spot = true;
        out.axisU = static_cast<float>(axis.x);
        out.axisV = static_cast<float>(axis.y);
        out.axisW = static_cast<float>(axis.z);
        out.cosOuter = static_cast<float>(std::cos(half));
        // A cone without a blend still has an edge of some width: a hundredth of a degree.
        out.cosInner = static_cast<float>(std::cos(std::min(half * (1 - light.blend), half - 1e-4)));
    }
    if (!plan.ssWindows.empty()) {
        out.windows = &plan.ssWindows;
        out.window = plan.window;
        out.windowCos = static_cast<float>(std::cos(kWindowAngle));
    }
    return out;
}

std::size_t BatchLights::bytes() const {
    std::size_t sum = 0;
    for (const auto& shadow : m_shadows)
        if (shadow) sum += shadow->bytes();
    for (const auto& own : m_ownSheets)
        if (own) {
            sum += own->fields.bytes();
            for (const ViewShadow& shadow : own->shadows) sum += shadow.bytes();
        }
    return sum;
}

}  // namespace scrim
