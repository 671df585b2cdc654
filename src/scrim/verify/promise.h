// SPDX-License-Identifier: Apache-2.0
// What a preset promises: an error. Before anything is rendered, the dials that should keep it are chosen, from a few
// rays through the scene (pilot_rays.h). Nothing here depends on crops, threads or memory, so all parts of a picture
// get the same dials.
#pragma once

#include <scrim/scene/view_scene.h>
#include <scrim/verify/tolerance.h>

#include <string>

namespace scrim {

inline constexpr double kFinestPromised = 0.1;  ///< voxels: texels and sheets are chosen no finer

struct PromisedDials {
    Dials dials;
    double promised = 0, expected = 0;  ///< relative RMSE; expected > promised: no dials that are tried keep it
};

/// How obliquely eye and lights pass the sheets between them: the tangent of half the angle between an eye's ray and a
/// light's (or the light's, reversed), a mean over the shadowed lights by their power. Error of sheets grows with it:
/// along the sheets' axis a sheet holds just what a ray meets, on other ways what lies beside it.
double meanSlant(const ViewScene& scene);

/// The error that texels and sheets leave in a scene where pilotError() is `pilot`, with a margin that holds for nine
/// scenes of ten.
ToleranceModel expectedModel(double pilot, double slant, bool classified);

/// The cheapest texels and sheets that keep `promised` by `model`, none finer than `finest` voxels, and whatever else
/// it asks for; the other dials are those of `dials`.
PromisedDials dialsFor(const Dials& dials, const ToleranceModel& model, double promised,
                       double finest = kFinestPromised);

/// `scene.dials` with the cheapest texels and sheets that should keep what preset `quality` promises.
PromisedDials promisedDials(const ViewScene& scene, const std::string& quality);

}  // namespace scrim
