// SPDX-License-Identifier: Apache-2.0
#include <scrim/study/steadiness_data.h>

#include <scrim/scene/quality.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

namespace scrim {
namespace {

using Json = nlohmann::ordered_json;

Json differencesJson(const SecondDifferences& d) {
    return {{"shown", d.shown}, {"converged", d.converged}, {"excess", d.excess}, {"error", d.error}};
}

Json layerJson(const LayerSteadiness& layer, double promised) {
    Json out{{"layer", layer.name}, {"pixels", layer.pixels}, {"mean", layer.mean}};
    out.update(differencesJson(layer.all));
    out["kept"] = layer.all.excess <= promised;
    out["worst"] = {{"excess", layer.worst}, {"frame", layer.worstFrame}, {"pixel", {layer.worstX, layer.worstY}}};
    for (const auto& [frame, differences] : layer.frames) {
        Json row{{"frame", frame}};
        row.update(differencesJson(differences));
        out["frames"].push_back(std::move(row));
    }
    return out;
}

}  // namespace

std::string steadinessAsCsv(const ShotSteadinessResult& result) {
    std::string text = "layer,frame,shown,converged,excess,error\n";
    const auto add = [&](const std::string& layer, const std::string& frame, const SecondDifferences& d) {
        text += fmt::format("\"{}\",{},{},{},{},{}\n", layer, frame, d.shown, d.converged, d.excess, d.error);
    };
    for (const LayerSteadiness& layer : result.layers) {
        add(layer.name, "", layer.all);
        for (const auto& [frame, differences] : layer.frames) add(layer.name, fmt::format("{}", frame), differences);
    }
    return text;
}

std::string steadinessAsJson(const ShotSteadinessResult& result, const std::string& scene) {
    Json out{{"scene", scene},
             {"frames", result.frames},
             {"resolution", {result.resolution.x, result.resolution.y}},
             {"threads", result.threads},
             {"seconds", result.seconds},
             {"quality", result.quality},
             {"promised", result.promised},
             {"kept", result.restless().empty()},
             {"excess",
              "RMS over R, G and B of the second difference in time of frame minus converged frame, relative "
              "to the layer's mean, over pixels above 2 % of the largest"},
             {"render", renderBlock(result.dials)},
             {"render_converged", renderBlock(result.converged)}};
    for (const LayerSteadiness& layer : result.layers) out["layers"].push_back(layerJson(layer, result.promised));
    return out.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

}  // namespace scrim
