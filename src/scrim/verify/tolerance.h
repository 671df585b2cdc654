// SPDX-License-Identifier: Apache-2.0
// Chooses dials for a tolerance: two quick renders measure how the error of a scene grows with its
// texels and sheets, and the cheapest setting that should stay below the tolerance is chosen.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/engine/model/frame.h>
#include <scrim/engine/plan/make_plan.h>
#include <scrim/verify/verify.h>

#include <array>
#include <functional>

namespace scrim {

/// A setting of the dials `texel` and `sheet_thickness`, in voxels, and the relative RMSE that it gave.
struct Pilot {
    double texel = 0, thickness = 0, error = 0;
};

/// error^2 = (texels texel^p)^2 + (sheets thickness^p)^2: the two errors are independent and of about the same order.
struct ToleranceModel {
    /// p. Studies of smoke, clouds and scans find 1.5 to 2 for both dials: kinks of the field and
    /// opaque edges lower the second order of smooth fields a little.
    static constexpr double kOrder = 1.8;

    double texels = 0, sheets = 0;

    double predict(double texel, double thickness) const;
};

/// The settings to measure: two that are about as accurate as `tolerance`, since orders only hold
/// over a short range. The second has sheets half as thick. Their errors are still 0.
std::array<Pilot, 2> pilotsFor(double tolerance);

/// The model that passes through both pilots.
ToleranceModel fitModel(const std::array<Pilot, 2>& pilots);

/// A model that predicts errors `factor` times as large.
ToleranceModel scaled(const ToleranceModel& model, double factor);

struct ToleranceChoice {
    Dials dials;
    double predicted = 0;   ///< error
    bool reachable = true;  ///< false: even the finest dials that are tried are predicted to miss the tolerance
};

/// The cheapest dials by expectedSeconds that `model` predicts to stay below `aim` times `tolerance`. All other dials
/// are those of `scene`, except that footprint steps and the opacity cut-off are made fine enough for the tolerance.
ToleranceChoice chooseDials(const ViewScene& scene, const ToleranceModel& model, double tolerance, double aim = 0.7,
                            const ProgressSink& progress = {});

/// Renders the pilots of `scene` and measures their errors against the reference of `truth` (the same scene with all
/// its volumes at full resolution) at `pixels` pixels drawn with `seed`. Throws Error.
void runPilots(std::array<Pilot, 2>& pilots, const ViewScene& scene, const ViewScene& truth, int pixels, unsigned seed,
               const ProgressSink& progress = {});

struct ToleranceOptions {
    double tolerance = 0.01;  ///< relative RMSE
    int pixels = 300;         ///< per verification; kAllPixels: all
    int pilotPixels = 96;
    int attempts = 3;  ///< largest number of renders
    unsigned seed = 1;
    double seconds = 0;  ///< each verification ends after this time; 0: no limit
    ProgressSink progress = {};
    std::function<void(double)> announce = {};  ///< as in SampleOptions
    /// Renders everything but pilots; without one, engine/sweep.h does. Pilots render the single
    /// moment that both scenes are.
    std::function<Frame(const ViewScene&, const Plan&, const ProgressSink&)> render = {};
    std::function<void(const ViewScene&, const Plan&)> planned = {};  ///< called before each render except for pilots
};

struct ToleranceResult {
    Frame frame;
    Plan plan;
    Dials dials;
    double predicted = 0;  ///< predicted error of the setting that was rendered last
    Verification verification;
    /// Both the error and that of alpha are below this, each with a confidence of 97.5 %, however
    /// many attempts were made: every attempt takes a share of the remaining 2.5 %.
    double bound = 0;
    PixelSample sample;  ///< the pixels of that verification
    int attempts = 0;    ///< renders
    bool met = false;    ///< bound <= tolerance; for a picture with nothing in it: all of it was examined
    struct {
        double pilots = 0, plan = 0, render = 0, verify = 0;
    } seconds;
};

/// Renders `scene` with the cheapest dials that pilots predict to suffice, and checks the result at
/// pixels drawn at random. Where the bound misses the tolerance, it tries finer dials and checks
/// them at fresh pixels, since the pixels that led to finer dials cannot judge them. `truth`: the
/// same scene with all volumes at full resolution. Throws Error.
ToleranceResult renderWithin(const ViewScene& scene, const ViewScene& truth, const ToleranceOptions& options);

}  // namespace scrim
