// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/frame_range.h>

#include <scrim/base/error.h>

#include <gtest/gtest.h>

namespace scrim {
namespace {

using Frames = std::vector<int>;

std::string errorOf(const std::string& text) {
    try {
        parseFrameRange(text);
    } catch (const Error& error) {
        EXPECT_EQ(error.kind(), ErrorKind::usage);
        return error.what();
    }
    return "no error";
}

TEST(FrameRange, ReadsNumbersRangesAndSteps) {
    EXPECT_EQ(parseFrameRange("7"), Frames{7});
    EXPECT_EQ(parseFrameRange("1-7x2,60"), (Frames{1, 3, 5, 7, 60}));
    EXPECT_EQ(parseFrameRange("1-6x4"), (Frames{1, 5}));
    EXPECT_EQ(parseFrameRange("3-3, 10 , 1"), (Frames{3, 10, 1}));
}

TEST(FrameRange, ReadsNegativeFrames) {
    EXPECT_EQ(parseFrameRange("-5--1"), (Frames{-5, -4, -3, -2, -1}));
    EXPECT_EQ(parseFrameRange("-2-1"), (Frames{-2, -1, 0, 1}));
    EXPECT_EQ(parseFrameRange("-3"), Frames{-3});
}

TEST(FrameRange, KeepsAFrameOnce) {
    EXPECT_EQ(parseFrameRange("1-3,2-4,1"), (Frames{1, 2, 3, 4}));
}

TEST(FrameRange, RefusesColonsWithTheReason) {
    EXPECT_EQ(errorOf("1:10"),
              "frame range '1:10': ':' is not supported, because farm managers interpret it differently; write 1-48x2 "
              "for every second frame");
}

TEST(FrameRange, SaysWhatIsWrong) {
    const std::string expected = "; expected frames and ranges such as 1-48x2,60";
    EXPECT_EQ(errorOf(""), "frame range '': in '' the first frame is not a whole number" + expected);
    EXPECT_EQ(errorOf("1,,2"), "frame range '1,,2': in '' the first frame is not a whole number" + expected);
    EXPECT_EQ(errorOf("1-x"), "frame range '1-x': in '1-x' the last frame is not a whole number" + expected);
    EXPECT_EQ(errorOf("1-9x0"), "frame range '1-9x0': in '1-9x0' the step is not at least 1" + expected);
    EXPECT_EQ(errorOf("9-1"), "frame range '9-1': in '9-1' the last frame comes before the first" + expected);
    EXPECT_EQ(errorOf("1-9x2x"),
              "frame range '1-9x2x': in '1-9x2x' there is unexpected text after the frames" + expected);
    EXPECT_EQ(errorOf("1.5"), "frame range '1.5': in '1.5' there is unexpected text after the frames" + expected);
    EXPECT_EQ(errorOf("1-9999999999"),
              "frame range '1-9999999999': in '1-9999999999' the last frame is beyond 1000000000" + expected);
    EXPECT_EQ(errorOf("1-2000000"),
              "frame range '1-2000000': in '1-2000000' there are more than 1000000 frames" + expected);
}

TEST(FrameRange, TakesAMillionFrames) {
    EXPECT_EQ(parseFrameRange("1-1000000").size(), 1000000u);
}

}  // namespace
}  // namespace scrim
