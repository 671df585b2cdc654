// SPDX-License-Identifier: Apache-2.0
// Shadows of solids: for each ray of a light's raster, where it first meets a surface. In contrast to optical depth,
// this is known before the sweep begins, and is a single number for each ray.
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
    /// Traces the rays of `view`, a light of a sweep through `sheets`. `camera` tells which side of a surface is
    /// visible.
    SolidShadow(const Solids& solids, const LightView& view, const Sheets& sheets, const Camera& camera);

    /// Multiplies `light` by the fraction, in [0, 1], that passes the solids to 256 texel positions of sheet n. It is
    /// interpolated linearly between rays that pass and rays that do not.
    void multiply(int n, const Real* u, const Real* v, Real* light) const;

    std::uint64_t rays() const { return m_hits.size(); }
    std::size_t bytes() const { return m_hits.size() * sizeof(float); }
    static std::size_t bytes(const LightView& view) {
        return std::size_t(view.width) * std::size_t(view.height) * sizeof(float);
    }

  private:
    LightView m_view;
    // The last N of a sheet that each ray lights, in rows of the raster; infinity: it lights all sheets.
    std::vector<float> m_hits;
};

}  // namespace scrim
