// SPDX-License-Identifier: Apache-2.0
// Stage 3 of a batch: every light's shadow buffer through the sheets, and what shading needs to know of each
// light at each of them.
#pragma once

#include <scrim/engine/light/shadow_buffer.h>
#include <scrim/engine/light/view_shadow.h>
#include <scrim/engine/splat/extinction_sum.h>
#include <scrim/engine/plan/plan.h>
#include <scrim/engine/shade/shade_tile.h>

#include <memory>
#include <optional>
#include <vector>

namespace scrim {

class BatchLights {
  public:
    BatchLights(const ViewScene& scene, const Plan& plan, const GroupPlan& group);

    struct Work {
        std::uint64_t samples = 0;     ///< cells of shadow buffers walked
        std::uint64_t footprints = 0;  ///< splatted for lights alone
    };
    /// Carries all shadowed lights through sheets [firstSheet, firstSheet + count). `fields`: the shared sheets; with
    /// per-view splatting every light splats its own instead.
    Work attenuate(int firstSheet, int count, const BatchFields& fields);

    /// The lights that reach sheet `p` of the batch, and their shadow buffers, one for each row of extinction (nullptr:
    /// unshadowed).
    struct OnSheet {
        std::vector<SheetLight> lights;
        std::vector<const ShadowLookup*> shadows;
    };
    const OnSheet& onSheet(int p) const { return m_onSheets[static_cast<std::size_t>(p)]; }
    std::size_t bytes() const;

  private:
    void enterBatch(int firstSheet, int count);
    Work attenuateOwn(int firstSheet, int count);
    std::optional<SheetLight> atSheet(const LightPlan& plan, int sheet) const;
    std::size_t row(std::size_t light, int r) const {
        return light * static_cast<std::size_t>(m_rows.count()) + static_cast<std::size_t>(r);
    }

    const ViewScene& m_scene;
    const GroupPlan& m_group;
    const ExtinctionRows& m_rows;
    Simd m_simd;
    // One a light of the group and row of extinction, null where it is unshadowed; or what the light splats for itself.
    std::vector<std::unique_ptr<ShadowBuffer>> m_shadows;
    struct OwnSheets {
        BatchFields fields;
        std::vector<ViewShadow> shadows;  // one a row
    };
    std::vector<std::unique_ptr<OwnSheets>> m_ownSheets;
    std::vector<OnSheet> m_onSheets;
};

}  // namespace scrim
