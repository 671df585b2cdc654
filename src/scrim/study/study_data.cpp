// SPDX-License-Identifier: Apache-2.0
#include <scrim/study/study_data.h>

#include <scrim/scene/quality.h>

#include <algorithm>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace scrim {
namespace {

using Json = nlohmann::ordered_json;

Json dialsJson(const Dials& dials) {
    Json all;
    for (const DialInfo& dial : dialTable()) all[dial.name] = dialText(dials, dial.name);
    return all;
}

Json placeJson(const std::optional<std::size_t>& place) {
    return place ? Json(*place) : Json(nullptr);
}

Json trialJson(const Trial& t) {
    Json out{{"name", t.name}, {"dials", dialsJson(t.dials)}, {"run", t.run}};
    if (!t.run) {
        out["skipped"] = t.skipped;
        return out;
    }
    out["error"] = t.error.error;
    out["error_interval"] = {t.error.lower, t.error.upper};
    out["bias"] = t.error.bias;
    out["worst"] = t.error.worst;
    out["worst_pixel"] = {t.error.worstX, t.error.worstY};
    out["pixels"] = t.error.pixels;
    out["seconds"] = t.seconds;
    out["median_seconds"] = t.time();
    out["on_front"] = t.onFront;
    out["work"] = {{"footprints", t.work.footprints},      {"texels_shaded", t.work.texelsShaded},
                   {"light_samples", t.work.lightSamples}, {"light_lookups", t.work.shade.lightLookups},
                   {"pixel_sheets", t.work.pixelSheets},   {"buffer_bytes", t.work.bytes.total()}};
    return out;
}

std::string quoted(const std::string& text) {
    return "\"" + text + "\"";  // names contain no quotes
}

}  // namespace

std::string studyAsCsv(const Study& study) {
    std::string text =
        "setting,run,on_front,error,error_lower,error_upper,bias,worst,median_seconds,least_seconds,most_seconds,"
        "repeats,footprints,texels_shaded,light_samples,pixel_sheets,buffer_bytes";
    for (const DialInfo& dial : dialTable()) text += "," + dial.name;
    text += "\n";
    for (const Trial& t : study.trials) {
        const auto [least, most] = std::minmax_element(t.seconds.begin(), t.seconds.end());
        text += quoted(t.name);
        text += fmt::format(",{},{}", t.run ? 1 : 0, t.onFront ? 1 : 0);
        if (t.run)
            text += fmt::format(",{},{},{},{},{},{},{},{},{}", t.error.error, t.error.lower, t.error.upper,
                                t.error.bias, t.error.worst, t.time(), *least, *most, t.seconds.size());
        else
            text += ",,,,,,,,,0";
        text += fmt::format(",{},{},{},{},{}", t.work.footprints, t.work.texelsShaded, t.work.lightSamples,
                            t.work.pixelSheets, t.work.bytes.total());
        for (const DialInfo& dial : dialTable()) text += "," + dialText(t.dials, dial.name);
        text += "\n";
    }
    return text;
}

std::string studyAsJson(const Study& study, const std::string& scene) {
    Json out{{"scene", scene},
             {"pixels", study.pixels},
             {"threads", study.threads},
             {"seconds", study.spent},
             {"out_of_time", study.outOfTime},
             {"mean_reference", study.meanReference},
             {"error", "relative RMSE over R, G, B against the brute-force reference; 95 % interval by bootstrap"}};
    for (const auto& [name, trial] : study.presets) out["presets"][name] = trial;
    out["front"] = study.front;
    for (const Recommendation& r : recommendations(study))
        out["recommendations"].push_back(
            {{"tolerance", r.tolerance},
             {"trial", placeJson(r.trial)},
             {"render", r.trial ? Json(renderBlock(study.trials[*r.trial].dials)) : Json(nullptr)}});
    for (const DialSweep& sweep : study.sweeps)
        out["sweeps"].push_back({{"dial", sweep.dial},
                                 {"values", sweep.values},
                                 {"trials", sweep.trials},
                                 {"order", sweep.order ? Json(*sweep.order) : Json(nullptr)}});
    for (const DialWorth& worth : worthOfDials(study))
        out["worth"].push_back({{"dial", worth.dial},
                                {"finer", placeJson(worth.finer)},
                                {"coarser", placeJson(worth.coarser)},
                                {"verdict", worth.verdict}});
    for (const Trial& trial : study.trials) out["trials"].push_back(trialJson(trial));
    return out.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace scrim
