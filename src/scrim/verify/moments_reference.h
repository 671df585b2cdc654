// SPDX-License-Identifier: Apache-2.0
// The reference for a picture that a shutter or a lens blurs: the mean of true pictures over time,
// by Gauss' rule with two points on more and more intervals, and over the lens, until a pixel stops
// changing. It does not depend on how the picture was rendered.
#pragma once

#include <scrim/scene/view_scene.h>
#include <scrim/verify/path_tracer.h>
#include <scrim/verify/reference.h>
#include <scrim/verify/verify.h>

#include <array>
#include <atomic>
#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace scrim {

/// Throws Error(usage) where the reference sees something else than the picture shows: it marches
/// through voxels, and not through points that are balls.
void checkVerifiable(const ViewScene& truth);

class MomentsReference {
  public:
    /// `truth` must outlive this object. If it has a single moment, this equals `Reference`.
    explicit MomentsReference(const ViewScene& truth);

    /// Fills in the references of `pixels`, and the variance of multiply scattered light in them. The number of paths
    /// follows from the noise in the calls before, never from that of the same pixels, which would bias their variance.
    /// `late` is asked in every step along a ray, by many threads; once it returns true, the rest is left out,
    /// and evaluate() returns false: the references of `pixels` are then worth nothing.
    bool evaluate(std::span<VerifiedPixel> pixels, const std::function<bool()>& late = {});

    /// The number of moments evaluated so far.
    std::size_t moments() const;

  private:
    struct OfMoment {
        std::unique_ptr<const ViewScene> scene;
        std::unique_ptr<const Reference> reference;
        std::unique_ptr<const PathTracer> paths;  // only on the first level
    };
    /// The moments of `2^level` times as many intervals as the first level has.
    const std::vector<OfMoment>& momentsOf(std::size_t level);
    void evaluateSingle(std::span<VerifiedPixel> pixels);
    void addScattered(std::span<VerifiedPixel> pixels, int paths);
    void choosePaths(std::span<const VerifiedPixel> pixels);
    std::vector<std::array<double, 4>> meansOver(std::span<const VerifiedPixel> pixels, std::size_t level);
    bool goesOn();
    std::function<bool()> stop();

    const ViewScene& m_truth;
    FieldSamplers m_samplers;
    std::size_t m_intervals = 1;                  // on the first level
    std::vector<std::vector<OfMoment>> m_levels;  // each level is made when it is first needed
    std::array<double, 4> m_brightest{};          // brightest mean seen so far in each channel
    int m_paths;                                  // for multiply scattered light, of a pixel or a square
    double m_noise = 0, m_light = 0;              // sums over the pixels so far: variance times paths, and the mean
    std::size_t m_seen = 0;                       // pixels in the sums
    std::function<bool()> m_late;                 // of the call that is being made
    std::atomic<bool> m_left = false;             // it was late
};

}  // namespace scrim
