// SPDX-License-Identifier: Apache-2.0
// The mean of frames of equal weight: the moments of motion blur become one picture.
#pragma once

#include <scrim/engine/model/frame.h>

#include <cstddef>
#include <vector>

namespace scrim {

class MeanFrame {
  public:
    /// The mean of `count` frames. `deepTolerance`: how much the deep picture may change because
    /// its samples are merged.
    explicit MeanFrame(int count, double deepTolerance = 0)
        : m_weight(1.0f / static_cast<float>(count)), m_deepTolerance(deepTolerance) {}

    /// Adds a frame, all of which have the same window and layers.
    void add(Frame frame);
    std::size_t deepBytes() const { return m_mean.deep ? m_mean.deep->bytes() : 0; }
    /// The mean of the `count` frames that were added so far.
    Image soFar(int count) const;
    /// The mean, once all frames were added. Depth is the nearest one; mean depth and motion are weighted by opacity.
    Frame take();

  private:
    void start(const Frame& frame);
    void addTo(std::vector<float>& sum, const std::vector<float>& values) const;
    void addDeep(const DeepImage& next);
    void addMotion(std::vector<float>& sum, const std::vector<float>& motion, const Image& image) const;
    void addDepth(std::vector<float>& sum, const std::vector<float>& depth, const Image& image);

    float m_weight;
    double m_deepTolerance;
    Frame m_mean;
    std::vector<float> m_alpha;  // summed over frames in which the pixel has a depth
};

}  // namespace scrim
