// SPDX-License-Identifier: Apache-2.0
#include <scrim/verify/moment_dials.h>

#include <scrim/base/parallel.h>
#include <scrim/engine/plan/make_plan.h>
#include <scrim/engine/shared_light.h>
#include <scrim/engine/sweep.h>
#include <scrim/verify/pilot_picture.h>
#include <scrim/verify/tolerance.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace scrim {
namespace {

constexpr int kEdge = 150;  // pixels

// The dials of the pilots, relative to those of a still: the first pilot has about the dials that
// are chosen, and the other two have coarser texels or coarser sheets.
constexpr double kFirst = 1.4, kCoarserTexels = 1.5, kCoarserSheets = 2;

// The errors of two settings are alike in part: what edges lose is, where they fall between texels
// is not. With this correlation the errors of texels came out at 0.4, 0.6 and 0.9 % for the comet,
// a ball and a slab with hard edges, whose stills had 0.4, 0.5 and 0.95 % of both.
constexpr double kAlike = 0.5;

double power(double x) {
    return std::pow(x, ToleranceModel::kOrder);
}

ViewScene pilotOf(const ViewScene& moment, double texels, double sheets) {
    ViewScene pilot = pilotView(moment, kEdge);
    pilot.dials.texel *= kFirst * texels;
    pilot.dials.sheetThickness *= kFirst * sheets;
    return pilot;
}

// The error of dials of one voxel, if a dial `times` as coarse as `dial` makes the difference between two pictures.
double coefficient(const Image& coarse, const Image& fine, double dial, double times) {
    const Verification difference = differenceOf(coarse, fine);
    const double of = std::max({difference.error, difference.alphaError, 1e-6});
    const double a = power(times * dial), b = power(dial);
    return of / std::sqrt(a * a + b * b - 2 * kAlike * a * b);
}

// No moment gets coarser dials than these, in voxels, as no still does (promise.cpp).
constexpr double kCoarsestTexel = 2, kCoarsestSheets = 4;

// A dial coarser by so many steps of a tenth, up to `coarsest`. Frames of a shot seldom differ by one.
double stepped(double dial, int steps, double coarsest) {
    return std::max(dial, std::min(std::round(100 * dial * std::pow(1.1, steps)) / 100, coarsest));
}

}  // namespace

ToleranceModel momentModel(const ViewScene& moment, const ProgressSink& progress) {
    const ViewScene coarsest = pilotOf(moment, kCoarserTexels, kCoarserSheets);
    const Plan plan = makePlan(coarsest, threadCount(), progress);
    SharedLight light(coarsest, plan);
    const auto pictureOf = [&](double texels, double sheets) {
        const ViewScene pilot = pilotOf(moment, texels, sheets);
        const Plan own = makePlan(pilot, threadCount(), progress);
        return render(pilot, own, progress, {}, light.servedTo(pilot, own, progress)).image;
    };
    const Image fine = pictureOf(1, 1);
    return {coefficient(pictureOf(kCoarserTexels, 1), fine, kFirst * moment.dials.texel, kCoarserTexels),
            coefficient(pictureOf(1, kCoarserSheets), fine, kFirst * moment.dials.sheetThickness, kCoarserSheets)};
}

Dials momentDials(const ViewScene& moment, const ToleranceModel& model, double allowed, const ProgressSink& progress) {
    constexpr int kMostSteps = 11;  // to dials about three times as coarse
    const Dials& given = moment.dials;
    ViewScene tried = moment;
    if (!moment.picture.empty()) tried.region = moment.picture;
    tried.memoryLimit = 0;
    Dials best = given;
    double least = std::numeric_limits<double>::infinity();
    for (int texels = 0; texels <= kMostSteps; ++texels) {
        tried.dials.texel = stepped(given.texel, texels, kCoarsestTexel);
        const auto thickness = [&](int steps) { return stepped(given.sheetThickness, steps, kCoarsestSheets); };
        int sheets = kMostSteps;
        while (sheets >= 0 && model.predict(tried.dials.texel, thickness(sheets)) > allowed) --sheets;
        if (sheets < 0) break;
        tried.dials.sheetThickness = thickness(sheets);
        // One thread, so that the choice does not depend on their number.
        const double seconds = expectedSeconds(tried, makePlan(tried, 1, progress), 1);
        if (seconds < least) best = tried.dials;
        least = std::min(seconds, least);
    }
    return best;
}

}  // namespace scrim
