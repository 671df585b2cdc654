// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/mean_frame.h>

#include <algorithm>
#include <optional>
#include <span>
#include <utility>

namespace scrim {

void MeanFrame::add(Frame frame) {
    if (m_mean.image.rgba.empty()) start(frame);
    addTo(m_mean.image.rgba, frame.image.rgba);
    for (std::size_t i = 0; i < m_mean.layers.size(); ++i) {
        if (m_mean.layers[i].layer == Layer::motion)
            addMotion(m_mean.layers[i].data, frame.layers[i].data, frame.image);
        else if (m_mean.layers[i].layer == Layer::depth)
            addDepth(m_mean.layers[i].data, frame.layers[i].data, frame.image);
        else
            addTo(m_mean.layers[i].data, frame.layers[i].data);
    }
    if (frame.deep) addDeep(*frame.deep);
    m_mean.work += frame.work;
    m_mean.times += frame.times;
    m_mean.scatterError = std::max(m_mean.scatterError, frame.scatterError);
    m_mean.scatterConverged = m_mean.scatterConverged && frame.scatterConverged;
}

Image MeanFrame::soFar(int count) const {
    Image image = m_mean.image;
    for (float& value : image.rgba) value /= m_weight * static_cast<float>(count);
    return image;
}

Frame MeanFrame::take() {
    for (FrameLayer& layer : m_mean.layers)
        for (std::size_t i = 0; layer.layer == Layer::motion && i < layer.data.size(); ++i)
            if (const float alpha = m_mean.image.rgba[i / 2 * 4 + 3]; alpha > 0) layer.data[i] /= alpha;
    for (FrameLayer& layer : m_mean.layers)
        for (std::size_t i = 0; layer.layer == Layer::depth && i < m_alpha.size(); ++i)
            if (m_alpha[i] > 0) layer.data[2 * i + 1] /= m_alpha[i];
    if (const std::optional<DeepImage>& deep = m_mean.deep)
        m_mean.deep = deepImage(deep->window, [&](int x, int y) {
            const std::span<const DeepPiece> curve = deep->curve(x, y);
            return tidied(merged({curve.begin(), curve.end()}, 0.5 * m_deepTolerance));
        });
    return std::move(m_mean);
}

void MeanFrame::start(const Frame& frame) {
    m_mean.image = emptyImage(frame.image.window);
    m_alpha.resize(frame.image.rgba.size() / 4);
    for (const FrameLayer& layer : frame.layers)
        m_mean.layers.push_back({layer.layer, layer.light, std::vector<float>(layer.data.size()), layer.volume});
}

void MeanFrame::addTo(std::vector<float>& sum, const std::vector<float>& values) const {
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += m_weight * values[i];
}

// What is in front of a depth is the mean of what is in front of it at each moment.
void MeanFrame::addDeep(const DeepImage& next) {
    const double step = 0.5 * m_deepTolerance * double(m_weight);
    m_mean.deep = deepImage(next.window, [&](int x, int y) {
        std::vector<DeepTerm> terms;
        if (m_mean.deep) terms.push_back({m_mean.deep->curve(x, y)});
        terms.push_back({next.curve(x, y), double(m_weight), double(m_weight)});
        return merged(sumOf(terms), step);
    });
}

// Weighted by opacity.
void MeanFrame::addMotion(std::vector<float>& sum, const std::vector<float>& motion, const Image& image) const {
    for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += m_weight * image.rgba[i / 2 * 4 + 3] * motion[i];
}

// Both depths are 0 where nothing is visible.
void MeanFrame::addDepth(std::vector<float>& sum, const std::vector<float>& depth, const Image& image) {
    for (std::size_t i = 0; i < m_alpha.size(); ++i) {
        const float first = depth[2 * i], alpha = image.rgba[4 * i + 3];
        if (first == 0 && depth[2 * i + 1] == 0) continue;
        sum[2 * i] = m_alpha[i] > 0 ? std::min(sum[2 * i], first) : first;
        sum[2 * i + 1] += alpha * depth[2 * i + 1];
        m_alpha[i] += alpha;
    }
}

}  // namespace scrim
