// SPDX-License-Identifier: Apache-2.0
// Stage 3 of a batch: every light's shadow buffer through the sheets, and what shading needs to know of each
// light at each of them.
#pragma once

#include <scrim/light/shadow_buffer.h>
#include <scrim/render/plan.h>
#include <scrim/shade/shade_tile.h>

#include <memory>
#include <optional>
#include <vector>

namespace scrim {

class BatchLights {
  public:
    BatchLights(const ViewScene& scene, const GroupPlan& group);

    /// Carries all shadowed lights through sheets [firstSheet, firstSheet + count). Returns light samples.
    std::uint64_t attenuate(int firstSheet, int count, const PlaneStack& extinction);

    /// The lights that reach sheet `p` of the batch, and their shadow buffers (nullptr: unshadowed).
    struct OnSheet {
        std::vector<SheetLight> lights;
        std::vector<const ShadowBuffer*> shadows;
    };
    const OnSheet& onSheet(int p) const { return m_onSheets[static_cast<std::size_t>(p)]; }
    std::size_t bytes() const;

  private:
    std::optional<SheetLight> atSheet(const LightPlan& plan, int sheet) const;

    const ViewScene& m_scene;
    const GroupPlan& m_group;
    std::vector<std::unique_ptr<ShadowBuffer>> m_shadows;  // one a light of the group, null where unshadowed
    std::vector<OnSheet> m_onSheets;
};

}  // namespace scrim
