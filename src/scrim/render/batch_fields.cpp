// SPDX-License-Identifier: Apache-2.0
#include <scrim/render/batch_fields.h>

#include <scrim/base/parallel.h>
#include <scrim/splat/unblur.h>

#include <algorithm>

namespace scrim {
namespace {

// Consecutive sheets that one task splats: voxels reach into about four, so fewer would locate them more often.
constexpr int kSheetsPerTask = 4;

}  // namespace

BatchFields::BatchFields(const ViewScene& scene, const GroupPlan& group) {
    const Sheets& s = group.sheets;
    for (const ViewVolume& volume : scene.volumes) {
        if (volume.field->empty()) continue;
        m_fields.push_back(std::unique_ptr<Field>(
            new Field{&volume.medium,
                      {*volume.field, s.tsFrom(volume.wsFromIs), scene.dials.kernel, scene.dials.footprintSteps,
                       static_cast<float>(volume.medium.densityScale)},
                      {group.batchSheets, s.width, s.height, 1}}));
        m_voxels += volume.field->activeVoxels;
        m_bytes += m_fields.back()->splatter.table().bytes();
    }
    if (m_fields.size() > 1) m_total = std::make_unique<PlaneStack>(group.batchSheets, s.width, s.height, 1);
    m_bytes += PlaneStack::bytes(group.batchSheets, s.width, s.height, 1) * (m_fields.size() + (m_total ? 1 : 0));
}

SplatWork BatchFields::splat(int firstSheet, int count) {
    const int tasks = (count + kSheetsPerTask - 1) / kSheetsPerTask;
    std::vector<SplatWork> work(m_fields.size() * static_cast<std::size_t>(tasks));
    parallelFor(work.size(), [&](std::size_t i) {
        Field& field = *m_fields[i / static_cast<std::size_t>(tasks)];
        const int first = static_cast<int>(i % static_cast<std::size_t>(tasks)) * kSheetsPerTask;
        const int last = std::min(first + kSheetsPerTask, count);
        for (int p = first; p < last; ++p) field.planes.begin(p);
        work[i] = field.splatter.splat(firstSheet + first, firstSheet + last, field.planes, first);
        for (int p = first; p < last; ++p) {
            field.planes.finish(p);
            unblur(field.planes, p);
            field.planes.dropEmpty(p);
        }
    });
    if (m_total) parallelFor(static_cast<std::size_t>(count), [&](std::size_t p) { add(static_cast<int>(p)); });

    SplatWork sum;
    for (const SplatWork& w : work) sum += w;
    return sum;
}

// Sums all fields' active tiles into the total of one sheet, in the order of the volumes.
void BatchFields::add(int p) {
    m_total->begin(p);
    for (const auto& field : m_fields)
        for (int ty = 0; ty < m_total->tilesY(); ++ty)
            for (int tx = 0; tx < m_total->tilesX(); ++tx) {
                if (!field->planes.active(p, tx, ty)) continue;
                m_total->activate(p, tx, ty);
                const std::ptrdiff_t corner =
                    static_cast<std::ptrdiff_t>(ty * kTileEdge) * m_total->rowStride() + tx * kTileEdge;
                for (int y = 0; y < kTileEdge; ++y) {
                    const std::ptrdiff_t row = corner + static_cast<std::ptrdiff_t>(y) * m_total->rowStride();
                    const float* from = field->planes.plane(p) + row;
                    float* to = m_total->plane(p) + row;
                    for (int x = 0; x < kTileEdge; ++x) to[x] += from[x];
                }
            }
    m_total->finish(p);
}

}  // namespace scrim
