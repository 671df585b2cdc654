// SPDX-License-Identifier: Apache-2.0
#include <scrim/base/error.h>
#include <scrim/base/percent.h>

#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

namespace scrim::test {
namespace {

TEST(Error, CarriesItsKindAndText) {
    try {
        throw Error(ErrorKind::memory, "no room");
    } catch (const std::runtime_error& error) {  // what callers who know nothing of Scrim catch
        EXPECT_STREQ(error.what(), "no room");
        const auto* own = dynamic_cast<const Error*>(&error);
        ASSERT_NE(own, nullptr);
        EXPECT_EQ(own->kind(), ErrorKind::memory);
    }
}

TEST(Clipped, LeavesShortTextsAlone) {
    EXPECT_EQ(shortened(""), "");
    EXPECT_EQ(shortened("as it was: \xc3\xa4"), "as it was: \xc3\xa4");
    EXPECT_EQ(shortened(std::string(300, 'a')), std::string(300, 'a'));
}

TEST(Clipped, CutsLongTextsAndSaysSo) {
    EXPECT_EQ(shortened(std::string(301, 'a')), std::string(300, 'a') + "...");
    EXPECT_EQ(shortened("abcdef", 3), "abc...");
}

TEST(Clipped, HidesUnprintableBytes) {
    EXPECT_EQ(shortened(std::string_view("a\0b\x1b[31m\x7f", 8)), "a?b?[31m");
    EXPECT_EQ(shortened("\x7f\t\r"), "???");
    EXPECT_EQ(shortened("two\nlines"), "two lines");
}

TEST(PercentText, HasTwoDigitsAndAllOfLargerNumbers) {
    EXPECT_EQ(percentText(0), "0");
    EXPECT_EQ(percentText(0.00312), "0.31");
    EXPECT_EQ(percentText(0.17), "17");
    EXPECT_EQ(percentText(0.994), "99");
    EXPECT_EQ(percentText(0.996), "100");
    EXPECT_EQ(percentText(1.1), "110");
    EXPECT_EQ(percentText(12.345), "1234");
}

TEST(Choices, ReadLikeASentence) {
    EXPECT_EQ(choices({}), "none");
    EXPECT_EQ(choices({"a"}), "'a'");
    EXPECT_EQ(choices({"a", "b"}), "'a' or 'b'");
    EXPECT_EQ(choices({"a", "b", "c"}), "'a', 'b' or 'c'");
}

}  // namespace
}  // namespace scrim::test
