// SPDX-License-Identifier: Apache-2.0
// Parts of space whose scattered light is solved for on cells of their own. One size for all would have cells as small
// as the smallest voxels need all over the largest volume. So the first solve is of all volumes, on cells for those of
// the largest voxels, which average what is finer. Volumes of much smaller voxels that lie together have a solve of
// their own in the box around them, which holds all that is in it. What enters that box is the light of the solve
// around it, from which rays lead to its border past all else but what the box holds (solve/border_light.h).
#pragma once

#include <scrim/base/simd.h>
#include <scrim/engine/cells/cell_media.h>
#include <scrim/engine/model/plan.h>
#include <scrim/scene/view_scene.h>

#include <vector>

namespace scrim {

/// The first is of the whole scene, and each other one comes after the one around it. `cell`: the
/// edge of cells, in voxels of the finest volume that the cells are for.
std::vector<ScatterDomain> scatterDomains(const ViewScene& scene, double cell);

/// One domain for the whole scene, with cells for its finest voxels.
std::vector<ScatterDomain> wholeScene(const ViewScene& scene, double cell);

/// The cells of a scene's domains.
class DomainMedia {
  public:
    /// What is referred to must outlive this object.
    DomainMedia(const ViewScene& scene, const std::vector<ScatterDomain>& domains,
                const std::vector<ScatterClass>& classes, Simd simd);

    /// The cells of domain `d`, `larger` times as large as they should be, with all that is in them.
    CellMedia of(std::size_t d, double larger = 1) const;
    CellGrid gridOf(std::size_t d, double larger = 1) const;
    /// The cells of the domain around `d`, whose media are `around`, without what d holds.
    CellMedia around(std::size_t d, const CellMedia& around) const;

  private:
    CellPlaces placesOf(std::size_t d, double edge) const;
    CellMedia of(std::size_t d, double larger, const std::vector<bool>& volumes) const;

    const ViewScene& m_scene;
    const std::vector<ScatterDomain>& m_domains;
    const std::vector<ScatterClass>& m_classes;
    Simd m_simd;
};

}  // namespace scrim
