// SPDX-License-Identifier: Apache-2.0
#include <scrim/study/tolerance.h>

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/render/renderer.h>
#include <scrim/study/expected_time.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace scrim {
namespace {

constexpr unsigned kPilotSeed = 2;  // other pixels than those of a verification, which must not be tuned for

// Part of the tolerance that is aimed at: what pilot and verification see differs by about this.
constexpr double kAim = 0.85;

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
    constexpr double kLeastPart = 0.05;  // of a pilot's squared error is that of either, even where it seems to be none
    const auto square = [](double x) { return x * x; };
    const auto& [thick, thin] = pilots;
    const auto power = [](double x) { return std::pow(x, 2 * ToleranceModel::kOrder); };
    const double most = square(thin.error) / power(thin.thickness);
    const double sheets = std::clamp((square(thick.error) - square(thin.error)) /
                                         (power(thick.thickness) - power(thin.thickness)),
                                     kLeastPart * most, (1 - kLeastPart) * most);
    const double texels = (square(thin.error) - sheets * power(thin.thickness)) / power(thin.texel);
    return {std::sqrt(texels), std::sqrt(sheets)};
}

ToleranceModel scaled(const ToleranceModel& model, double factor) {
    return {model.texels * factor, model.sheets * factor};
}

ToleranceChoice chooseDials(const ViewScene& scene, const ToleranceModel& model, double tolerance) {
    constexpr double kFinestTexel = 0.15, kCoarsestTexel = 2.1, kFinestSheets = 0.2, kCoarsestSheets = 4.1;
    constexpr double kStep = 1.19;         // sixth root of two and a little
    constexpr double kFineTolerance = 3e-3;  // below which eight steps of footprints show
    ViewScene with = scene;
    with.dials.opacityCutoff = std::min(scene.dials.opacityCutoff, tolerance / 10);
    with.dials.footprintSteps = std::max(scene.dials.footprintSteps, tolerance < kFineTolerance ? 16 : 8);

    ToleranceChoice best{with.dials, std::numeric_limits<double>::infinity(), false};
    double leastTime = std::numeric_limits<double>::infinity();
    const auto take = [&best](const Dials& dials, double error, bool reachable) {
        best = {dials, error, reachable};
        // So that the setting can be read, and typed again.
        best.dials.texel = std::round(1000 * dials.texel) / 1000;
        best.dials.sheetThickness = std::round(1000 * dials.sheetThickness) / 1000;
    };
    for (double texel = kCoarsestTexel; texel > kFinestTexel; texel /= kStep)
        for (double thickness = kCoarsestSheets; thickness > kFinestSheets; thickness /= kStep) {
            const double error = model.predict(texel, thickness);
            const ViewScene tried = turned(with, texel, thickness);
            if (error > kAim * tolerance) {
                if (!best.reachable && error < best.predicted) take(tried.dials, error, false);
                continue;
            }
            const double time = expectedSeconds(tried, makePlan(tried, threadCount()), threadCount());
            if (time < leastTime) {
                leastTime = time;
                take(tried.dials, error, true);
            }
            break;  // thinner sheets only take longer
        }
    return best;
}

void runPilots(std::array<Pilot, 2>& pilots, const ViewScene& scene, const ViewScene& exact, int pixels,
               const ProgressSink& progress) {
    const auto part = [&](double from, double to) -> ProgressSink {
        if (!progress) return {};
        return [&progress, from, to](double done) { return progress(from + (to - from) * done); };
    };
    std::vector<VerifiedPixel> truth;
    for (Pilot& pilot : pilots) {
        const bool first = truth.empty();
        ViewScene tried = turned(scene, pilot.texel, pilot.thickness);
        tried.layers.clear();  // nobody looks at those
        const Image image =
            render(tried, makePlan(tried, threadCount()), first ? part(0, 0.2) : part(0.8, 1)).image;
        if (first) {
            truth = drawPixels(image, pixels, kPilotSeed);
            evaluateReferences(exact, truth, part(0.2, 0.8));
        }
        setRendered(truth, image);
        pilot.error = summarise(truth).error;
    }
}

}  // namespace scrim
