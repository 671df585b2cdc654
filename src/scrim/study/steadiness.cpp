// SPDX-License-Identifier: Apache-2.0
#include <scrim/study/steadiness.h>

#include <scrim/base/error.h>

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

namespace scrim {
namespace {

constexpr std::size_t kChannels = 3;

// The second difference of value i in three frames.
double secondDifference(const std::array<const float*, 3>& frames, std::size_t i) {
    return double(frames[0][i]) - 2 * double(frames[1][i]) + double(frames[2][i]);
}

double lightOf(const float* rgb) {
    return (double(rgb[0]) + double(rgb[1]) + double(rgb[2])) / kChannels;
}

void requireSame(const std::vector<SteadyLayer>& layers, const std::vector<std::string>& names, std::size_t values,
                 int frame) {
    bool same = layers.size() == names.size();
    for (std::size_t i = 0; same && i < layers.size(); ++i)
        same = layers[i].name == names[i] && layers[i].rgb.size() == values;
    if (!same)
        throw Error(ErrorKind::input,
                    fmt::format("frame {} has other layers or another size than the frames before it", frame));
}

}  // namespace

void SteadinessMeter::add(int frame, std::vector<SteadyLayer> shown, std::vector<SteadyLayer> converged) {
    if (m_names.empty()) {
        for (const SteadyLayer& layer : shown) m_names.push_back(layer.name);
        m_sums.resize(shown.size());
    }
    const std::vector<SteadyLayer>& first = m_moments.empty() ? shown : m_moments.front().shown;
    const std::size_t values = first.empty() ? 0 : first.front().rgb.size();
    requireSame(shown, m_names, values, frame);
    requireSame(converged, m_names, values, frame);
    m_moments.push_back({frame, std::move(shown), std::move(converged)});
    if (m_moments.size() > 3) m_moments.erase(m_moments.begin());
    if (m_moments.size() < 3) return;
    for (std::size_t i = 0; i < m_names.size(); ++i) m_sums[i].push_back(sumsOf(i));
}

SteadinessMeter::Sums SteadinessMeter::sumsOf(std::size_t layer) const {
    std::array<const float*, 3> shown{}, converged{};
    for (std::size_t t = 0; t < 3; ++t) {
        shown[t] = m_moments[t].shown[layer].rgb.data();
        converged[t] = m_moments[t].converged[layer].rgb.data();
    }
    const std::size_t pixels = m_moments[0].shown[layer].rgb.size() / kChannels;
    // The brightest of the three frames counts, as shown and converged, so that what pops up in one of them does, too.
    const auto brightest = [&](std::size_t pixel) {
        double light = 0;
        for (std::size_t t = 0; t < 3; ++t)
            light = std::max({light, lightOf(shown[t] + kChannels * pixel), lightOf(converged[t] + kChannels * pixel)});
        return light;
    };
    double largest = 0;
    for (std::size_t p = 0; p < pixels; ++p) largest = std::max(largest, brightest(p));
    Sums sums{m_moments[1].frame};
    for (std::size_t p = 0; p < pixels; ++p) {
        if (brightest(p) <= kSteadyPart * largest) continue;
        double excess = 0;
        for (std::size_t i = kChannels * p; i < kChannels * (p + 1); ++i) {
            const double a = secondDifference(shown, i), b = secondDifference(converged, i);
            sums.shown += a * a;
            sums.converged += b * b;
            excess += (a - b) * (a - b);
            sums.error += std::pow(double(shown[1][i]) - double(converged[1][i]), 2);
        }
        sums.excess += excess;
        for (const float* frame : converged) sums.light += lightOf(frame + kChannels * p) / 3;
        ++sums.pixels;
        if (excess <= kChannels * sums.worst) continue;
        sums.worst = excess / kChannels;
        sums.worstPixel = p;
    }
    return sums;
}

std::vector<LayerSteadiness> SteadinessMeter::layers() const {
    std::vector<LayerSteadiness> out;
    for (std::size_t i = 0; i < m_names.size(); ++i) {
        LayerSteadiness& layer = out.emplace_back();
        layer.name = m_names[i];
        Sums all;
        for (const Sums& frame : m_sums[i]) {
            all.shown += frame.shown, all.converged += frame.converged, all.excess += frame.excess;
            all.error += frame.error;
            all.light += frame.light, all.pixels += frame.pixels;
        }
        if (!(all.light > 0)) continue;
        layer.pixels = all.pixels;
        layer.mean = all.light / double(all.pixels);
        const auto relative = [&](const Sums& sums) {
            const double values = double(kChannels) * double(std::max<std::size_t>(sums.pixels, 1));
            const auto part = [&](double squares) { return std::sqrt(squares / values) / layer.mean; };
            return SecondDifferences{part(sums.shown), part(sums.converged), part(sums.excess), part(sums.error)};
        };
        layer.all = relative(all);
        for (const Sums& frame : m_sums[i]) {
            layer.frames.emplace_back(frame.frame, relative(frame));
            const double worst = std::sqrt(frame.worst) / layer.mean;
            if (worst <= layer.worst) continue;
            layer.worst = worst;
            layer.worstFrame = frame.frame;
            layer.worstX = int(frame.worstPixel) % m_width;
            layer.worstY = int(frame.worstPixel) / m_width;
        }
    }
    return out;
}

}  // namespace scrim
