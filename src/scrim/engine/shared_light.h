// SPDX-License-Identifier: Apache-2.0
// The light on cells of one scene, for all others that it serves: renders of a lens, and small pilots of them.
#pragma once

#include <scrim/base/parallel.h>
#include <scrim/engine/kept_light.h>

#include <optional>

namespace scrim {

class SharedLight {
  public:
    /// `scene` and its `plan` must outlive this object. Its sheets must be no thinner than those of the others: light
    /// is looked up in the middle of sheets, as far beyond the volumes as these are thick.
    SharedLight(const ViewScene& scene, const Plan& plan) : m_scene(scene), m_plan(plan) {}
    /// The light for `other`, computed when it is asked for first; null: it does not serve `other`.
    /// Throws as keepLight does.
    const KeptLight* servedTo(const ViewScene& other, const Plan& otherPlan, const ProgressSink& progress = {}) {
        if (!lightServes(m_scene, m_plan, other, otherPlan)) return nullptr;
        if (!m_kept) TaskArena(m_plan.threads).run([&] { m_kept = keepLight(m_scene, m_plan, progress); });
        return &*m_kept;
    }
    /// No value: it has served nobody.
    const std::optional<KeptLight>& kept() const { return m_kept; }

  private:
    const ViewScene& m_scene;
    const Plan& m_plan;
    std::optional<KeptLight> m_kept;
};

}  // namespace scrim
