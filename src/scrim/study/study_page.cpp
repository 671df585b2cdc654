// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/quality.h>
#include <scrim/study/study_page.h>

#include <scrim/image/preview.h>
#include <scrim/study/chart.h>
#include <scrim/study/error_picture.h>

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

namespace scrim {
namespace {

constexpr int kWidestPicture = 400;  // pixels; larger pictures are thinned

constexpr std::string_view kStyle = R"(
body{font:15px/1.5 system-ui,sans-serif;max-width:60em;margin:2em auto;padding:0 1em;color:#222;background:#fff}
h1{font-size:1.6em}h2{font-size:1.2em;margin-top:2em}
table{border-collapse:collapse;margin:.5em 0}th,td{padding:.2em .8em .2em 0;text-align:left;vertical-align:top}
th{border-bottom:1px solid #888}td.n,th.n{text-align:right;font-variant-numeric:tabular-nums}
svg{max-width:100%;height:auto}svg text{font:12px system-ui,sans-serif;fill:#222}svg text.title{font-weight:bold}
svg text.label{font-size:11px}svg .grid{stroke:#e3e3e3}figure{display:inline-block;margin:0 1em 1em 0}
figure img{display:block;max-width:100%;image-rendering:pixelated}figcaption{font-size:.9em;max-width:26em}
.charts svg{width:48%;min-width:340px}
)";

std::string percent(double part) {
    return fmt::format("{:.3g} %", 100 * part);
}

std::string timeText(double seconds) {
    return seconds < 0.9995 ? fmt::format("{:.3g} ms", 1e3 * seconds) : fmt::format("{:.3g} s", seconds);
}

std::string resultText(const Trial& t) {
    return fmt::format("{}: {} ({} to {}), {}", t.name, percent(t.error.error), percent(t.error.lower),
                       percent(t.error.upper), timeText(t.time()));
}

ChartPoint paretoPoint(const Trial& t, const std::string& label) {
    return {t.time(), 100 * t.error.error, label, 100 * t.error.lower, 100 * t.error.upper};
}

std::string paretoChart(const Study& study) {
    ChartSeries all{"settings", {}, false, false, 0}, front{"front", {}, true, false, 1},
        presets{"presets", {}, false, true, 2};
    for (const Trial& t : study.trials)
        if (t.run && !t.onFront) {
            ChartPoint point = paretoPoint(t, resultText(t));
            point.lower = point.upper = 0;
            all.points.push_back(point);
        }
    for (const std::size_t i : study.front)
        front.points.push_back(paretoPoint(study.trials[i], resultText(study.trials[i])));
    for (const auto& [name, i] : study.presets)
        if (study.trials[i].run) presets.points.push_back(paretoPoint(study.trials[i], name));
    return chartAsSvg({"Error against time", "seconds", "error, %", {all, front, presets}, 900, 520});
}

std::string dialChart(const Study& study, const DialSweep& sweep) {
    ChartSeries error{"error", {}, true, false, 1}, distance{"distance from the finest", {}, true, false, 2};
    for (std::size_t i = 0; i < sweep.trials.size(); ++i) {
        const Trial& t = study.trials[sweep.trials[i]];
        if (!t.run) continue;
        error.points.push_back(
            {sweep.sizes[i], 100 * t.error.error, resultText(t), 100 * t.error.lower, 100 * t.error.upper});
        if (!sweep.distances.empty())
            distance.points.push_back({sweep.sizes[i], 100 * sweep.distances[i], percent(sweep.distances[i]), 0, 0});
    }
    const std::string order = sweep.order ? fmt::format(": order {:.2f}", *sweep.order) : "";
    const bool inverse = sweep.dial == "footprint_steps";
    return chartAsSvg(
        {sweep.dial + order, inverse ? "1 / " + sweep.dial : sweep.dial, "%", {error, distance}, 480, 340});
}

std::string row(const std::vector<std::string>& cells, const char* tag = "td") {
    std::string text = "<tr>";
    for (std::size_t i = 0; i < cells.size(); ++i) text += fmt::format("<{0}>{1}</{0}>", tag, htmlEscaped(cells[i]));
    return text + "</tr>\n";
}

std::string trialRow(const std::string& first, const Trial& t) {
    return row({first, t.name, percent(t.error.error),
                fmt::format("{} to {}", percent(t.error.lower), percent(t.error.upper)), timeText(t.time())});
}

std::string recommendationTable(const Study& study) {
    std::string html = "<table>" + row({"error below", "setting", "error", "95 % interval", "time"}, "th");
    for (const Recommendation& r : recommendations(study))
        html += r.trial ? trialRow(percent(r.tolerance), study.trials[*r.trial])
                        : row({percent(r.tolerance), "none of those tried", "", "", ""});
    html += "</table>\n<p>To paste into a scene:</p>\n";
    std::string before;
    for (const Recommendation& r : recommendations(study)) {
        if (!r.trial) continue;
        const std::string block = renderBlock(study.trials[*r.trial].dials);
        if (block != before) html += "<pre># below " + percent(r.tolerance) + "\n" + htmlEscaped(block) + "</pre>\n";
        before = block;
    }
    return html;
}

std::string presetTable(const Study& study) {
    std::string html = "<table>" + row({"preset", "setting", "error", "95 % interval", "time"}, "th");
    for (const auto& [name, i] : study.presets)
        html += study.trials[i].run ? trialRow(name, study.trials[i]) : row({name, "not run", "", "", ""});
    return html + "</table>\n";
}

std::string choiceTable(const Study& study) {
    std::string html = "<table>" + row({"dial", "value", "error", "95 % interval", "time"}, "th");
    for (const DialSweep& sweep : study.sweeps) {
        if (!sweep.sizes.empty()) continue;
        for (std::size_t i = 0; i < sweep.trials.size(); ++i) {
            const Trial& t = study.trials[sweep.trials[i]];
            html +=
                t.run
                    ? row({sweep.dial, sweep.values[i], percent(t.error.error),
                           fmt::format("{} to {}", percent(t.error.lower), percent(t.error.upper)), timeText(t.time())})
                    : row({sweep.dial, sweep.values[i], t.skipped, "", ""});
        }
    }
    return html + "</table>\n";
}

std::string worthTable(const Study& study) {
    std::string html = "<table>" + row({"dial", "one value finer or coarser"}, "th");
    for (const DialWorth& worth : worthOfDials(study)) html += row({worth.dial, worth.verdict});
    return html + "</table>\n";
}

std::string base64(const std::vector<unsigned char>& bytes) {
    constexpr std::string_view kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        unsigned v = 0;
        for (std::size_t k = 0; k < 3; ++k) v = v << 8 | (i + k < bytes.size() ? bytes[i + k] : 0u);
        for (std::size_t k = 0; k < 4; ++k) out += i + k <= bytes.size() ? kDigits[v >> (18 - 6 * k) & 63u] : '=';
    }
    return out;
}

std::string figure(const DisplayImage& picture, const std::string& caption) {
    return fmt::format(
        "<figure><img alt=\"{0}\" src=\"data:image/png;base64,{1}\"><figcaption>{0}</figcaption></figure>\n",
        htmlEscaped(caption), base64(pictureBytes("page.png", picture)));
}

std::string pictures(const Study& study, const ColourConfig& colour) {
    const int stride = std::max(1, (study.picture.window.width() + kWidestPicture - 1) / kWidestPicture);
    std::string html = figure(thinned(colour.displayImage(study.picture, "", ""), stride),
                              "The picture: " + resultText(study.trials[study.best]));
    double scale = 0;
    for (const ErrorPicture& p : study.errorPictures)
        // The scale of the scene's own setting, where that is among them.
        if (p.trial == 0 || scale == 0) scale = errorScale(p.difference);
    for (const ErrorPicture& p : study.errorPictures)
        html += figure(errorPicture(p.difference, scale, stride),
                       fmt::format("{}: {}", p.name, percent(study.trials[p.trial].error.error)));
    return html + fmt::format(
                      "<p>Blue: too dark, orange: too bright, against the most accurate setting; full colour is "
                      "{} of the mean, and colour grows as the root of the error. One scale for all.</p>\n",
                      percent(scale / study.meanReference));
}

}  // namespace

std::string studyAsHtml(const Study& study, const std::string& scene, const ColourConfig& colour) {
    const auto run = std::count_if(study.trials.begin(), study.trials.end(), [](const Trial& t) { return t.run; });
    std::string html = fmt::format(
        "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\"><meta name=\"viewport\" "
        "content=\"width=device-width\"><title>{0}</title><style>{1}</style></head><body>\n<h1>What accuracy costs: "
        "{0}</h1>\n",
        htmlEscaped(scene), kStyle);
    html += fmt::format(
        "<p>{} settings of {} rendered on {} threads and compared with the brute-force reference at {} pixels, in "
        "{:.0f} s{}. Error is relative RMSE, with its 95 % interval; time the median of interleaved repeats, without "
        "loading. "
        "Rest the mouse on a point to read its setting.</p>\n",
        run, study.trials.size(), study.threads, study.pixels, study.spent,
        study.outOfTime ? "; the budget left no time for the rest" : "");
    html += "<h2>Settings to take</h2>\n" + recommendationTable(study) + paretoChart(study);
    html += "<h2>Presets</h2>\n" + presetTable(study);
    html += "<h2>What each dial buys</h2>\n<p>Around the scene's own setting: " +
            htmlEscaped(resultText(study.trials.front())) + ".</p>\n" + worthTable(study);
    html +=
        "<h2>Convergence</h2>\n<p>Each dial alone. Error stops falling where other dials cause it; the distance from "
        "the dial's own finest picture shows its order.</p>\n<div class=\"charts\">";
    for (const DialSweep& sweep : study.sweeps)
        if (!sweep.sizes.empty()) html += dialChart(study, sweep);
    html +=
        "</div>\n<h2>Choices</h2>\n<p>Each kernel against a reference with the same kernel.</p>\n" + choiceTable(study);
    if (!study.picture.rgba.empty()) html += "<h2>Where the errors are</h2>\n" + pictures(study, colour);
    return html + "</body></html>\n";
}

}  // namespace scrim
