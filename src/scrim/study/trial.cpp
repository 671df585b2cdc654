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

void shareTimes(std::vector<Trial>& trials) {
    const auto same = [](const Trial& a, const Trial& b) {
        return a.run && b.run && a.work == b.work && a.dials.simd == b.dials.simd;
    };
    std::vector<bool> done(trials.size());
    for (std::size_t i = 0; i < trials.size(); ++i) {
        if (done[i]) continue;
        std::vector<double> seconds;
        for (const Trial& other : trials)
            if (same(trials[i], other)) seconds.insert(seconds.end(), other.seconds.begin(), other.seconds.end());
        for (std::size_t j = i; j < trials.size(); ++j)
            if (same(trials[i], trials[j])) {
                trials[j].seconds = seconds;
                done[j] = true;
            }
    }
}

bool isSlower(const Trial& a, const Trial& b) {
    constexpr double kNoise = 1.1;
    if (a.seconds.empty() || b.seconds.empty() || a.work == b.work) return false;
    return a.time() > kNoise * b.time() && *std::min_element(a.seconds.begin(), a.seconds.end()) >
                                               *std::max_element(b.seconds.begin(), b.seconds.end());
}

std::vector<std::size_t> markFront(std::vector<Trial>& trials, Kernel kernel) {
    std::vector<std::size_t> byTime;
    for (std::size_t i = 0; i < trials.size(); ++i) {
        trials[i].onFront = false;
        if (trials[i].run && trials[i].dials.kernel == kernel) byTime.push_back(i);
    }
    std::stable_sort(byTime.begin(), byTime.end(),
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
        if (!best || isSlower(trials[*best], trial)) best = i;
    }
    return best;
}

}  // namespace scrim
