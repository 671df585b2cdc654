// SPDX-License-Identifier: Apache-2.0
// Sheets that are taken a few at a time are those of whole batches.
#include "support/fields.h"

#include <scrim/engine/plan/make_plan.h>
#include <scrim/engine/splat/extinction_sum.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>

namespace scrim::test {
namespace {

// Two boxes that meet, so that there are sums over volumes, too.
ViewScene twoBoxes() {
    ViewScene scene = orthographicScene(boxField({-9, -10, -8}, {3, 9, 7}, 0.5), {0.4, Rgb(0.9), {}}, 30, 64);
    scene.lights = {distantLight({1, -1, -0.4})};
    scene.volumes.push_back(scene.volumes.front());
    scene.volumes.back().field = boxField({0, -4, -12}, {8, 5, 6}, 0.5);
    return scene;
}

struct Sums {
    explicit Sums(const GroupPlan& group, const ViewScene& scene, const Plan& plan, int batch)
        : sums(scene, plan, group.sheets, group.lattice, batch, ExtinctionSum::eyeOf(group)) {}
    ExtinctionSum sums;

    // Plane p has the values and active tiles of another's plane.
    bool shows(int p, const ExtinctionSum& other, int of) const {
        const PlaneStack &own = sums.total(0), &theirs = other.total(0);
        for (int ty = 0; ty < own.tilesY(); ++ty)
            for (int tx = 0; tx < own.tilesX(); ++tx)
                if (own.active(p, tx, ty) != theirs.active(of, tx, ty)) return false;
        return std::equal(own.plane(p), own.plane(p) + own.width() * own.height(), theirs.plane(of));
    }
};

TEST(ExtinctionSum, TakenAFewSheetsAtATimeHasTheSheetsOfWholeBatches) {
    constexpr int kBatch = 8, kFew = 3;
    const ViewScene scene = twoBoxes();
    const Plan plan = makePlan(scene, 2);
    const GroupPlan& group = plan.groups.front();
    const int first = group.needed.first, end = std::min(first + 2 * kBatch + 5, group.needed.last);
    ASSERT_EQ(end, first + 2 * kBatch + 5);
    Sums few(group, scene, plan, kBatch), whole(group, scene, plan, end - first);
    const std::uint64_t all = whole.sums.splat(first, end - first, &group.needed);
    ASSERT_GT(whole.sums.total(0).activeCount(kBatch), 0);
    std::uint64_t footprints = 0;
    for (int sheet = first; sheet < end;) {
        const int count = few.sums.take(sheet, kFew, end, group.needed, footprints);
        ASSERT_GE(count, 1);
        ASSERT_LE(count, kFew);
        for (int p = 0; p < count; ++p) EXPECT_TRUE(few.shows(p, whole.sums, sheet - first + p)) << sheet + p;
        sheet += count;
    }
    EXPECT_EQ(footprints, all);  // each sheet was splatted once
}

}  // namespace
}  // namespace scrim::test
