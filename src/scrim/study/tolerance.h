// SPDX-License-Identifier: Apache-2.0
// From a tolerance to dials: how the error of a scene grows with its texels and sheets is measured in two quick renders,
// and the cheapest setting that should stay below the tolerance is taken.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/study/study.h>

#include <array>

namespace scrim {

/// Of the dials `texel` and `sheet_thickness`, in voxels, and the relative RMSE that they gave.
struct Pilot {
    double texel = 0, thickness = 0, error = 0;
};

/// error^2 = (texels texel^p)^2 + (sheets thickness^p)^2: the errors of the two are independent, and of about the same
/// order.
struct ToleranceModel {
    /// p. Studies of smoke, clouds and scans find 1.5 to 2 for either: kinks of the field, and opaque edges, take a little
    /// off the second order of smooth fields.
    static constexpr double kOrder = 1.8;

    double texels = 0, sheets = 0;

    double predict(double texel, double thickness) const;
};

/// Where to measure: two settings about as accurate as `tolerance`, since orders only hold so far; the second has sheets
/// half as thick. Their errors are 0.
std::array<Pilot, 2> pilotsFor(double tolerance);

/// The model through both.
ToleranceModel fitModel(const std::array<Pilot, 2>& pilots);

/// A model of errors `factor` times as large.
ToleranceModel scaled(const ToleranceModel& model, double factor);

struct ToleranceChoice {
    Dials dials;
    double predicted = 0;  ///< error
    bool reachable = true; ///< false: the finest dials that are tried are predicted to miss it
};

/// The cheapest dials, by expectedSeconds, that `model` predicts to stay a safe way below `tolerance`. All other dials
/// are those of `base`, but for footprint steps and the opacity cut-off, which must not spoil it.
ToleranceChoice chooseDials(const ViewScene& scene, const ToleranceModel& model, double tolerance);

/// Renders the pilots of `scene` and fills in their errors against the reference of `exact` (the same scene, but for
/// levels of detail) at `pixels` random pixels, other ones than those of a verification. Throws Error.
void runPilots(std::array<Pilot, 2>& pilots, const ViewScene& scene, const ViewScene& exact, int pixels,
               const ProgressSink& progress = {});

}  // namespace scrim
