// SPDX-License-Identifier: Apache-2.0
// What a plan says: every shape and place that is decided before the first voxel is read, as plain data. The rooms that
// splat, light, shade and composite read it; the room `plan`, above them, makes it.
#pragma once

#include <scrim/base/real.h>
#include <scrim/base/simd.h>
#include <scrim/engine/model/outputs.h>
#include <scrim/engine/model/sub_lights.h>
#include <scrim/geometry/box2.h>
#include <scrim/geometry/lattice.h>
#include <scrim/geometry/sheets.h>
#include <scrim/image/image.h>
#include <scrim/scene/view_scene.h>

#include <algorithm>
#include <cstddef>
#include <optional>
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
/// What is solved for at once, because it ends up in the same layer.
struct ScatterTarget {
    std::optional<Output> output;  ///< none: the beauty
    std::vector<int> lights;       ///< indices into ViewScene::lights
    bool ambient = false, emission = false;
};

struct TransportPlan {
    std::vector<ScatterTarget> targets;  ///< empty: nothing scatters light more than once
    double edge = 0;                     ///< of the finest cells, world units
    double cells = 0;                    ///< about so many of them
    int ordinates = 64;
    bool isotropic = true;
    bool coarse = false;    ///< cells are larger than is asked for, to see what that changes
    int colours = 1;        ///< solved for one by one
    std::size_t bytes = 0;  ///< at most, about

    bool any() const { return !targets.empty(); }
    /// Of all targets: indices into ViewScene::lights.
    std::vector<int> lights() const;
};

struct EyePart {
    PixelWindow window;  ///< pixels of the picture in which the part counts, before any crop
    bool whole = true;   ///< the only part: its weight is 1 everywhere
    /// Else it counts left(x) (1 - right(x)) top(y) (1 - bottom(y)): ramps from 0 to 1 over [first, second] raster
    /// positions; where those are equal the ramp is 1 everywhere, and 1 - ramp is, too.
    Vec2 left{0}, right{0}, top{0}, bottom{0};
    std::vector<Vec3> wsDirections;  ///< unit, away from the eye; their cone holds its rays that meet the volume

    double weight(double x, double y) const;
};

/// A light as one sweep sees it: the raster of its shadow buffer and the map between raster and sheets.
///
/// The raster is parallel to the sheets. A cell (i, j) is a light ray, named by where it crosses the plane N = 0
/// (distant lights) or by its slope (point lights), and either way the cells of one sheet are a scaled and shifted
/// lattice: texel = offset + cell * scale. The projective map of ZC02 eq. 4 thus separates into rows and columns; for
/// distant lights the scale is 1 at every sheet and resampling is a streaming operation.
struct LightView {
    /// Texel coordinates of cell (i, j) on one sheet: offset + (i, j) * scale.
    struct Cells {
        double offsetU = 0, offsetV = 0, scale = 1;
    };

    bool distant = true;
    Vec3 tsSource{0};  ///< distant: (dU/dN, dV/dN, 0) of all rays; point: the source's position
    Vec2 first{0};     ///< cell (0, 0): (U, V) at N = 0 (distant), (dU/dN, dV/dN) (point)
    double cell = 1;   ///< step from cell to cell in the units of `first`
    int width = 0;     ///< cells, a multiple of kTileEdge
    int height = 0;
    double slopeScale = 1;  ///< texel / thickness: turns dU/dN into the slope du/dw

    /// Does the light reach the middle plane of sheet n? A point light needs half a sheet of distance: closer
    /// than that its rays are no longer told apart.
    bool reaches(int n) const { return distant || n + 0.5 - tsSource.z >= 0.5; }

    /// The part in [0, 1] of sheet n's thickness that lies before a point light (all of it for a distant one): the
    /// sheet in which the light stands is lit in part.
    double litPart(int n) const { return distant ? 1.0 : std::clamp(n + 1 - tsSource.z, 0.0, 1.0); }

    /// Map at the middle plane of sheet n, which the light must reach.
    Cells at(int n) const {
        const double middle = n + 0.5;
        if (distant) return {first.x + tsSource.x * middle, first.y + tsSource.y * middle, cell};
        const double z = middle - tsSource.z;
        return {tsSource.x + first.x * z, tsSource.y + first.y * z, cell * z};
    }
};

/// Half the opening of a window of a split light, and the limit beyond which a light's rays count as too wide
/// for one view; radians.
constexpr double kWindowAngle = 0.5585;  // 32 degrees

/// A light of a sweep, from grouping to shading: a light of the plan, or the part of it that falls into one window of
/// directions. Grouping decides what stands first, planLight the rest, once the sheets are known.
struct PlannedLight {
    int light = 0;                   ///< index into the lights of the plan, none of which is extended
    std::vector<Vec3> wsDirections;  ///< unit directions of travel whose cone holds all rays that meet the volume
    std::vector<Vec3> wsWindows;     ///< axes of the windows that overlap this part's, itself included; or none
    int window = 0;                  ///< which of them is this part's
    double share = 1;                ///< of the light's intensity: less while two sweeps fade into each other

    bool shadowed = true;
    LightView view = {};
    std::vector<Vec3> ssWindows = {};  ///< wsWindows in sweep space, see SheetLight
    Lattice lattice = {};              ///< of the sheets that it passes through: the shared ones, or its own
};

/// The part of a sweep's sheets that the picture needs: what its pixels see, and what light passes on its way there.
/// Sheets and tiles keep their places; what is culled is not splatted, so that a crop's pixels come out as in the
/// whole.
struct NeededTiles {
    std::vector<Box2<int>> sheets;  ///< for each sheet the box of needed tiles
    int first = 0, last = 0;        ///< sheets [first, last) hold all that is needed

    /// The box around those of sheets [from, to), which may reach beyond the stack.
    Box2<int> over(int from, int to) const;
    /// Part of all tiles that are needed, in [0, 1].
    double share(const Sheets& s) const;
};

/// Lights that share a sweep, and the sweep. Grouping decides the axis and who takes part.
struct GroupPlan {
    std::size_t eyePart = 0;  ///< index into Plan::eyeParts
    std::vector<PlannedLight> lights;
    bool sameSide = true;   ///< s = +1: the eye meets the same side of the sheets first as the lights
    Vec3 wsAxis{0, 0, -1};  ///< unit
    double slant = 0;       ///< largest angle of any ray of the eye or a light to the axis, radians
    double primary = 0;     ///< share in what one sweep owns: alpha and ambient; they sum to 1 over an eye's groups

    int pass = 1,
        passes = 1;  ///< which of the sweeps along this axis, where the memory limit allows but some lights at a time
    Sheets sheets;
    int batchSheets = 1;  ///< sheets that are in memory at a time
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

}  // namespace scrim
