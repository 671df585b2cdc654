// SPDX-License-Identifier: Apache-2.0
// The path of the eye through a sheet at one sample, and where light on cells is looked up for it.
#pragma once

#include <scrim/base/real.h>
#include <scrim/base/simd.h>
#include <scrim/engine/model/eye_view.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace scrim {

/// The positions of a tile's samples, ws = origin + u perU + v perV in the middle of a sheet. `wsPerSheet` leads to the
/// next sheet along its normal, and a slope du/dw of 1 by `toTexels` along perU.
struct SamplePlane {
    Vec3 wsOrigin{0}, wsPerU{0}, wsPerV{0}, wsPerSheet{0};
    double toTexels = 1;
    double towardsEye = 0;  ///< 1 if the next sheet is nearer to the eye, -1 if it is farther; 0: it does not matter
    Simd simd = {};

    Vec3 wsSample(const SampleTile& samples, int k) const {
        const Vec3 onPlane = wsOrigin + double(samples.u[k]) * wsPerU + double(samples.v[k]) * wsPerV;
        return samples.at ? onPlane + (double(samples.at[k]) - double(samples.step)) * wsPerSheet : onPlane;
    }
    /// The part of the sheet that the eye's ray passes; above 0, also where it passes none.
    static double passed(const SampleTile& samples, int k) {
        constexpr double kLeast = 1e-4;
        return samples.part ? std::max(double(samples.part[k]), kLeast) : 1;
    }
};

/// Within a sheet light counts as the eye sees it through the part before. A thick sheet counts as two halves, since
/// light that fades within it does so as an exponential and not evenly. So does one in which a surface begins or ends.
struct SheetPath {
    static constexpr double kThick = 0.5;

    Vec3 wsMiddle;
    Vec3 ws;             ///< from where the eye's ray meets the sheet's one side to where it meets the other, or of the
                         ///< part that it passes
    bool thick;          ///< the optical depth of the sheet is above kThick
    Vec3 wsNear, wsFar;  ///< the middles of the halves that are nearer to and farther from the eye; not thick: both
                         ///< the middle
    Vec3 wsSeen;         ///< from such a middle to where light that changes evenly counts
    Vec3 wsSeenFar;      ///< the same for the farther half
    Real farther = 0;    ///< thick: the farther half's part of what the eye sees of the sheet

    /// `extinction`: per world unit, above 0; that of the half that is nearer to the eye: `nearer`,
    /// or the same if it is below 0.
    SheetPath(const SamplePlane& plane, const SampleTile& samples, int k, Real extinction, Real nearer = -1)
        : wsMiddle(plane.wsSample(samples, k)),
          ws(SamplePlane::passed(samples, k) *
             (plane.wsPerSheet +
              plane.toTexels * (double(samples.eyeA[k]) * plane.wsPerU + double(samples.eyeB[k]) * plane.wsPerV))) {
        const Vec3 ahead = plane.towardsEye * ws;
        const double tau = double(extinction) * glm::length(ws), half = 0.5 * tau;
        thick = tau > kThick;
        wsNear = thick ? wsMiddle + 0.25 * ahead : wsMiddle;
        wsFar = thick ? wsNear - 0.5 * ahead : wsMiddle;
        wsSeen = wsSeenFar = (thick ? 0.5 * nearerThanMiddle(half) : nearerThanMiddle(tau)) * ahead;
        if (thick) farther = static_cast<Real>(1 / (1 + std::exp(half)));
        if (nearer >= 0) divide(tau, std::min(double(nearer) / double(extinction), 2.0), ahead);
    }

  private:
    // Halves of different extinction; `part` is the nearer one's, relative to the mean.
    void divide(double tau, double part, const Vec3& ahead) {
        const double first = 0.5 * tau * part, second = tau - first;
        thick = true;
        wsNear = wsMiddle + 0.25 * ahead;
        wsFar = wsMiddle - 0.25 * ahead;
        const double seen = -std::expm1(-first), behind = -std::exp(-first) * std::expm1(-second);
        farther = static_cast<Real>(behind / (seen + behind));
        // If extinction changes evenly, more of it lies towards the denser end.
        const auto towardsDense = [&](double own) {
            return std::clamp((second - first) / (12 * std::max(own, 1e-6)), -1.0 / 6, 1.0 / 6);
        };
        wsSeen = 0.5 * (nearerThanMiddle(first) - towardsDense(first)) * ahead;
        wsSeenFar = 0.5 * (nearerThanMiddle(second) - towardsDense(second)) * ahead;
    }
    // The eye sees more of the nearer part. Light that changes evenly along its path, of optical
    // depth `tau`, counts as it is at coth(tau / 2) / 2 - 1 / tau of the path before the middle.
    static double nearerThanMiddle(double tau) {
        const double t2 = tau * tau;  // the series is exact to 1e-7
        return tau < 1 ? tau * (1.0 / 12) * (1 - t2 * (1.0 / 60) * (1 - t2 * (1.0 / 42) * (1 - t2 * (1.0 / 40))))
                       : 0.5 / std::tanh(0.5 * tau) - 1 / tau;
    }
};

}  // namespace scrim
