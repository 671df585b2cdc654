// SPDX-License-Identifier: Apache-2.0
#include <scrim/study/dial_sweep.h>

#include <scrim/scene/quality.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <string_view>

namespace scrim {
namespace {

double numberIn(const std::string& text) {
    double value = 0;
    std::from_chars(text.data(), text.data() + text.size(), value);
    return value;
}

DialSweep sized(std::string dial, std::vector<std::string> values) {
    DialSweep sweep{std::move(dial), std::move(values), {}, {}, {}, {}};
    for (const std::string& value : sweep.values) sweep.sizes.push_back(numberIn(value));
    return sweep;
}

DialSweep choice(std::string dial, std::vector<std::string> values) {
    return {std::move(dial), std::move(values), {}, {}, {}, {}};
}

// A sweep of counts, of which more is finer.
DialSweep steps(std::string dial, std::vector<std::string> values) {
    DialSweep sweep = sized(std::move(dial), std::move(values));
    for (double& size : sweep.sizes) size = 1 / size;
    return sweep;
}

void turn(Dials& dials, const std::string& dial, const std::string& value) {
    setDialFromText(dials, dial, value, "study");
}

// The settings by which `dials` differ from `base`, as a name.
std::string differenceName(const Dials& dials, const Dials& base) {
    std::string name;
    for (const DialInfo& dial : dialTable()) {
        const std::string value = dialText(dials, dial.name);
        if (value != dialText(base, dial.name)) name += (name.empty() ? "" : ", ") + dial.name + " " + value;
    }
    return name.empty() ? "the scene's own" : name;
}

// The dials that are varied along the front. The others are of no use there: they change what is
// shown, or serve comparison only.
constexpr std::array<std::string_view, 8> kTuned{"footprint_steps", "shadow_texel",      "shadow_filter",
                                                 "shade",           "max_slant",         "opacity_cutoff",
                                                 "scatter_cell",    "scatter_directions"};

}  // namespace

std::vector<DialSweep> dialSweeps(bool scattering) {
    std::vector<DialSweep> sweeps{
        sized("sheet_thickness", {"0.25", "0.5", "1", "1.5", "2", "3", "4"}),
        sized("texel", {"0.25", "0.35", "0.5", "0.7", "1", "1.4", "2", "3"}),
        steps("footprint_steps", {"32", "16", "8", "4", "2"}),
        choice("kernel", {"linear", "gaussian", "bspline"}),
        sized("shadow_texel", {"0.5", "1", "2", "4", "8"}),
        choice("shadow_filter", {"bilinear", "nearest"}),
        choice("shade", {"pixel", "texel"}),
        choice("splat", {"per-view", "shared"}),
        choice("max_slant", {"20", "30", "45", "60", "75"}),
        sized("opacity_cutoff", {"0.0001", "0.001", "0.01", "0.05", "0.2"}),
        sized("lod", {"0", "0.5", "1", "2"}),
    };
    if (!scattering) return sweeps;
    sweeps.push_back(sized("scatter_cell", {"1", "1.5", "2", "3", "4", "6"}));
    sweeps.push_back(steps("scatter_directions", {"256", "128", "64"}));
    return sweeps;
}

std::size_t addTrial(std::vector<Trial>& trials, const std::string& name, const Dials& dials) {
    const auto found =
        std::find_if(trials.begin(), trials.end(), [&](const Trial& t) { return sameDials(t.dials, dials); });
    if (found != trials.end()) return std::size_t(found - trials.begin());
    Trial trial;
    trial.name = name;
    trial.dials = dials;
    trials.push_back(std::move(trial));
    return trials.size() - 1;
}

void addSweeps(std::vector<Trial>& trials, std::vector<DialSweep>& sweeps, const Dials& base) {
    for (DialSweep& sweep : sweeps)
        for (const std::string& value : sweep.values) {
            Dials dials = base;
            turn(dials, sweep.dial, value);
            sweep.trials.push_back(addTrial(trials, differenceName(dials, base), dials));
        }
}

void addJoint(std::vector<Trial>& trials, const Dials& base) {
    for (const char* texel : {"2", "1.4", "1", "0.7", "0.5", "0.35", "0.25"})
        for (const char* thickness : {"4", "3", "2", "1.5", "1", "0.5"}) {
            Dials dials = base;
            turn(dials, "texel", texel);
            turn(dials, "sheet_thickness", thickness);
            addTrial(trials, differenceName(dials, base), dials);
        }
}

void addNeighbours(std::vector<Trial>& trials, const std::vector<DialSweep>& sweeps,
                   const std::vector<std::size_t>& front) {
    const Dials base = trials.front().dials;
    for (const std::size_t place : front)
        for (const DialSweep& sweep : sweeps) {
            if (std::find(kTuned.begin(), kTuned.end(), sweep.dial) == kTuned.end()) continue;
            const Dials from = trials[place].dials;
            const auto at = std::find(sweep.values.begin(), sweep.values.end(), dialText(from, sweep.dial));
            const auto i = at - sweep.values.begin();
            for (const auto other : {i - 1, i + 1}) {
                if (other < 0 || other >= static_cast<std::ptrdiff_t>(sweep.values.size())) continue;
                if (at == sweep.values.end() && other != 0) continue;
                Dials dials = from;
                turn(dials, sweep.dial, sweep.values[other]);
                addTrial(trials, differenceName(dials, base), dials);
            }
        }
}

}  // namespace scrim
