// SPDX-License-Identifier: Apache-2.0
// Light on cells, less the mean error that linear interpolation between them adds.
#pragma once

#include <scrim/base/real.h>
#include <scrim/engine/cells/cell_field.h>
#include <scrim/geometry/spaces.h>

#include <algorithm>
#include <cmath>

namespace scrim {

/// Parts of the second difference along an axis: along that of the slices, the error of interpolation between the
/// centres of cells; along the others, light is also interpolated from rays to cells.
inline constexpr Real kBendAlong = Real(1.0 / 12), kBendAcross = Real(0.1);

/// One cell's light. What is subtracted is a part of the second difference along each axis; the result stays between
/// the least and the largest of the cell and its neighbours. A neighbour of 0 is not known, and its axis left out.
/// `steep`: light falls as exponentials do, as it does below surfaces. Of such a one, with q = d / value, about
/// 1 - (1 + q / 3)^(-1/4) is too much, which is q / 12 for small q.
class Sharpened {
  public:
    Sharpened(Real light, bool steep) : m_light(light), m_least(light), m_most(light), m_steep(steep) {}
    void along(Real perBend, Real low, Real high) {
        if (low == 0 || high == 0) return;
        const Real d = low + high - 2 * m_light;
        m_bend += m_steep && d > 0 && m_light > 0
                      ? m_light * (1 - 1 / std::sqrt(std::sqrt(1 + 4 * perBend * d / m_light)))
                      : perBend * d;
        m_least = std::min({m_least, low, high});
        m_most = std::max({m_most, low, high});
    }
    Real light() const { return std::clamp(m_light - m_bend, m_least, m_most); }

  private:
    Real m_light, m_least, m_most, m_bend = 0;
    bool m_steep;
};

/// Sharpens the light of a source at `wsSource`, which has come to each cell through the slices
/// along one of three axes.
void sharpenAround(const Vec3& wsSource, bool steep, CellField& light);

}  // namespace scrim
