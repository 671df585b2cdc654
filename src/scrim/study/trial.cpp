// SPDX-License-Identifier: Apache-2.0
#include <scrim/study/trial.h>

#include <scrim/scene/quality.h>

#include <algorithm>
#include <limits>

namespace scrim {

double Trial::time() const {
    if (seconds.empty()) return 0;
    std::vector<double> sorted = seconds;
    std::sort(sorted.begin(), sorted.end());
    const std::size_t middle = sorted.size() / 2;
    return sorted.size() % 2 == 1 ? sorted[middle] : 0.5 * (sorted[middle - 1] + sorted[middle]);
}

bool sameDials(const Dials& a, const Dials& b) {
    const std::vector<DialInfo>& table = dialTable();
    return std::all_of(table.begin(), table.end(),
                       [&](const DialInfo& dial) { return dialText(a, dial.name) == dialText(b, dial.name); });
}

std::vector<std::size_t> markFront(std::vector<Trial>& trials, Kernel kernel) {
    std::vector<std::size_t> byTime;
    for (std::size_t i = 0; i < trials.size(); ++i) {
        trials[i].onFront = false;
        if (trials[i].run && trials[i].dials.kernel == kernel) byTime.push_back(i);
    }
    std::sort(byTime.begin(), byTime.end(),
              [&](std::size_t a, std::size_t b) { return trials[a].time() < trials[b].time(); });
    std::vector<std::size_t> front;
    double least = std::numeric_limits<double>::infinity();
    for (const std::size_t i : byTime) {
        if (trials[i].error.error >= least) continue;
        least = trials[i].error.error;
        trials[i].onFront = true;
        front.push_back(i);
    }
    return front;
}

std::optional<std::size_t> cheapestWithin(const std::vector<Trial>& trials, Kernel kernel, double tolerance) {
    std::optional<std::size_t> best;
    for (std::size_t i = 0; i < trials.size(); ++i) {
        const Trial& trial = trials[i];
        if (!trial.run || trial.dials.kernel != kernel || trial.error.error > tolerance) continue;
        if (!best || trial.time() < trials[*best].time()) best = i;
    }
    return best;
}

}  // namespace scrim
