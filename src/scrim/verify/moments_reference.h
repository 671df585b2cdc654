// SPDX-License-Identifier: Apache-2.0
// The reference of a picture that a shutter blurs: the mean of true pictures over time, by Gauss' rule with two points
// on more and more intervals, until a pixel does not change any more. It knows nothing of how the picture was made.
#pragma once

#include <scrim/scene/view_scene.h>
#include <scrim/verify/path_tracer.h>
#include <scrim/verify/reference.h>
#include <scrim/verify/verify.h>

#include <array>
#include <memory>
#include <span>
#include <vector>

namespace scrim {

class MomentsReference {
  public:
    /// `truth` must outlive this. Where it is a single moment this is `Reference`.
    explicit MomentsReference(const ViewScene& truth);

    /// Fills in the references.
    void evaluate(std::span<VerifiedPixel> pixels);

    /// Moments that were looked at so far.
    std::size_t moments() const;

  private:
    struct Moment {
        std::unique_ptr<const ViewScene> scene;
        std::unique_ptr<const Reference> reference;
        std::unique_ptr<const PathTracer> paths;  // of the first level
    };
    /// The moments of `2^level` times as many intervals as there are first.
    const std::vector<Moment>& momentsOf(std::size_t level);
    void addScattered(std::span<VerifiedPixel> pixels) const;
    std::vector<std::array<double, 4>> meansOver(std::span<const VerifiedPixel> pixels, std::size_t level);

    const ViewScene& m_truth;
    FieldSamplers m_samplers;
    std::size_t m_intervals = 1;                // of the first level
    std::vector<std::vector<Moment>> m_levels;  // made when they are needed
    std::array<double, 4> m_brightest{};        // of all means so far
};

}  // namespace scrim
