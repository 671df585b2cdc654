// SPDX-License-Identifier: Apache-2.0
// The sheets of one level during a sweep, and what a shader asks the sheets of other levels.
#pragma once

#include <scrim/engine/light/light_sweep.h>
#include <scrim/engine/model/plan.h>
#include <scrim/engine/splat/extinction_sum.h>

#include <vector>

namespace scrim {

struct LevelSheets {
    LevelSheets(const ViewScene& scene, const Plan& plan, const GroupPlan& of)
        : group(of),
          extinction(scene, plan, of.sheets, of.lattice, of.batchSheets, ExtinctionSum::eyeOf(of), of.volumes),
          lights(scene, plan, of) {}

    const GroupPlan& group;
    ExtinctionSum extinction;
    LightSweep lights;
    int sheet = 0;  ///< the first sheet of the batch
};

/// From texel space of one level to that of another. They differ in their steps and origins alone.
struct LevelMap {
    double texels = 1, sheets = 1;  ///< of the other level, for each of this one
    Vec3 first{0};                  ///< the other level's position of (0, 0, 0)

    LevelMap(const Sheets& from, const Sheets& to)
        : texels(from.texel / to.texel),
          sheets(from.thickness / to.thickness),
          first((from.ssOrigin - to.ssOrigin) * to.tsStep()) {}

    double u(double v) const { return first.x + texels * v; }
    double v(double v) const { return first.y + texels * v; }
    double n(double v) const { return first.z + sheets * v; }
    Box2<double> box(const Box2<double>& b) const { return {u(b.x0), v(b.y0), u(b.x1), v(b.y1)}; }
};

/// The other levels of a sweep. While sheets of a level are shaded, each coarser level has one
/// sheet in its batch, in which they lie.
struct OtherLevels {
    std::vector<const LevelSheets*> coarser, finer;
};

}  // namespace scrim
