// SPDX-License-Identifier: Apache-2.0
// Stage 3 of a batch: carries every light's shadow buffer through the sheets, and provides what
// shading needs to know about each light on each sheet.
#pragma once

#include <scrim/engine/light/shadow_buffer.h>
#include <scrim/engine/light/solid_shadow.h>
#include <scrim/engine/model/frame.h>
#include <scrim/engine/model/plan.h>
#include <scrim/engine/light/sheet_light.h>
#include <scrim/engine/splat/extinction_sum.h>

#include <optional>
#include <vector>

namespace scrim {

class LightSweep {
  public:
    LightSweep(const ViewScene& scene, const Plan& plan, const GroupPlan& group);
    ~LightSweep();

    /// Carries all shadowed lights through sheets [firstSheet, firstSheet + count). `extinction` is
    /// that of the shared sheets; a light with its own lattice splats its own instead. Returns the
    /// light samples, and the footprints that were splatted for lights alone.
    RenderWork attenuate(int firstSheet, int count, const ExtinctionSum& extinction);

    /// The lights that reach sheet `p` of the batch, and their shadow buffers, one for each
    /// extinction channel (nullptr: unshadowed).
    struct OnSheet {
        int sheet = 0;
        std::vector<SheetLight> lights;
        std::vector<const Shadow*> shadows;
        std::vector<std::size_t> numbers;        ///< of the lights in the group
        std::vector<const SolidShadow*> solids;  ///< one for each light, or nullptr; empty if the scene has no solids
    };
    /// True if solids cast shadows.
    bool passSolids() const { return m_passSolids; }
    const OnSheet& onSheet(int p) const { return m_onSheets[p]; }
    /// Tau towards one of the lights of sheet `p`, which must be shadowed, where the eye's rays cross the sheet's
    /// faces: the one where light enters (`first`) and the other one; 256 values each. All extinction is that of
    /// `surfaces`, and `extinction` is what the samples see of it; where they see none, tau is not looked up.
    void lookUpEnds(int p, std::size_t light, const SampleTile& samples, const std::vector<const Surface*>& surfaces,
                    const Real* extinction, Real* first, Real* last) const;
    /// The shadow buffer of one of the group's lights for one extinction channel; null: it has none.
    const Shadow* shadow(std::size_t light, int channel) const;
    std::size_t bytes() const;
    /// Number of rays traced to solids.
    std::uint64_t solidRays() const;

    /// Upper bound on the bytes of one light's shadow buffer for one extinction channel.
    static std::size_t shadowBytes(const ViewScene& scene, const PlannedLight& light, const Sheets& sheets,
                                   int batchSheets);
    /// How finely shadows of solids are kept for each of the group's lights.
    static SolidDetail solidDetail(const ViewScene& scene, const Plan& plan, const GroupPlan& group);

  private:
    struct Caster;
    void enterBatch(int firstSheet, int count);
    std::optional<SheetLight> atSheet(std::size_t light, int sheet) const;

    const GroupPlan& m_group;
    const SubLights& m_subLights;
    int m_channels;
    bool m_passSolids;
    Simd m_simd;
    std::vector<Caster> m_casters;  // one for each light of the group
    std::vector<OnSheet> m_onSheets;
};

}  // namespace scrim
