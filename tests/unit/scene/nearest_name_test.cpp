// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/nearest_name.h>

#include <gtest/gtest.h>

namespace scrim {
namespace {

TEST(NearestName, FindsSlips) {
    EXPECT_EQ(nearestName("fvo", {"position", "fov", "up"}), "fov");
    EXPECT_EQ(nearestName("colour", {"color", "cone"}), "color");
    EXPECT_EQ(nearestName("shadow", {"shadows", "radius"}), "shadows");
}

TEST(NearestName, StaysSilentWhereNothingIsNear) {
    EXPECT_EQ(nearestName("lights", {"name", "file", "density"}), "");
    EXPECT_EQ(nearestName("x", {"up"}), "");
    EXPECT_EQ(nearestName(std::string(100000, 'a'), {"aa"}), "");
    EXPECT_EQ(didYouMean("zzz", {"up"}), "");
    EXPECT_EQ(didYouMean("nmae", {"name"}), "; did you mean 'name'?");
}

}  // namespace
}  // namespace scrim
