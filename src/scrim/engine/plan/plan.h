// SPDX-License-Identifier: Apache-2.0
// The plan: everything that is decided before the first voxel is read. A pure function of the scene, so that
// `scrim plan` shows exactly what a render will do.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/base/simd.h>
#include <scrim/geometry/sheets.h>
#include <scrim/geometry/view_raster.h>
#include <scrim/engine/light/light_view.h>
#include <scrim/engine/splat/extinction_rows.h>
#include <scrim/engine/plan/light_groups.h>
#include <scrim/engine/plan/needed_tiles.h>
#include <scrim/scene/view_scene.h>
#include <scrim/engine/shade/shade_tile.h>

#include <cstddef>
#include <string>
#include <vector>

namespace scrim {

struct LightPlan {
    int light = 0;  ///< index into ViewScene::lights
    bool shadowed = true;
    LightView view;
    std::vector<Vec3> ssWindows;  ///< a split light: window axes in sweep space, see SheetLight
    int window = 0;
    double share = 1;   ///< of the light's intensity
    ViewRaster raster;  ///< per-view splatting: of the light's own sheets
    int picture = 0;    ///< of the group's: where its light goes
};

/// One of the pictures that a group composites.
struct PicturePlan {
    Layer layer;
    int light = -1;  ///< of a light's: index into ViewScene::lights
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
    std::vector<PicturePlan> pictures;  ///< beside the beauty: only what this group contributes to
    SampleLayout layout;
    PictureTargets targets;
    NeededTiles needed;     ///< of the sheets
    ViewRaster eyeRaster;   ///< per-view splatting: of the eye's own sheets
    int guardTiles = 0;     ///< of them around the picture
    std::size_t bytes = 0;  ///< of all buffers of this group's sweep, at most
};

/// Rough counts of the work ahead, in units of what each stage does once.
struct ExpectedWork {
    double footprints = 0;    ///< voxel and sheet pairs
    double texels = 0;        ///< shaded texels, at most
    double lightSamples = 0;  ///< shadow buffer cells walked, at most
    double pixelSheets = 0;   ///< pixel and sheet pairs composited, at most
};

/// `window` of the picture in pixels of the antialiasing raster, n x n to a pixel.
inline PixelWindow supersampled(const PixelWindow& window, int n) {
    return {window.x0 * n, window.y0 * n, window.x1 * n, window.y1 * n};
}

struct Plan {
    std::vector<GroupPlan> groups;  ///< by eye part, a primary one first; empty where nothing is to be seen
    int threads = 1;                ///< that the render takes
    Simd simd;                      ///< vector instructions that it uses
    ExtinctionRows extinction;
    bool perView = false;  ///< footprints go into every view's own sheets, not into shared ones
    bool shadeAtPixels = false;
    std::string shadeReason;
    double voxel = 1;                        ///< the unit of the dials, world units
    PixelWindow region;                      ///< in pixels of the antialiasing raster
    std::vector<std::string> uselessLights;  ///< for each light of the scene why it is left out; empty: it is not
    std::vector<EyePart> eyeParts;           ///< in pixels of the picture; windows cut to the region
    std::size_t bytes = 0;                   ///< buffers at their largest, frame included; without the fields
    ExpectedWork work;
};

/// Plans a render for `threads` threads. Throws Error: usage (a slide without its image), render (field of view too
/// wide, more sheets or texels than can be addressed), memory (not one sheet and light fits the scene's memory limit,
/// or not the plan), interrupted (where `progress`, which is asked now and then, and always with 0, wished it).
Plan makePlan(const ViewScene& scene, int threads, const ProgressSink& progress = {});

}  // namespace scrim
