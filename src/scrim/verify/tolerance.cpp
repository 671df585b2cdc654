// SPDX-License-Identifier: Apache-2.0
#include <scrim/verify/tolerance.h>

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/engine/sweep.h>
#include <scrim/engine/plan/make_plan.h>
#include <scrim/base/timed.h>
#include <scrim/verify/scatter_pilot.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

namespace scrim {
namespace {

// Differs from the seeds of verifications, because dials must not be tuned for their pixels.
constexpr unsigned kPilotSeed = 7919;
constexpr double kDoubt = 0.025;  // probability that the bound of any attempt lies below the error

constexpr double kAim = 0.7;  // fraction of the tolerance that the predicted error may take

// `aim` leaves room for a confidence interval up to this much wider than the error.
constexpr double kWidthAllowed = 1.3;

// The scene with sub-lights that may take half of the tolerance, so that neither pilots nor
// attempts fail because of them.
ViewScene litWithin(const ViewScene& scene, double tolerance) {
    ViewScene out = scene;
    out.dials.lightError = std::min(scene.dials.lightError, tolerance / 2);
    return out;
}

// Multiply scattered light may take this part of the tolerance, and cells shrink by this factor with each attempt.
constexpr double kOfScattering = 0.6, kFinerCells = 0.6;

// The dials of multiply scattered light for attempt number `attempt`, but for those that the scene states.
void scatterWithin(const std::optional<ScatterPilot>& pilot, const ViewScene& given, double tolerance, int attempt,
                   Dials& dials) {
    if (!pilot) return;
    const ScatterChoice choice = chooseScattering(*pilot, given.dials, kOfScattering * tolerance);
    dials.scatterDirections = choice.directions;
    dials.scatterCell =
        given.dials.scatterCell.value_or(std::max(choice.cell * std::pow(kFinerCells, attempt), kFinestScatterCell));
}

// True if `a` has any finer dial than `b`.
bool finer(const Dials& a, const Dials& b) {
    return a.texel < b.texel || a.sheetThickness < b.sheetThickness || a.scatterCell < b.scatterCell;
}

// The pixels of an attempt's verification.
SampleOptions samplingOf(const ToleranceOptions& options, int attempt, const ProgressSink& progress) {
    SampleOptions sampling;
    sampling.count = options.pixels;
    sampling.seed = options.seed + static_cast<unsigned>(attempt);
    sampling.seconds = options.seconds;
    sampling.progress = progress;
    if (attempt == 0) sampling.announce = options.announce;
    return sampling;
}

ViewScene turned(const ViewScene& scene, double texel, double thickness) {
    ViewScene out = scene;
    out.dials.texel = texel;
    out.dials.sheetThickness = thickness;
    return out;
}

}  // namespace

double ToleranceModel::predict(double texel, double thickness) const {
    return std::hypot(texels * std::pow(texel, kOrder), sheets * std::pow(thickness, kOrder));
}

std::array<Pilot, 2> pilotsFor(double tolerance) {
    constexpr double kTexelAtOnePercent = 1.2, kLeast = 0.6, kMost = 1.4;
    const double texel = std::clamp(kTexelAtOnePercent * std::sqrt(tolerance / 0.01), kLeast, kMost);
    return {Pilot{texel, 2 * texel, 0}, Pilot{texel, texel, 0}};
}

ToleranceModel fitModel(const std::array<Pilot, 2>& pilots) {
    // Each of the two takes at least this fraction of a pilot's squared error, even where it seems to have none.
    constexpr double kLeastPart = 0.05;
    const auto square = [](double x) { return x * x; };
    const auto& [thick, thin] = pilots;
    const auto power = [](double x) { return std::pow(x, 2 * ToleranceModel::kOrder); };
    const double most = square(thin.error) / power(thin.thickness);
    const double sheets =
        std::clamp((square(thick.error) - square(thin.error)) / (power(thick.thickness) - power(thin.thickness)),
                   kLeastPart * most, (1 - kLeastPart) * most);
    const double texels = (square(thin.error) - sheets * power(thin.thickness)) / power(thin.texel);
    return {std::sqrt(texels), std::sqrt(sheets)};
}

ToleranceModel scaled(const ToleranceModel& model, double factor) {
    return {model.texels * factor, model.sheets * factor};
}

ToleranceChoice chooseDials(const ViewScene& scene, const ToleranceModel& model, double tolerance, double aim,
                            const ProgressSink& progress) {
    constexpr double kFinestTexel = 0.15, kCoarsestTexel = 2.1, kFinestSheets = 0.2, kCoarsestSheets = 4.1;
    constexpr double kStep = 1.19;           // a little more than the sixth root of two
    constexpr double kFineTolerance = 3e-3;  // below this tolerance the error of eight footprint steps shows
    ViewScene with = scene;
    with.dials.opacityCutoff = std::min(scene.dials.opacityCutoff, tolerance / 10);
    with.dials.footprintSteps = std::max(scene.dials.footprintSteps, tolerance < kFineTolerance ? 16 : 8);

    ToleranceChoice best{with.dials, std::numeric_limits<double>::infinity(), false};
    double leastTime = std::numeric_limits<double>::infinity();
    const auto take = [&best](const Dials& dials, double error, bool reachable) {
        best = {dials, error, reachable};
        // Rounded so that the setting is easy to read and to type again.
        best.dials.texel = std::round(1000 * dials.texel) / 1000;
        best.dials.sheetThickness = std::round(1000 * dials.sheetThickness) / 1000;
    };
    for (double texel = kCoarsestTexel; texel > kFinestTexel; texel /= kStep)
        for (double thickness = kCoarsestSheets; thickness > kFinestSheets; thickness /= kStep) {
            const double error = model.predict(texel, thickness);
            const ViewScene tried = turned(with, texel, thickness);
            if (error > aim * tolerance) {
                if (!best.reachable && error < best.predicted) take(tried.dials, error, false);
                continue;
            }
            const double time = expectedSeconds(tried, makePlan(tried, threadCount(), progress), threadCount());
            if (time < leastTime) {
                leastTime = time;
                take(tried.dials, error, true);
            }
            break;  // thinner sheets would only take longer
        }
    return best;
}

void runPilots(std::array<Pilot, 2>& pilots, const ViewScene& scene, const ViewScene& truth, int pixels, unsigned seed,
               const ProgressSink& progress) {
    PixelSample sample;
    for (Pilot& pilot : pilots) {
        const bool first = &pilot == &pilots.front();
        ViewScene tried = turned(scene, pilot.texel, pilot.thickness);
        tried.layers.clear();  // layers are not needed here
        const ProgressSink rendering = first ? partOf(progress, 0, 0.2) : partOf(progress, 0.8, 1);
        const Image image = render(tried, makePlan(tried, threadCount(), rendering), rendering).image;
        if (first)
            sample = samplePixels(truth, image, pixels, seed, partOf(progress, 0.2, 0.8));
        else
            setRendered(sample.pixels, image);
        const Verification v = summarise(sample);
        pilot.error = std::max(v.error, v.alphaError);
    }
}

ToleranceResult renderWithin(const ViewScene& given, const ViewScene& givenTruth, const ToleranceOptions& options) {
    ViewScene scene = litWithin(given, options.tolerance);
    const ViewScene truth = litWithin(givenTruth, options.tolerance);
    // Fractions of progress: pilots of the whole, rendering of an attempt.
    constexpr double kPiloted = 0.3, kRendered = 0.2;
    ToleranceResult out;
    std::array<Pilot, 2> pilots = pilotsFor(options.tolerance);
    std::optional<ScatterPilot> scattered;
    timed(out.seconds.pilots, [&] {
        scattered = scatterPilot(scene);
        scatterWithin(scattered, given, options.tolerance, 0, scene.dials);
        ViewScene moment = truth;
        moment.moments = nullptr;
        runPilots(pilots, scene, moment, options.pilotPixels, options.seed + kPilotSeed,
                  partOf(options.progress, 0, kPiloted));
    });
    ToleranceModel model = fitModel(pilots);
    ViewScene tried = scene;
    const auto make = [&](const Plan& plan, const ProgressSink& progress) {
        return options.render ? options.render(tried, plan, progress) : render(tried, plan, progress);
    };
    double wanted = options.tolerance;  // smaller after an interval turned out to be wide
    for (int attempt = 0; attempt < options.attempts; ++attempt) {
        const double from = kPiloted + (1 - kPiloted) * attempt / options.attempts;
        const double to = kPiloted + (1 - kPiloted) * (attempt + 1) / options.attempts;
        const double rendered = from + kRendered * (to - from);
        ToleranceChoice choice;
        bool isFiner = true;
        timed(out.seconds.plan, [&] {
            scatterWithin(scattered, given, options.tolerance, attempt, scene.dials);
            choice = chooseDials(scene, model, wanted, kAim, partOf(options.progress, from, from));
            isFiner = attempt == 0 || finer(choice.dials, out.dials);
            tried.dials = choice.dials;
            if (isFiner) out.plan = makePlan(tried, threadCount(), partOf(options.progress, from, from));
        });
        if (!isFiner) break;
        if (options.planned) options.planned(tried, out.plan);
        out.attempts = attempt + 1;
        out.dials = choice.dials;
        out.predicted = choice.predicted;
        timed(out.seconds.render, [&] { out.frame = make(out.plan, partOf(options.progress, from, rendered)); });

        const SampleOptions sampling = samplingOf(options, attempt, partOf(options.progress, rendered, to));
        PixelSample& sample = out.sample;
        timed(out.seconds.verify, [&] { sample = samplePixels(truth, out.frame.image, sampling); });
        out.verification = summarise(sample);
        const Verification doubted = summarise(sample, 1 - 2 * kDoubt / options.attempts);
        out.bound = std::max(doubted.upper, doubted.alphaUpper);
        const bool looked = out.verification.pixels > 0 || out.verification.complete || sample.candidates == 0;
        out.met = looked && out.bound <= options.tolerance;
        if (out.met || sample.outOfTime || !looked || !std::isfinite(out.bound)) break;
        const double error = std::max(out.verification.error, out.verification.alphaError);
        model = scaled(model, error / std::max(out.predicted, 1e-9));
        wanted = options.tolerance * std::min(1.0, kWidthAllowed * error / out.bound);
    }
    return out;
}

}  // namespace scrim
