// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/splat/extinction_sum.h>

#include <scrim/base/parallel.h>

namespace scrim {
namespace {

// A further field as a volume of its own, whose extinction stands for its values.
ViewVolume asVolume(const ViewVolume& of, const ViewField& field, double scale) {
    ViewVolume volume{of.name, field.field, field.wsFromIs, {}};
    volume.medium.densityScale = scale;
    return volume;
}

bool anyEmission(const ViewScene& scene) {
    for (const ViewVolume& volume : scene.volumes)
        for (const ViewEmission& emission : volume.emission)
            if (!emission.field.field->empty()) return true;
    return false;
}

int denseVolumes(const ViewScene& scene) {
    int count = 0;
    for (const ViewVolume& volume : scene.volumes) count += volume.field->empty() ? 0 : 1;
    return count;
}

// Does extinction need planes of its own?
bool needsTotals(const ViewScene& scene, const ExtinctionRows& rows, SheetsFor who) {
    return rows.count() > 1 || denseVolumes(scene) != 1 || (who == SheetsFor::primaryEye && anyEmission(scene));
}

// Adds the active tiles of plane p of `from`, times `weight`, to those of `to`; nothing is added where it is 0, but the
// tiles count as active.
void addPlane(const PlaneStack& from, float weight, int p, PlaneStack& to) {
    for (int ty = 0; ty < to.tilesY(); ++ty)
        for (int tx = 0; tx < to.tilesX(); ++tx) {
            if (!from.active(p, tx, ty)) continue;
            to.activate(p, tx, ty);
            if (weight == 0) continue;
            const std::ptrdiff_t corner = static_cast<std::ptrdiff_t>(ty * kTileEdge) * to.rowStride() + tx * kTileEdge;
            for (int y = 0; y < kTileEdge; ++y) {
                const std::ptrdiff_t row = corner + static_cast<std::ptrdiff_t>(y) * to.rowStride();
                const float* source = from.plane(p) + row;
                float* target = to.plane(p) + row;
                for (int x = 0; x < kTileEdge; ++x) target[x] += weight * source[x];
            }
        }
}

}  // namespace

BatchFields::BatchFields(const ViewScene& scene, const ExtinctionRows& rows, const Sheets& sheets,
                         const ViewRaster& raster, int batchSheets, double voxel, SheetsFor who)
    : m_rows(rows) {
    const auto planesOf = [&](const ViewVolume& volume) {
        auto planes = std::make_unique<VolumePlanes>(volume, scene.dials, sheets, raster, batchSheets, voxel);
        m_voxels += volume.field->activeVoxels;
        m_all.push_back(planes.get());
        return planes;
    };
    const auto further = [&](const ViewVolume& of, const ViewField& field, double scale) {
        m_further.push_back(std::make_unique<const ViewVolume>(asVolume(of, field, scale)));
        return planesOf(*m_further.back());
    };
    for (std::size_t v = 0; v < scene.volumes.size(); ++v) {
        const ViewVolume& volume = scene.volumes[v];
        if (!volume.field->empty()) {
            m_volumes.push_back({static_cast<int>(v), planesOf(volume)});
            if (who != SheetsFor::light)
                for (std::size_t c = 0; c < volume.scatter.size(); ++c)
                    m_volumes.back().scatter[c] = further(volume, volume.scatter[c], volume.medium.mostExtinction());
        }
        if (who != SheetsFor::primaryEye) continue;
        for (const ViewEmission& emission : volume.emission)
            if (!emission.field.field->empty())
                m_emissions.push_back({further(volume, emission.field, 1), emission.color});
    }
    if (!needsTotals(scene, rows, who)) return;
    for (int r = 0; r < rows.count(); ++r) m_totals.emplace_back(batchSheets, raster.width, raster.height, 1);
}

SplatWork BatchFields::splat(int firstSheet, int count, const NeededTiles* needed, const TileCull& cull) {
    struct Task {
        VolumePlanes* volume;
        int part;
        SplatWork work;
    };
    std::vector<Task> tasks;
    for (VolumePlanes* volume : m_all) {
        const int parts = volume->beginBatch(firstSheet, count);
        for (int i = 0; i < parts; ++i) tasks.push_back({volume, i, {}});
    }
    parallelFor(tasks.size(),
                [&](std::size_t i) { tasks[i].work = tasks[i].volume->splat(tasks[i].part, needed, cull); });
    parallelFor(static_cast<std::size_t>(count), [&](std::size_t p) {
        for (VolumePlanes* volume : m_all) volume->classify(static_cast<int>(p));
        if (!m_totals.empty()) addUp(static_cast<int>(p));
    });
    SplatWork sum;
    for (const Task& task : tasks) sum += task.work;
    return sum;
}

// Sums the volumes into the rows of one sheet, in their order. The first row is active wherever anything is.
void BatchFields::addUp(int p) {
    for (PlaneStack& total : m_totals) total.begin(p);
    for (const Volume& volume : m_volumes) {
        const PlaneStack& own = volume.density->extinction();
        addPlane(own, 0, p, m_totals.front());
        for (const ExtinctionRows::Share& share : m_rows.shares[static_cast<std::size_t>(volume.sceneVolume)])
            addPlane(own, share.weight, p, m_totals[static_cast<std::size_t>(share.row)]);
    }
    for (const Emission& emission : m_emissions) addPlane(emission.planes->extinction(), 0, p, m_totals.front());
    for (PlaneStack& total : m_totals) total.finish(p);
}

std::size_t BatchFields::bytes() const {
    std::size_t sum = 0;
    for (const VolumePlanes* volume : m_all) sum += volume->bytes();
    for (const PlaneStack& t : m_totals) sum += PlaneStack::bytes(t.planes(), t.width(), t.height(), 1);
    return sum;
}

std::size_t BatchFields::bytes(const ViewScene& scene, const ExtinctionRows& rows, const Sheets& sheets,
                               const ViewRaster& raster, int batch, SheetsFor who) {
    std::size_t sum = 0;
    for (const ViewVolume& volume : scene.volumes) {
        if (!volume.field->empty()) sum += VolumePlanes::bytes(volume, scene.dials, sheets, raster, batch);
        const auto add = [&](const ViewField& field) {
            if (!field.field->empty())
                sum += VolumePlanes::bytes(asVolume(volume, field, 1), scene.dials, sheets, raster, batch);
        };
        if (who != SheetsFor::light)
            for (const ViewField& scatter : volume.scatter) add(scatter);
        if (who == SheetsFor::primaryEye)
            for (const ViewEmission& emission : volume.emission) add(emission.field);
    }
    const std::size_t totals = needsTotals(scene, rows, who) ? static_cast<std::size_t>(rows.count()) : 0;
    return sum + totals * PlaneStack::bytes(batch, raster.width, raster.height, 1);
}

}  // namespace scrim
