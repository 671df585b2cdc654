// SPDX-License-Identifier: Apache-2.0
#include <scrim/study/chart.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <fmt/format.h>

namespace scrim {
namespace {

// Okabe and Ito's palette (2008) without its yellow, which is hard to see on white.
constexpr std::array<const char*, 7> kColours{"#999999", "#0072B2", "#D55E00", "#009E73",
                                              "#CC79A7", "#56B4E9", "#E69F00"};
constexpr int kLeft = 64, kRight = 20, kTop = 44, kBottom = 48;
constexpr double kMarker = 4;

// One logarithmic axis, which maps data to positions in the picture.
struct Axis {
    double low = std::numeric_limits<double>::infinity(), high = 0;  // range of the data
    double from = 0, to = 0;                                         // range in the picture

    void include(double v) {
        if (!(v > 0) || !std::isfinite(v)) return;
        low = std::min(low, v);
        high = std::max(high, v);
    }
    void finish(double pictureFrom, double pictureTo) {
        constexpr double kMargin = 1.15, kLeastRange = 2;
        if (high <= 0) low = high = 1;
        if (const double range = high / low; range < kLeastRange) {
            low /= std::sqrt(kLeastRange / range);
            high *= std::sqrt(kLeastRange / range);
        }
        low /= kMargin;
        high *= kMargin;
        from = pictureFrom;
        to = pictureTo;
    }
    double at(double v) const { return from + (to - from) * std::log(v / low) / std::log(high / low); }

    /// The ticks: 1, 2 and 5 times powers of ten, or powers alone where those would be too many.
    std::vector<double> ticks() const {
        std::vector<double> all;
        const bool wide = high / low > 1e3;
        for (int power = static_cast<int>(std::floor(std::log10(low))); std::pow(10.0, power) <= high; ++power)
            for (const double m : {1.0, 2.0, 5.0}) {
                const double v = m * std::pow(10.0, power);
                if (v >= low && v <= high && (!wide || m == 1)) all.push_back(v);
            }
        return all;
    }
};

std::string marker(int style, double x, double y) {
    const double r = kMarker;
    switch (style % 5) {
        case 1:
            return fmt::format(R"(<rect x="{:.1f}" y="{:.1f}" width="{}" height="{}"/>)", x - r, y - r, 2 * r, 2 * r);
        case 2:
            return fmt::format(R"(<path d="M{:.1f} {:.1f}l{} {}h{}z"/>)", x, y - 1.2 * r, 1.2 * r, 2.1 * r, -2.4 * r);
        case 3:
            return fmt::format(R"(<path d="M{:.1f} {:.1f}l{} {}l{} {}l{} {}z"/>)", x, y - 1.4 * r, 1.4 * r, 1.4 * r,
                               -1.4 * r, 1.4 * r, -1.4 * r, -1.4 * r);
        case 4:
            return fmt::format(R"(<path d="M{0:.1f} {1:.1f}l{2} {2}m0 {3}l{3} {2}" stroke-width="2"/>)", x - r, y - r,
                               2 * r, -2 * r);
        default:
            return fmt::format(R"(<circle cx="{:.1f}" cy="{:.1f}" r="{}"/>)", x, y, r);
    }
}

std::string axes(const Chart& chart, const Axis& x, const Axis& y) {
    std::string svg = fmt::format(R"(<text class="title" x="{}" y="16">{}</text>)", kLeft, htmlEscaped(chart.title));
    for (const double v : x.ticks())
        svg += fmt::format(
            R"(<path class="grid" d="M{0:.1f} {1}V{2}"/><text x="{0:.1f}" y="{3}" text-anchor="middle">{4:g}</text>)",
            x.at(v), kTop, chart.height - kBottom, chart.height - kBottom + 16, v);
    for (const double v : y.ticks())
        svg += fmt::format(
            R"(<path class="grid" d="M{0} {1:.1f}H{2}"/><text x="{3}" y="{4:.1f}" text-anchor="end">{5:g}</text>)",
            kLeft, y.at(v), chart.width - kRight, kLeft - 6, y.at(v) + 4, v);
    svg += fmt::format(R"(<text x="{}" y="{}" text-anchor="middle">{}</text>)", (kLeft + chart.width - kRight) / 2,
                       chart.height - 10, htmlEscaped(chart.xTitle));
    svg += fmt::format(R"svg(<text transform="translate(14 {}) rotate(-90)" text-anchor="middle">{}</text>)svg",
                       (kTop + chart.height - kBottom) / 2, htmlEscaped(chart.yTitle));
    return svg;
}

std::string series(const ChartSeries& s, const Axis& x, const Axis& y) {
    const char* colour = kColours[std::size_t(s.style) % kColours.size()];
    std::string line, marks, texts;
    for (const ChartPoint& p : s.points) {
        if (!(p.x > 0) || !(p.y > 0)) continue;
        const double px = x.at(p.x), py = y.at(p.y);
        line += fmt::format("{}{:.1f} {:.1f}", line.empty() ? "M" : "L", px, py);
        if (p.lower > 0 && p.upper > 0)
            marks += fmt::format(R"(<path d="M{:.1f} {:.1f}V{:.1f}"/>)", px, y.at(p.lower), y.at(p.upper));
        marks += fmt::format("<g><title>{}</title>{}</g>", htmlEscaped(p.label), marker(s.style, px, py));
        if (s.labels)
            texts += fmt::format(R"(<text class="label" x="{:.1f}" y="{:.1f}">{}</text>)", px + 8, py - 7,
                                 htmlEscaped(p.label));
    }
    std::string svg = fmt::format(R"(<g stroke="{0}" fill="{0}">)", colour);
    if (s.line && !line.empty()) svg += fmt::format(R"(<path fill="none" stroke-width="1.5" d="{}"/>)", line);
    return svg + marks + "</g>" + texts;
}

}  // namespace

std::string htmlEscaped(const std::string& text) {
    std::string out;
    for (const char c : text) switch (c) {
            case '&':
                out += "&amp;";
                break;
            case '<':
                out += "&lt;";
                break;
            case '>':
                out += "&gt;";
                break;
            case '"':
                out += "&quot;";
                break;
            default:
                out += c;
        }
    return out;
}

std::string chartAsSvg(const Chart& chart) {
    Axis x, y;
    for (const ChartSeries& s : chart.series)
        for (const ChartPoint& p : s.points) {
            if (!(p.x > 0) || !(p.y > 0)) continue;
            x.include(p.x);
            for (const double v : {p.y, p.lower, p.upper}) y.include(v);
        }
    x.finish(kLeft, chart.width - kRight);
    y.finish(chart.height - kBottom, kTop);

    std::string svg = fmt::format(
        R"(<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {0} {1}" width="{0}" height="{1}" role="img" )"
        R"(aria-label="{2}">)",
        chart.width, chart.height, htmlEscaped(chart.title));
    svg += axes(chart, x, y);
    for (const ChartSeries& s : chart.series) svg += series(s, x, y);
    // The key stands on the right above the chart, in the order of the series.
    double at = chart.width - kRight;
    for (auto s = chart.series.rbegin(); s != chart.series.rend(); ++s) {
        at -= 6.6 * double(s->name.size()) + 26;
        const char* colour = kColours[std::size_t(s->style) % kColours.size()];
        svg += fmt::format(R"(<g stroke="{0}" fill="{0}">{1}</g><text x="{2:.1f}" y="34">{3}</text>)", colour,
                           marker(s->style, at, 30), at + 8, htmlEscaped(s->name));
    }
    return svg + "</svg>\n";
}

}  // namespace scrim
