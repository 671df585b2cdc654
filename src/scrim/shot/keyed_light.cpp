// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/keyed_light.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace scrim {
namespace {

// All that the picture is linear in. What emits without a ramp does so by the product of two of
// these, which becomes one.
std::vector<double*> brightnesses(Scene& scene) {
    std::vector<double*> all;
    const auto add = [&](Rgb& colour) {
        for (int c = 0; c < 3; ++c) all.push_back(&colour[c]);
    };
    for (Light& light : scene.lights) add(light.intensity);
    add(scene.ambient);
    for (SceneVolume& volume : scene.volumes)
        for (Emission& emission : volume.emission) {
            if (emission.ramp.empty()) {
                emission.color *= std::exchange(emission.scale, 1);
                add(emission.color);
            } else {
                all.push_back(&emission.scale);
            }
        }
    return all;
}

std::vector<double> valuesOf(Scene scene) {
    std::vector<double> values;
    for (const double* value : brightnesses(scene)) values.push_back(*value);
    return values;
}

}  // namespace

KeyedLight::KeyedLight(const LoadedShot& shot, double open, double close) : m_open(open), m_close(close) {
    constexpr int kFew = 17, kMany = 128;  // a flash of a tenth of the time is known to 1 %, ramps to far less
    if (!(close > open)) return;
    const auto values = [&](int count) {
        std::vector<std::vector<double>> all;
        for (int i = 0; i < count; ++i)
            all.push_back(valuesOf(shot.sceneAt(open + (i + 0.5) / count * (close - open))));
        return all;
    };
    const auto few = values(kFew);
    if (std::ranges::adjacent_find(few, std::not_equal_to<>()) == few.end()) return;
    m_values = values(kMany);
}

void KeyedLight::average(double from, double to, Scene& scene) const {
    if (m_values.empty() || !(to > from)) return;
    const double perTime = double(m_values.size()) / (m_close - m_open);
    const double first = std::clamp((from - m_open) * perTime, 0.0, double(m_values.size())),
                 last = std::clamp((to - m_open) * perTime, 0.0, double(m_values.size()));
    const std::vector<double*> all = brightnesses(scene);
    std::vector<double> sums(all.size(), 0.0);
    double length = 0;
    for (auto i = std::size_t(first); i < m_values.size() && double(i) < last; ++i) {
        const double part = std::min(double(i + 1), last) - std::max(double(i), first);
        for (std::size_t k = 0; k < sums.size(); ++k) sums[k] += part * m_values[i][k];
        length += part;
    }
    for (std::size_t k = 0; k < sums.size() && length > 0; ++k) *all[k] = sums[k] / length;
}

}  // namespace scrim
