// SPDX-License-Identifier: Apache-2.0
// Stages 1 and 2 of a batch: every volume's field into its own sheets, and their sum, the extinction that eye and
// lights pass through.
#pragma once

#include <scrim/render/plan.h>
#include <scrim/splat/field_splatter.h>
#include <scrim/splat/plane_stack.h>

#include <memory>
#include <vector>

namespace scrim {

class BatchFields {
  public:
    BatchFields(const ViewScene& scene, const GroupPlan& group);

    /// Splats sheets [firstSheet, firstSheet + count) into planes [0, count).
    SplatWork splat(int firstSheet, int count);

    /// Total extinction per world unit. Where there is one volume these are its own planes.
    const PlaneStack& extinction() const { return m_total ? *m_total : m_fields.front()->planes; }

    int volumeCount() const { return static_cast<int>(m_fields.size()); }
    const PlaneStack& volume(int i) const { return m_fields[static_cast<std::size_t>(i)]->planes; }
    const Medium& medium(int i) const { return *m_fields[static_cast<std::size_t>(i)]->medium; }
    std::uint64_t voxels() const { return m_voxels; }
    std::size_t bytes() const { return m_bytes; }

  private:
    struct Field {
        const Medium* medium;
        FieldSplatter splatter;
        PlaneStack planes;
    };
    void add(int plane);

    std::vector<std::unique_ptr<Field>> m_fields;
    std::unique_ptr<PlaneStack> m_total;  // only where there are several volumes
    std::uint64_t m_voxels = 0;
    std::size_t m_bytes = 0;
};

}  // namespace scrim
