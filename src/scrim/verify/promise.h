// SPDX-License-Identifier: Apache-2.0
// The error that a preset promises. Before anything is rendered, a few rays through the scene (pilot_rays.h), or two
// small pictures of it (pilot_picture.h), choose the dials that should keep the promise. The choice does not depend on
// crops, threads or memory, so all parts of a picture get the same dials.
#pragma once

#include <scrim/scene/view_scene.h>
#include <scrim/verify/scatter_pilot.h>
#include <scrim/verify/tolerance.h>

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace scrim {

inline constexpr double kFinestPromised = 0.1;  ///< voxels; texels and sheets are never chosen finer

struct PromisedDials {
    Dials dials;
    /// Relative RMSE; expected > promised: none of the dials tried keeps the promise.
    double promised = 0, expected = 0;
    /// The same of multiply scattered light, and the dials that are chosen for it. None: light scatters once.
    struct Scattering {
        double promised = 0;
        ScatterChoice choice = {};
    };
    std::optional<Scattering> scattering = {};
    /// An error that is expected beyond the promise for a reason that dials are not chosen for.
    struct Beyond {
        double expected = 0;  ///< relative RMSE
        std::string why;      ///< "voxels of an optical depth of 20 are seen; ..."
    };
    std::vector<Beyond> beyond = {};
};

/// How obliquely eye rays and lights pass the sheets between them: the tangent of half the angle between an eye ray and
/// a light's ray (or its reverse), averaged over shadowed lights by their power. The error of sheets grows with it,
/// because a sheet holds exactly what a ray along the sheets' axis meets, but on slanted rays also what lies beside it.
double meanSlant(const ViewScene& scene);

/// The model of the error that texels and sheets leave in a scene of media where pilotError() is
/// `pilot`. Its margin covers nine of ten scenes.
ToleranceModel expectedModel(double pilot, double slant);

/// The same of a scene with classified volumes, from two small pictures of it.
ToleranceModel modelOfSurfaces(const ViewScene& scene);

/// `dials` with the cheapest texels and sheets that keep `promised` by `model`, none finer than
/// `finest` voxels, and with the other dials that the promise requires.
PromisedDials dialsFor(const Dials& dials, const ToleranceModel& model, double promised,
                       double finest = kFinestPromised);

/// Sets the dials of multiply scattered light that `choice` has, but for those that `dials` states.
void setScattering(Dials& dials, const ScatterChoice& choice);

/// `scene.dials` with the cheapest texels and sheets that should keep the promise of preset `quality`, and the cheapest
/// cells and directions of multiply scattered light. `atLod` gives the same scene with another value of the dial `lod`,
/// which is then chosen, too; null: the scene has its own.
PromisedDials promisedDials(const ViewScene& scene, const std::string& quality,
                            const std::function<ViewScene(double)>& atLod = {});

}  // namespace scrim
