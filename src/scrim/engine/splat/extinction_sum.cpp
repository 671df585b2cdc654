// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/splat/extinction_sum.h>

#include <scrim/base/parallel.h>
#include <scrim/engine/splat/splat_block.h>
#include <scrim/volume/field_builder.h>

#include <algorithm>

namespace scrim {
namespace {

// Settings for splatting a density. Values above 1e9 optical depths per voxel are clamped to that:
// sums of floats must not overflow, and beyond it a voxel's tent is opaque up to a millionth of a
// voxel from its rim, which no raster resolves.
FieldPlanes::Settings settingsOf(double scale, const Dials& dials, double voxel) {
    FieldPlanes::Settings settings;
    settings.scale = static_cast<Real>(scale);
    settings.most = static_cast<Real>(std::min<double>(1e9 / voxel, std::numeric_limits<float>::max()));
    settings.stepsPerVoxel = dials.footprintSteps;
    return settings;
}

// Divides the fields into runs that share the footprints of the first field of the run.
std::vector<std::vector<ViewField>> ofOneTopology(const std::vector<ViewField>& fields) {
    std::vector<std::vector<ViewField>> runs;
    for (const ViewField& field : fields)
        if (!runs.empty() && runs.back().size() < BlockSplat::kMost &&
            haveOneTopology(*runs.back().front().field, *field.field))
            runs.back().push_back(field);
        else
            runs.push_back({field});
    return runs;
}

// The sources of a volume's emission that the eye sees: none of a held-out volume, and otherwise
// those whose fields are not empty.
std::vector<ViewEmission> emissionOf(const ViewVolume& volume) {
    if (volume.holdout) return {};
    std::vector<ViewEmission> emission = volume.emission;
    std::erase_if(emission, [](const ViewEmission& e) { return e.ofBalls || e.field.field->empty(); });
    return emission;
}

bool anyBalls(const ViewScene& scene, const Plan& plan, ExtinctionSum::For who) {
    return who != ExtinctionSum::For::light &&
           std::ranges::any_of(scene.volumes, [&](const ViewVolume& volume) { return seesBalls(plan, volume); });
}

// True for a volume that is among those which share the sheets; empty: all do.
bool isAmong(const std::vector<bool>& among, std::size_t volume) {
    return among.empty() || among[volume];
}

// True for volumes that look the same, above all instances, which are splatted into the same
// planes. The groups hold indices of volumes with density.
using Alike = std::vector<std::size_t>;

bool lookAlike(const ViewScene& scene, const Plan& plan, std::size_t first, std::size_t second) {
    const ViewVolume &a = scene.volumes[first], &b = scene.volumes[second];
    return !a.classified && !b.classified && a.scatter.empty() && b.scatter.empty() && a.medium == b.medium &&
           plan.subLights.lit[first] == plan.subLights.lit[second] && a.shadows == b.shadows &&
           a.holdout == b.holdout && !a.motion && !b.motion && !a.balls && !b.balls && plan.onSameCells(first, second);
}

std::vector<Alike> alikeVolumes(const ViewScene& scene, const Plan& plan, const std::vector<bool>& among) {
    const bool apart = wants(scene, Layer::volume) || wants(scene, Layer::cryptomatte);  // each has its own layer
    std::vector<Alike> groups;
    for (std::size_t v = 0; v < scene.volumes.size(); ++v) {
        if (!isAmong(among, v) || scene.volumes[v].field->empty()) continue;
        const auto known = std::find_if(groups.begin(), groups.end(), [&](const Alike& group) {
            return !apart && lookAlike(scene, plan, group.front(), v);
        });
        if (known == groups.end())
            groups.push_back({v});
        else
            known->push_back(v);
    }
    return groups;
}

// The fields that the layer `motion` needs.
const std::vector<ViewField>& flowOf(const ViewScene& scene, const ViewVolume& volume) {
    static const std::vector<ViewField> none;
    return wants(scene, Layer::motion) && volume.motion ? volume.motion->flow : none;
}

// True if the sum needs planes of its own.
bool needsTotals(const ViewScene& scene, const Plan& plan, ExtinctionSum::For who, const std::vector<bool>& among) {
    const auto emits = [](const ViewVolume& volume) { return !emissionOf(volume).empty(); };
    return plan.extinction.count() > 1 || alikeVolumes(scene, plan, among).size() != 1 ||
           (who == ExtinctionSum::For::primaryEye && std::any_of(scene.volumes.begin(), scene.volumes.end(), emits));
}

// Adds the active tiles of plane p of `from`, times `weight`, to those of `to`. Nothing is added if
// `weight` is 0, but the tiles become active.
void addPlane(const PlaneStack& from, Real weight, int p, PlaneStack& to) {
    for (int ty = 0; ty < to.tilesY(); ++ty)
        from.forActive(p, ty, [&](int tx) {
            to.activate(p, tx, ty);
            if (weight == 0) return;
            const Real* source = from.tile(p, tx, ty);
            Real* target = to.tile(p, tx, ty);
            for (int y = 0; y < kTileEdge; ++y, source += from.rowStride(), target += to.rowStride())
                for (int x = 0; x < kTileEdge; ++x) target[x] += weight * source[x];
        });
}

}  // namespace

ExtinctionSum::ExtinctionSum(const ViewScene& scene, const Plan& plan, const Sheets& sheets, const Lattice& lattice,
                             int batchSheets, For who, const std::vector<bool>& among)
    : m_channels(plan.extinction), m_batchSheets(batchSheets) {
    const auto add = [&](const std::vector<std::vector<ViewField>>& placements, double scale) {
        m_own.push_back(std::make_unique<FieldPlanes>(placements, settingsOf(scale, scene.dials, plan.voxel),
                                                      scene.dials, sheets, lattice, batchSheets));
        m_fields.push_back(m_own.back().get());
        for (const std::vector<ViewField>& fields : placements)
            for (const ViewField& field : fields) m_voxels += field.field->activeVoxels;
        return m_own.back().get();
    };
    // The planes of each field; fields of one topology are splatted together.
    const auto planesOf = [&](const std::vector<ViewField>& fields, double scale) {
        std::vector<const PlaneStack*> planes;
        for (const std::vector<ViewField>& together : ofOneTopology(fields)) {
            const FieldPlanes* own = add({together}, scale);
            for (std::size_t f = 0; f < together.size(); ++f) planes.push_back(&own->planes(f));
        }
        return planes;
    };
    for (const Alike& alike : alikeVolumes(scene, plan, among)) {
        const ViewVolume& volume = scene.volumes[alike.front()];
        Volume& own = m_volumes.emplace_back();
        own.sceneVolume = static_cast<int>(alike.front());
        if (volume.classified) {
            own.surface = std::make_unique<Surface>(volume, scene.dials, sheets, lattice, batchSheets, plan.voxel);
            m_fields.push_back(&own.surface->field());
            m_voxels += volume.field->activeVoxels;
        } else if (alike.size() > 1) {
            std::vector<std::vector<ViewField>> placements;
            for (const std::size_t v : alike) placements.push_back({densityOf(scene.volumes[v])});
            own.density = &add(placements, volume.medium.mostExtinction())->planes();
        } else {
            std::vector<ViewField> fields{densityOf(volume)};
            const bool seen = who != For::light && !seesBalls(plan, volume);
            if (seen) fields.insert(fields.end(), volume.scatter.begin(), volume.scatter.end());
            const auto& flow = flowOf(scene, volume);
            const bool flows = seen && who == For::primaryEye;
            if (flows) fields.insert(fields.end(), flow.begin(), flow.end());
            const auto planes = planesOf(fields, volume.medium.mostExtinction());
            own.density = planes[0];
            std::copy_n(planes.begin() + 1, volume.scatter.size() * seen, own.scatter.begin());
            if (flows) std::copy(planes.end() - std::ptrdiff_t(flow.size()), planes.end(), own.flow.begin());
        }
    }
    const auto grey = [&](const Volume& v) { return m_channels.weights[v.sceneVolume].front() == 1; };
    if (m_channels.count() == 1 &&
        std::all_of(m_volumes.begin(), m_volumes.end(), [&](const Volume& v) { return v.surface && grey(v); }))
        for (const Volume& volume : m_volumes) m_surfacesAlone.push_back(volume.surface.get());
    for (std::size_t v = 0; v < scene.volumes.size() && who == For::primaryEye; ++v) {
        if (!isAmong(among, v)) continue;
        const std::vector<ViewEmission> emission = emissionOf(scene.volumes[v]);
        std::vector<ViewField> fields;
        for (const ViewEmission& e : emission) fields.push_back(e.field);
        const auto planes = planesOf(fields, 1);
        for (std::size_t e = 0; e < emission.size(); ++e)
            m_emissions.push_back({planes[e], emission[e].color, static_cast<int>(v)});
    }
    addSums(scene, plan, lattice, batchSheets, who, needsTotals(scene, plan, who, among));
}

// Makes the planes of sums over volumes.
void ExtinctionSum::addSums(const ViewScene& scene, const Plan& plan, const Lattice& lattice, int batchSheets, For who,
                            bool totals) {
    for (const Volume& volume : m_volumes)
        m_asBalls.push_back(seesBalls(plan, scene.volumes[std::size_t(volume.sceneVolume)]));
    for (int i = 0; i < m_channels.count() && anyBalls(scene, plan, who); ++i)
        m_seen.emplace_back(batchSheets, lattice.width, lattice.height, 1);
    for (int i = 0; i < m_channels.count() && totals; ++i)
        m_totals.emplace_back(batchSheets, lattice.width, lattice.height, 1);
}

std::uint64_t ExtinctionSum::splat(int firstSheet, int count, const NeededTiles* needed, const TileCull& cull) {
    struct Task {
        FieldPlanes* field;
        int part;
        std::uint64_t footprints;
    };
    std::vector<Task> tasks;
    const auto list = [&](const auto& partsOf) {
        tasks.clear();
        for (FieldPlanes* field : m_fields)
            for (int i = 0, parts = partsOf(*field); i < parts; ++i) tasks.push_back({field, i, 0});
    };
    for (const Volume& volume : m_volumes)
        if (volume.surface) volume.surface->beginBatch(firstSheet);
    for (FieldPlanes* field : m_fields) field->beginBatch(firstSheet, count);
    std::uint64_t footprints = 0;
    for (int phase = 0; phase < FieldPlanes::kPhases; ++phase) {
        list([&](const FieldPlanes& field) { return field.tasks(phase); });
        parallelFor(tasks.size(), [&](std::size_t i) {
            tasks[i].footprints = tasks[i].field->splat(phase, tasks[i].part, needed, cull);
        });
        for (const Task& task : tasks) footprints += task.footprints;
    }
    list([](const FieldPlanes& field) { return field.planesToFinish(); });
    parallelFor(tasks.size(), [&](std::size_t i) { tasks[i].field->finish(tasks[i].part); });
    parallelFor(std::size_t(count), [&](std::size_t p) {
        for (const Volume& volume : m_volumes)
            if (volume.surface) volume.surface->classifyTexels(static_cast<int>(p), m_texelsWanted);
        if (!m_totals.empty()) addUp(static_cast<int>(p), true, m_totals);
        if (!m_seen.empty()) addUp(static_cast<int>(p), false, m_seen);
    });
    return footprints;
}

int ExtinctionSum::take(int sheet, int count, int end, const NeededTiles& needed, std::uint64_t& footprints) {
    if (std::ranges::any_of(m_volumes, [](const Volume& volume) { return volume.surface != nullptr; })) {
        footprints += splat(sheet, count, &needed);  // surfaces keep sheets beside each batch
        return count;
    }
    if (sheet < m_firstKept || sheet >= m_endKept) {
        countFrom(0);
        m_firstKept = sheet;
        m_endKept = std::min(sheet + m_batchSheets, end);
        footprints += splat(sheet, m_endKept - sheet, &needed);
    }
    countFrom(sheet - m_firstKept);
    return std::min(count, m_endKept - sheet);
}

// See PlaneStack::countFrom.
void ExtinctionSum::countFrom(int plane) {
    for (FieldPlanes* field : m_fields) field->countFrom(plane);
    for (std::vector<PlaneStack>* sums : {&m_totals, &m_seen})
        for (PlaneStack& sum : *sums) sum.countFrom(plane);
}

// Sums the volumes, in their order, or those that the eye sees, into the channels of one sheet. The
// first channel is active wherever there are any contents.
void ExtinctionSum::addUp(int p, bool all, std::vector<PlaneStack>& totals) {
    for (PlaneStack& total : totals) total.begin(p);
    for (std::size_t v = 0; v < m_volumes.size(); ++v) {
        if (!all && m_asBalls[v]) continue;
        const Volume& volume = m_volumes[v];
        const PlaneStack& own = volume.extinction();
        addPlane(own, 0, p, totals.front());
        for (std::size_t i = 0; i < totals.size(); ++i)
            if (const Real weight = m_channels.weights[volume.sceneVolume][i]; weight > 0)
                addPlane(own, weight, p, totals[i]);
    }
    for (const Emission& emission : m_emissions) addPlane(*emission.planes, 0, p, totals.front());
    for (PlaneStack& total : totals) total.finish(p);
}

std::size_t ExtinctionSum::bytes() const {
    std::size_t sum = 0;
    for (const FieldPlanes* field : m_fields) sum += field->bytes();
    for (const Volume& volume : m_volumes)
        if (volume.surface) sum += volume.surface->bytes() - volume.surface->field().bytes();
    for (const PlaneStack& total : m_totals) sum += total.bytes();
    for (const PlaneStack& seen : m_seen) sum += seen.bytes();
    return sum;
}

std::size_t ExtinctionSum::bytes(const ViewScene& scene, const Plan& plan, const Sheets& sheets, const Lattice& lattice,
                                 int batch, For who, const std::vector<bool>& among) {
    std::size_t sum = 0;
    const FieldPlanes::Settings settings = settingsOf(1, scene.dials, plan.voxel);
    const auto add = [&](const ViewField& field) {
        if (!field.field->empty()) sum += FieldPlanes::bytes({field}, settings, scene.dials, sheets, lattice, batch);
    };
    for (const Alike& alike : alikeVolumes(scene, plan, among)) {
        const ViewVolume& volume = scene.volumes[alike.front()];
        std::vector<ViewField> placements;
        for (const std::size_t v : alike) placements.push_back(densityOf(scene.volumes[v]));
        sum += volume.classified ? Surface::bytes(volume, scene.dials, sheets, lattice, batch)
                                 : FieldPlanes::bytes(placements, settings, scene.dials, sheets, lattice, batch);
    }
    for (std::size_t v = 0; v < scene.volumes.size(); ++v) {
        const ViewVolume& volume = scene.volumes[v];
        if (!isAmong(among, v)) continue;
        if (who != For::light && !seesBalls(plan, volume))
            for (const ViewField& scatter : volume.scatter) add(scatter);
        if (who == For::primaryEye)
            for (const ViewField& flow : flowOf(scene, volume)) add(flow);
        if (who == For::primaryEye)
            for (const ViewEmission& emission : emissionOf(volume)) add(emission.field);
    }
    std::size_t totals = needsTotals(scene, plan, who, among) ? std::size_t(plan.extinction.count()) : 0;
    if (anyBalls(scene, plan, who)) totals += std::size_t(plan.extinction.count());
    return sum + totals * PlaneStack::bytes(batch, lattice.width, lattice.height, 1);
}

}  // namespace scrim
