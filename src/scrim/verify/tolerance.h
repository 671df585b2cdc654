// SPDX-License-Identifier: Apache-2.0
// From a tolerance to dials: how the error of a scene grows with its texels and sheets is measured in two quick
// renders, and the cheapest setting that should stay below the tolerance is taken.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/engine/model/frame.h>
#include <scrim/engine/plan/make_plan.h>
#include <scrim/verify/verify.h>

#include <array>
#include <functional>

namespace scrim {

/// Of the dials `texel` and `sheet_thickness`, in voxels, and the relative RMSE that they gave.
struct Pilot {
    double texel = 0, thickness = 0, error = 0;
};

/// error^2 = (texels texel^p)^2 + (sheets thickness^p)^2: the errors of the two are independent, and of about the same
/// order.
struct ToleranceModel {
    /// p. Studies of smoke, clouds and scans find 1.5 to 2 for either: kinks of the field, and opaque edges, take a
    /// little off the second order of smooth fields.
    static constexpr double kOrder = 1.8;

    double texels = 0, sheets = 0;

    double predict(double texel, double thickness) const;
};

/// Where to measure: two settings about as accurate as `tolerance`, since orders only hold so far; the second has
/// sheets half as thick. Their errors are 0.
std::array<Pilot, 2> pilotsFor(double tolerance);

/// The model through both.
ToleranceModel fitModel(const std::array<Pilot, 2>& pilots);

/// A model of errors `factor` times as large.
ToleranceModel scaled(const ToleranceModel& model, double factor);

struct ToleranceChoice {
    Dials dials;
    double predicted = 0;   ///< error
    bool reachable = true;  ///< false: the finest dials that are tried are predicted to miss it
};

/// The cheapest dials, by expectedSeconds, that `model` predicts to stay below `aim` of `tolerance`. All other dials
/// are those of `scene`, but for footprint steps and the opacity cut-off, which must not spoil it.
ToleranceChoice chooseDials(const ViewScene& scene, const ToleranceModel& model, double tolerance, double aim = 0.7,
                            const ProgressSink& progress = {});

/// Renders the pilots of `scene` and fills in their errors against the reference of `truth` (the same scene with all
/// its volumes at full resolution) at `pixels` pixels drawn with `seed`. Throws Error.
void runPilots(std::array<Pilot, 2>& pilots, const ViewScene& scene, const ViewScene& truth, int pixels, unsigned seed,
               const ProgressSink& progress = {});

struct ToleranceOptions {
    double tolerance = 0.01;  ///< relative RMSE
    int pixels = 300;         ///< of each verification; kAllPixels: all
    int pilotPixels = 96;
    int attempts = 3;  ///< renders at most
    unsigned seed = 1;
    double seconds = 0;  ///< each verification ends after this time; 0: never
    ProgressSink progress = {};
    std::function<void(double)> announce = {};  ///< as SampleOptions has it
    /// Renders what is not a pilot; none: engine/sweep.h does. Pilots are of the moment that both scenes are.
    std::function<Frame(const ViewScene&, const Plan&, const ProgressSink&)> render = {};
    std::function<void(const ViewScene&, const Plan&)> planned = {};  ///< called before each render but the pilots'
};

struct ToleranceResult {
    Frame frame;
    Plan plan;
    Dials dials;
    double predicted = 0;  ///< error, of the setting that was rendered last
    Verification verification;
    /// The error, and that of alpha, is below this with a confidence of 97.5 % each, however many attempts were made:
    /// each has its share of what is left.
    double bound = 0;
    bool outOfTime = false;  ///< the verification ended early
    int attempts = 0;        ///< renders
    bool met = false;        ///< bound <= tolerance; of a picture without anything in it: all of it was looked at
    struct {
        double pilots = 0, plan = 0, render = 0, verify = 0;
    } seconds;
};

/// Renders `scene` with the cheapest dials that pilots predict to do, and checks them at pixels drawn at random. Where
/// the bound misses the tolerance, tries finer dials, on fresh pixels: those that asked for finer dials cannot judge
/// them. `truth`: the same scene with all volumes at full resolution. Throws Error.
ToleranceResult renderWithin(const ViewScene& scene, const ViewScene& truth, const ToleranceOptions& options);

}  // namespace scrim
