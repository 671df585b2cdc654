// SPDX-License-Identifier: Apache-2.0
// Charts on two logarithmic axes as SVG: no script, no font file, nothing to fetch. Series differ in colour (a palette
// that the colour-blind can tell apart), in the shape of their markers, and are named in the chart.
#pragma once

#include <string>
#include <vector>

namespace scrim {

struct ChartPoint {
    double x = 0, y = 0;          ///< > 0; others are left out
    std::string label;            ///< shown where the mouse rests on the marker
    double lower = 0, upper = 0;  ///< an interval around y; none where both are 0
};

struct ChartSeries {
    std::string name;
    std::vector<ChartPoint> points;
    bool line = false;    ///< joins the points in their order
    bool labels = false;  ///< labels are also written beside the points
    int style = 0;        ///< of colour and marker: equal numbers look alike in all charts
};

struct Chart {
    std::string title, xTitle, yTitle;
    std::vector<ChartSeries> series;
    int width = 720, height = 420;
};

std::string chartAsSvg(const Chart& chart);

/// `text` with what HTML and SVG take for markup escaped.
std::string htmlEscaped(const std::string& text);

}  // namespace scrim
