// SPDX-License-Identifier: Apache-2.0
#include <scrim/render/batch_fields.h>

#include <scrim/base/parallel.h>

namespace scrim {

BatchFields::BatchFields(const ViewScene& scene, const Sheets& sheets, const ViewRaster& raster, int batchSheets,
                         double voxel) {
    for (const ViewVolume& volume : scene.volumes) {
        if (volume.field->empty()) continue;
        m_volumes.push_back(std::make_unique<VolumePlanes>(volume, scene.dials, sheets, raster, batchSheets, voxel));
        m_voxels += volume.field->activeVoxels;
    }
    if (m_volumes.size() > 1) m_total = std::make_unique<PlaneStack>(batchSheets, raster.width, raster.height, 1);
}

SplatWork BatchFields::splat(int firstSheet, int count, const TileCull& cull) {
    struct Task {
        VolumePlanes* volume;
        int part;
        SplatWork work;
    };
    std::vector<Task> tasks;
    for (const auto& volume : m_volumes) {
        const int parts = volume->beginBatch(firstSheet, count);
        for (int i = 0; i < parts; ++i) tasks.push_back({volume.get(), i, {}});
    }
    parallelFor(tasks.size(), [&](std::size_t i) { tasks[i].work = tasks[i].volume->splat(tasks[i].part, cull); });
    parallelFor(static_cast<std::size_t>(count), [&](std::size_t p) {
        for (const auto& volume : m_volumes) volume->classify(static_cast<int>(p));
        if (m_total) add(static_cast<int>(p));
    });
    SplatWork sum;
    for (const Task& task : tasks) sum += task.work;
    return sum;
}

std::size_t BatchFields::bytes() const {
    std::size_t sum = 0;
    for (const auto& volume : m_volumes) sum += volume->bytes();
    return sum + (m_total ? PlaneStack::bytes(m_total->planes(), m_total->width(), m_total->height(), 1) : 0);
}

// Sums all volumes' active tiles into the total of one sheet, in the order of the volumes.
void BatchFields::add(int p) {
    m_total->begin(p);
    for (const auto& volume : m_volumes) {
        const PlaneStack& own = volume->extinction();
        for (int ty = 0; ty < m_total->tilesY(); ++ty)
            for (int tx = 0; tx < m_total->tilesX(); ++tx) {
                if (!own.active(p, tx, ty)) continue;
                m_total->activate(p, tx, ty);
                const std::ptrdiff_t corner =
                    static_cast<std::ptrdiff_t>(ty * kTileEdge) * m_total->rowStride() + tx * kTileEdge;
                for (int y = 0; y < kTileEdge; ++y) {
                    const std::ptrdiff_t row = corner + static_cast<std::ptrdiff_t>(y) * m_total->rowStride();
                    const float* from = own.plane(p) + row;
                    float* to = m_total->plane(p) + row;
                    for (int x = 0; x < kTileEdge; ++x) to[x] += from[x];
                }
            }
    }
    m_total->finish(p);
}

}  // namespace scrim
