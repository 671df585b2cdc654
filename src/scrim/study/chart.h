// SPDX-License-Identifier: Apache-2.0
// Charts with two logarithmic axes as SVG, without scripts, font files or anything else to download. Series differ in
// colour (from a palette for the colour-blind) and in the shape of their markers, and are named in the chart.
#pragma once

#include <string>
#include <vector>

namespace scrim {

struct ChartPoint {
    double x = 0, y = 0;          ///< > 0; points with other values are left out
    std::string label;            ///< shown when the mouse rests on the marker
    double lower = 0, upper = 0;  ///< an interval around y; none where both are 0
};

struct ChartSeries {
    std::string name;
    std::vector<ChartPoint> points;
    bool line = false;    ///< joins the points in their order
    bool labels = false;  ///< also writes labels beside the points
    int style = 0;        ///< selects colour and marker; equal numbers look the same in all charts
};

struct Chart {
    std::string title, xTitle, yTitle;
    std::vector<ChartSeries> series;
    int width = 720, height = 420;
};

std::string chartAsSvg(const Chart& chart);

/// `text` with the characters escaped that HTML and SVG take for markup.
std::string htmlEscaped(const std::string& text);

}  // namespace scrim
