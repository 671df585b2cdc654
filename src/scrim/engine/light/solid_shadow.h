// SPDX-License-Identifier: Apache-2.0
// Shadows of solids: where each ray of a light's raster first meets a surface. Unlike optical depth that is known
// before the sweep begins, and is one number a ray.
#pragma once

#include <scrim/base/real.h>
#include <scrim/engine/light/shadow_buffer.h>
#include <scrim/geometry/camera.h>
#include <scrim/geometry/sheets.h>
#include <scrim/solid/solids.h>

#include <cstddef>
#include <cstdint>
#include <vector>

namespace scrim {

class SolidShadow {
  public:
    /// Traces the rays of `view`, a light of a sweep through `sheets`. `camera` tells which side of a surface is seen.
    SolidShadow(const Solids& solids, const LightView& view, const Sheets& sheets, const Camera& camera);

    /// What part of the light gets past the solids to 256 texel positions of sheet n, in [0, 1]: between rays that do
    /// and rays that do not it is linear. Multiplies `light`.
    void multiply(int n, const Real* u, const Real* v, Real* light) const;

    std::uint64_t rays() const { return m_hits.size(); }
    std::size_t bytes() const { return m_hits.size() * sizeof(float); }
    static std::size_t bytes(const LightView& view) {
        return std::size_t(view.width) * std::size_t(view.height) * sizeof(float);
    }

  private:
    LightView m_view;
    std::vector<float>
        m_hits;  // the last N of a sheet that a ray lights, in rows of the raster; infinity: it lights all
};

}  // namespace scrim
