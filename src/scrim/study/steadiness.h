// SPDX-License-Identifier: Apache-2.0
// How steady frames are in time. What moves evenly has small second differences I(t-1) - 2 I(t) + I(t+1); what pops or
// flickers has large ones. True frames have second differences, too, so those of converged frames are taken away.
#pragma once

#include <cstddef>
#include <string>
#include <utility>
#include <vector>

namespace scrim {

/// Pixels darker than this part of the largest of a layer's three frames do not count.
inline constexpr double kSteadyPart = 0.02;

/// A layer of one frame: R, G and B of each pixel, rows from top to bottom.
struct SteadyLayer {
    std::string name;
    std::vector<float> rgb;
};

/// Root mean squares of second differences over R, G and B, relative to the mean of the converged
/// layer over all frames and pixels that count.
struct SecondDifferences {
    double shown = 0;      ///< of the frames
    double converged = 0;  ///< of the converged frames
    double excess = 0;     ///< of the difference between the two
    /// The difference itself, no second difference. One that is new in each frame has an excess of
    /// 2.4 times of it, one that stands has none.
    double error = 0;
};

struct LayerSteadiness {
    std::string name;
    SecondDifferences all;
    /// For each frame but the first and the last: its number, and its part of `all`.
    std::vector<std::pair<int, SecondDifferences>> frames = {};
    double mean = 0;         ///< of the converged layer; 0: nothing counts, and so is all else
    std::size_t pixels = 0;  ///< number of pixels that count, in all frames
    /// The largest excess of a pixel, as root mean square over R, G and B, relative to `mean`; where and when.
    double worst = 0;
    int worstFrame = 0, worstX = 0, worstY = 0;
};

/// Measures frame after frame, and keeps three of them.
class SteadinessMeter {
  public:
    /// `width`: pixels in a row.
    explicit SteadinessMeter(int width) : m_width(width) {}

    /// Adds a frame. Both lists have the same layers in every call, in one order and of one size.
    /// Throws Error(input) where they have not.
    void add(int frame, std::vector<SteadyLayer> shown, std::vector<SteadyLayer> converged);

    /// One for each layer; at least three frames must have been added, else nothing counts.
    std::vector<LayerSteadiness> layers() const;

  private:
    struct Moment {
        int frame = 0;
        std::vector<SteadyLayer> shown, converged;
    };
    /// Sums over the pixels that count, of the frame in the middle of three.
    struct Sums {
        int frame = 0;
        double shown = 0, converged = 0, excess = 0, error = 0;  ///< squares
        double light = 0;
        std::size_t pixels = 0;
        double worst = 0;  ///< mean square
        std::size_t worstPixel = 0;
    };

    Sums sumsOf(std::size_t layer) const;

    int m_width;
    std::vector<Moment> m_moments;          // the last three
    std::vector<std::vector<Sums>> m_sums;  // for each layer, frame by frame
    std::vector<std::string> m_names;
};

}  // namespace scrim
