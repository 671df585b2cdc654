// SPDX-License-Identifier: Apache-2.0
// Stage 3 of a batch: every light's shadow buffer through the sheets, and what shading needs to know of each light at
// each of them.
#pragma once

#include <scrim/engine/light/shadow_buffer.h>
#include <scrim/engine/light/solid_shadow.h>
#include <scrim/engine/model/frame.h>
#include <scrim/engine/model/plan.h>
#include <scrim/engine/light/sheet_light.h>
#include <scrim/engine/splat/extinction_sum.h>

#include <memory>
#include <optional>
#include <vector>

namespace scrim {

class LightSweep {
  public:
    LightSweep(const ViewScene& scene, const Plan& plan, const GroupPlan& group);

    /// Carries all shadowed lights through sheets [firstSheet, firstSheet + count). `extinction`: of the shared sheets;
    /// a light whose lattice is its own splats its own instead. Returns
    /// the light samples, and the footprints that were splatted for lights alone.
    RenderWork attenuate(int firstSheet, int count, const ExtinctionSum& extinction);

    /// The lights that reach sheet `p` of the batch, and their shadow buffers, one for each extinction channel
    /// (nullptr: unshadowed).
    struct OnSheet {
        int sheet = 0;
        std::vector<SheetLight> lights;
        std::vector<const ShadowLookup*> shadows;
        std::vector<const SolidShadow*> solids;  ///< one a light, or nullptr; empty where the scene has no solids
    };
    /// Do solids shadow?
    bool passSolids() const { return m_passSolids; }
    const OnSheet& onSheet(int p) const { return m_onSheets[p]; }
    std::size_t bytes() const;
    /// Traced to solids.
    std::uint64_t solidRays() const;

    /// Upper estimate of the bytes of one light's shadow buffer for one extinction channel.
    static std::size_t shadowBytes(const PlannedLight& light, const Sheets& sheets, int batchSheets);

  private:
    // What casts one light's shadows: a buffer for each extinction channel, resampled from the shared sheets; or, with
    // a lattice of its own, sheets and buffers of its own.
    struct Caster {
        std::vector<ShadowBuffer> resampled;
        std::unique_ptr<ExtinctionSum> ownSheets;
        std::vector<ViewShadow> aligned;
        std::optional<SolidShadow> solids;
    };
    void enterBatch(int firstSheet, int count);
    RenderWork attenuateAligned(Caster& caster, int firstSheet, int count);
    std::optional<SheetLight> atSheet(std::size_t light, int sheet) const;

    const ViewScene& m_scene;
    const GroupPlan& m_group;
    int m_channels;
    bool m_passSolids;
    Simd m_simd;
    std::vector<Caster> m_casters;  // one a light of the group; of an unshadowed one empty
    std::vector<OnSheet> m_onSheets;
};

}  // namespace scrim
