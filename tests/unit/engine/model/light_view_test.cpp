// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/light/shadow_buffer.h>

#include <gtest/gtest.h>

namespace scrim::test {
namespace {

// A cell is a light ray: it must go through the same texels as a ray drawn from the source.
TEST(LightView, CellsOfADistantLightFollowItsDirection) {
    LightView view;
    view.tsSource = {0.4, -0.7, 0};
    view.first = {-10, -20};
    view.cell = 1.5;
    for (const int sheet : {0, 3, 1000}) {
        const LightView::Cells map = view.at(sheet);
        EXPECT_EQ(map.scale, 1.5);
        // Cell (4, 5) crosses N = 0 at first + 1.5 * (4, 5) and moves along by tsSource a sheet.
        EXPECT_NEAR(map.offsetU + 4 * map.scale, -10 + 6 + 0.4 * (sheet + 0.5), 1e-12);
        EXPECT_NEAR(map.offsetV + 5 * map.scale, -20 + 7.5 - 0.7 * (sheet + 0.5), 1e-12);
    }
}

TEST(LightView, CellsOfAPointLightMeetAtTheSource) {
    LightView view;
    view.distant = false;
    view.tsSource = {30, 40, -12.25};
    view.first = {-0.5, -0.25};
    view.cell = 0.01;
    for (const int sheet : {0, 7, 200}) {
        const LightView::Cells map = view.at(sheet);
        const double away = sheet + 0.5 + 12.25;
        EXPECT_NEAR(map.scale, 0.01 * away, 1e-12);
        EXPECT_NEAR(map.offsetU + 60 * map.scale, 30 + (-0.5 + 0.6) * away, 1e-10);
        EXPECT_NEAR(map.offsetV + 10 * map.scale, 40 + (-0.25 + 0.1) * away, 1e-10);
    }
}

TEST(LightView, OfAPointLightReachesOnlySheetsInFrontOfIt) {
    LightView view;
    view.distant = false;
    view.tsSource = {0, 0, 10.25};
    EXPECT_FALSE(view.reaches(9));   // behind
    EXPECT_FALSE(view.reaches(10));  // its middle is a quarter of a sheet away
    EXPECT_TRUE(view.reaches(11));
    view.tsSource.z = 10;
    EXPECT_TRUE(view.reaches(10));  // half a sheet is enough
    view.distant = true;
    EXPECT_TRUE(view.reaches(-5));
}

}  // namespace
}  // namespace scrim::test
