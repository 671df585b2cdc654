// SPDX-License-Identifier: Apache-2.0
// The plan: everything that is decided before the first voxel is read. A pure function of the scene, so that
// `scrim plan` shows exactly what a render will do.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/base/real.h>
#include <scrim/base/simd.h>
#include <scrim/engine/light/shadow_buffer.h>
#include <scrim/engine/plan/culling.h>
#include <scrim/engine/plan/light_groups.h>
#include <scrim/engine/plan/outputs.h>
#include <scrim/engine/plan/sub_lights.h>
#include <scrim/engine/plan/transport_plan.h>
#include <scrim/geometry/lattice.h>
#include <scrim/geometry/sheets.h>
#include <scrim/scene/view_scene.h>

#include <cstddef>
#include <string>
#include <vector>

namespace scrim {

/// Extinction in colour c = sum over extinction channels of (channel's value) * tints[channel][c]. A scene without
/// colours has one channel of white. One of up to three tints has a channel a tint; one of more has the channels red,
/// green, blue. So sheets and shadow buffers are scalar whatever the colours are.
struct ExtinctionChannels {
    bool coloured = false;
    std::vector<Rgb> tints{Rgb(1)};
    /// A volume's part in a channel: its extinction in the colour that has most, times `weight`.
    struct Share {
        int channel = 0;
        Real weight = 1;
    };
    std::vector<std::vector<Share>> shares;  ///< for each volume of the scene

    int count() const { return static_cast<int>(tints.size()); }
};
ExtinctionChannels extinctionChannels(const ViewScene& scene);

struct LightPlan {
    int light = 0;  ///< index into the lights of the plan
    bool shadowed = true;
    LightView view;
    std::vector<Vec3> ssWindows;  ///< a split light: window axes in sweep space, see SheetLight
    int window = 0;
    double share = 1;  ///< of the light's intensity
    Lattice lattice;   ///< of the sheets that it passes through: the shared ones, or its own
};

struct GroupPlan {
    std::size_t eyePart = 0;  ///< index into Plan::eyeParts
    double primary = 0;       ///< share of alpha and ambient that it owns
    bool sameSide = true;
    double slant = 0;  ///< radians
    int pass = 1,
        passes = 1;  ///< which of the sweeps along this axis, where the memory limit allows but some lights at a time
    Sheets sheets;
    int batchSheets = 1;  ///< sheets that are in memory at a time
    std::vector<LightPlan> lights;
    SweepOutputs outputs;
    NeededTiles needed;     ///< of the sheets
    Lattice lattice;        ///< of the sheets that the eye looks at: the shared ones, or its own
    std::size_t bytes = 0;  ///< of all buffers of this group's sweep, at most
};

/// `window` of the picture in pixels of the antialiasing raster, n x n to a pixel.
inline PixelWindow supersampled(const PixelWindow& window, int n) {
    return {window.x0 * n, window.y0 * n, window.x1 * n, window.y1 * n};
}

struct Plan {
    /// Rough counts of the work ahead, in units of what each stage does once.
    struct Work {
        double footprints = 0;    ///< voxel and sheet pairs
        double texels = 0;        ///< shaded texels, at most
        double lightSamples = 0;  ///< shadow buffer cells walked, at most
        double pixelSheets = 0;   ///< pixel and sheet pairs composited, at most
    };

    TransportPlan transport;        ///< of light that scatters more than once
    SubLights subLights;            ///< what the engine shines with; empty: the lights of the scene
    std::vector<GroupPlan> groups;  ///< by eye part; empty where nothing is to be seen
    int threads = 1;                ///< that the render takes
    Simd simd;                      ///< vector instructions that it uses
    ExtinctionChannels extinction;
    bool perView = false;  ///< footprints go into every view's own sheets, not into shared ones
    bool shadeAtPixels = false;
    std::string shadeReason;
    double voxel = 1;                       ///< the unit of the dials, world units
    PixelWindow region;                     ///< in pixels of the antialiasing raster
    std::vector<std::string> culledLights;  ///< for each light of the scene why it is culled; empty: it is not
    std::vector<EyePart> eyeParts;          ///< in pixels of the picture; windows cut to the region
    std::size_t bytes = 0;                  ///< buffers at their largest, frame included; without the fields
    /// Of `bytes`, what a deep picture may take at most, with a sample for every ray and sheet; most scenes need a
    /// small part of it, so it is no reason to refuse one. A render stops that comes to need more than the next.
    std::size_t deepBytes = 0;
    std::size_t mostDeepBytes = 0;  ///< that the memory limit leaves for the samples of a sweep; 0: no limit
    Work work;
};

/// The light that light `i` of the plan is, and the scene's that it belongs to.
inline const Light& lightOf(const ViewScene& scene, const Plan& plan, int i) {
    return plan.subLights.owners.empty() ? scene.lights[std::size_t(i)] : plan.subLights.lights[std::size_t(i)];
}
inline const Light& ownerOf(const ViewScene& scene, const Plan& plan, int i) {
    return scene.lights[std::size_t(plan.subLights.ownerOf(i))];
}

/// Plans a render for `threads` threads. Throws Error: usage (a slide without its image), render (field of view too
/// wide, more sheets or texels than can be addressed), memory (not one sheet and light fits the scene's memory limit,
/// or not the plan), interrupted (where `progress`, which is asked now and then, and always with 0, wished it).
Plan makePlan(const ViewScene& scene, int threads, const ProgressSink& progress = {});

/// How long a render will take, from its plan alone. Good for choosing between settings of one scene (which takes how
/// many times as long as which); in seconds it is as good as this machine is like the one it was fitted on.
double expectedSeconds(const ViewScene& scene, const Plan& plan, int threads);

}  // namespace scrim
