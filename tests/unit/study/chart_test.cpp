// SPDX-License-Identifier: Apache-2.0
#include <scrim/study/chart.h>

#include <gtest/gtest.h>

#include <regex>

namespace scrim::test {
namespace {

// Every circle's centre, in their order.
std::vector<std::pair<double, double>> circles(const std::string& svg) {
    std::vector<std::pair<double, double>> all;
    const std::regex circle(R"re(<title>.*?</title><circle cx="([0-9.]+)" cy="([0-9.]+)")re");
    for (auto i = std::sregex_iterator(svg.begin(), svg.end(), circle); i != std::sregex_iterator(); ++i)
        all.emplace_back(std::stod((*i)[1]), std::stod((*i)[2]));
    return all;
}

Chart chartOf(std::vector<ChartPoint> points) {
    return {"title", "x", "y", {{"series", std::move(points), false, false, 0}}};
}

TEST(Chart, AxesAreLogarithmic) {
    const auto at = circles(chartAsSvg(chartOf({{1, 0.01, "a"}, {10, 0.1, "b"}, {100, 1, "c"}})));
    ASSERT_EQ(at.size(), 3u);
    EXPECT_NEAR(at[1].first - at[0].first, at[2].first - at[1].first, 0.21);
    EXPECT_NEAR(at[1].second - at[0].second, at[2].second - at[1].second, 0.21);
    EXPECT_GT(at[1].first, at[0].first);
    EXPECT_LT(at[1].second, at[0].second);  // up
}

TEST(Chart, LeavesOutWhatNoLogarithmicAxisShows) {
    EXPECT_EQ(circles(chartAsSvg(chartOf({{1, 0, "a"}, {0, 1, "b"}, {-1, 1, "c"}, {1, 2, "d"}}))).size(), 1u);
    EXPECT_TRUE(circles(chartAsSvg(chartOf({}))).empty());
}

TEST(Chart, EscapesWhatIsMarkup) {
    const std::string svg = chartAsSvg(chartOf({{1, 1, "a<b & \"c\""}}));
    EXPECT_NE(svg.find("a&lt;b &amp; &quot;c&quot;"), std::string::npos);
    EXPECT_EQ(svg.find("a<b"), std::string::npos);
}

TEST(Chart, SeriesDifferInShapeToo) {
    Chart chart;
    for (int style = 0; style < 5; ++style) chart.series.push_back({"s", {{1, 1, "p"}}, false, false, style});
    const std::string svg = chartAsSvg(chart);
    for (const char* shape : {"<circle", "<rect", "h-", "l5.6 5.6"})
        EXPECT_NE(svg.find(shape), std::string::npos) << shape;
}

}  // namespace
}  // namespace scrim::test
