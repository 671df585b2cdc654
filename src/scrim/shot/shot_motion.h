// SPDX-License-Identifier: Apache-2.0
// A loaded shot while its shutter is open, and from all places on its lens: its views moment by
// moment, and the picture that is their mean. The radiance of whole renders is averaged, so that
// occlusion and shadows are right at every moment.
#pragma once

#include <scrim/engine/model/frame.h>
#include <scrim/engine/plan/make_plan.h>
#include <scrim/shot/keyed_light.h>
#include <scrim/shot/load_shot.h>
#include <scrim/shot/shot_options.h>

#include <memory>

namespace scrim {

class ShotMotion {
  public:
    /// `shot` and `options` must outlive this object and all views. If nothing in the shot moves while the shutter is
    /// open, and everything is sharp, there is one moment, the shot's frame. Otherwise small pilot renders choose how
    /// many moments the picture needs, unless the dial says so. Throws Error.
    ShotMotion(const LoadedShot& shot, const RenderOptions& options);
    ~ShotMotion();

    /// True if the picture is a mean of moments.
    bool blurs() const { return m_moments != nullptr; }
    /// The number of renders that the picture averages.
    int samples() const { return m_samples; }

    /// The view in the middle of the shutter, with the shutter's data for the plan and the dials of
    /// each moment. Throws Error.
    ViewScene view() const;
    /// The scene that the picture is compared with.
    ViewScene truth() const;

    /// Plans and renders the samples with the dials of `view`, and returns their mean. `plan`: that
    /// of `view`. Depth is the nearest one, mean depth is averaged by opacity. Throws Error.
    Frame render(const ViewScene& view, const Plan& plan, const ProgressSink& progress) const;

  private:
    class Moments;
    /// The view of a moment that the engine renders.
    ViewScene viewAt(const Moment& moment) const;
    Scene sceneAt(const Moment& moment) const;
    double largestBlur() const;
    double longestPath();
    int samplesFor(double path) const;
    double wantedSamples(double error, double most) const;
    void chooseDials();
    double promised() const;
    double middle() const { return 0.5 * (m_shutter.open + m_shutter.close); }
    Moment momentOf(int i, int count) const;

    const LoadedShot& m_shot;
    const RenderOptions& m_options;
    Shutter m_shutter;
    KeyedLight m_light;                        // while it is open
    std::shared_ptr<const Moments> m_moments;  // null: there is one moment
    bool m_moves = false;                      // something moves while the shutter is open
    double m_path = 0;                         // pixels
    double m_blur = 0;                         // by the lens: the largest diameter of a point, pixels
    double m_voxelPixels = 1;                  // pixels that a voxel covers
    int m_samples = 1;
    ViewScene m_middle;  // with the dials of each moment
};

}  // namespace scrim
