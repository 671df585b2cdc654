// SPDX-License-Identifier: Apache-2.0
// The contents of a plan: everything that is decided before the first voxel is read, as plain data. The rooms that
// splat, light, shade and composite read it; the room `plan`, above them, makes it. It begins with the outputs of a
// sweep (AOVs): the beauty, which is number 0, and those that are composited beside it.
#pragma once

#include <scrim/base/real.h>
#include <scrim/base/simd.h>
#include <scrim/engine/model/frame.h>
#include <scrim/engine/model/sub_lights.h>
#include <scrim/geometry/box2.h>
#include <scrim/geometry/lattice.h>
#include <scrim/geometry/sheets.h>
#include <scrim/image/image.h>
#include <scrim/scene/phase_over_caps.h>
#include <scrim/scene/view_scene.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace scrim {

/// An output beside the beauty. There is one of Layer::light for every light or group of lights, one of Layer::volume
/// for every volume, and one of Layer::cryptomatte for the opacity of every volume.
struct Output {
    Layer layer = Layer::light;
    int light = -1;  ///< for lights: index into ViewScene::lights, of the first light of a group
    int place = -1;  ///< for volumes: index into Scene::volumes

    bool operator==(const Output&) const = default;
};

/// A sample consists of quads of floats: one for each output, with the sample's opacity. With grey extinction, every
/// quad is (S.rgb, -alpha). With `coloured` extinction, quads are (S.rgb, 0), followed by one quad of opacities that
/// all share: (-alpha.rgb, -the least of the three). Compositing has only these two forms, whatever the outputs are.
///
/// Without `beauty`, output 0, the beauty, has no quad: it is the sum of outputs [1, beautyParts), which all have
/// one, and is made of them after compositing.
struct OutputLayout {
    int outputs = 1;  ///< including the beauty
    bool coloured = false;
    bool beauty = true;
    int ambient = 0, emission = 0;             ///< the outputs that receive light which belongs to no light
    std::optional<int> indirect;               ///< receives what has scattered more than once, too
    std::optional<int> albedo, depth, motion;  ///< the outputs of these layers, where they are asked for
    /// The output for the opacity of what is visible, in each channel, if something hides without
    /// being visible. It is then the picture's alpha. It is not a layer, and is the last output.
    std::optional<int> seen;
    int beautyParts = 1;  ///< outputs [1, beautyParts) are parts of the beauty

    bool beautyAlone() const { return outputs == 1 && !coloured && beauty; }
    /// The index of an output's quad.
    int quadOf(int output) const { return beauty ? output : output - 1; }
    int outputQuads() const { return quadOf(outputs); }
    int quads() const { return outputQuads() + (coloured ? 1 : 0); }
    int floats() const { return 4 * quads(); }
};

/// The outputs that one sweep composites: only those that it contributes to.
struct SweepOutputs {
    std::vector<Output> list;  ///< element i is output i + 1
    OutputLayout layout;
    std::vector<int> ofLights;        ///< the output of each of the sweep's lights
    std::vector<int> ofVolumes = {};  ///< the output of each of ViewScene::volumes; empty: they have none
    std::vector<int> opacities = {};  ///< likewise, for their opacities; empty: none is wanted
};

/// The outputs of a sweep with these lights (lightOfLayer of each, possibly repeated). `primary`: the sweep
/// owns alpha, ambient light, emission, and multiply scattered light from the lights `scattered`. Throws Error(usage)
/// if there are too many.
SweepOutputs chooseOutputs(const ViewScene& scene, bool coloured, bool primary, const std::vector<int>& lights,
                           const std::vector<int>& scattered = {});

/// The number of pictures beside the beauty in a frame of `scene`.
std::size_t layerCount(const ViewScene& scene);

/// Extinction in colour c is the sum over extinction channels of (channel's value) * tints[channel][c]. A scene without
/// colours has one white channel. With up to three tints there is a channel for each tint, with more there are the
/// channels red, green and blue. Thus sheets and shadow buffers are scalar whatever the colours are. Volumes that cast
/// shadows in different lights have channels of their own, of which a light passes through some. A pair of a tint and a
/// set of lights that no volume has gets no channel.
struct ExtinctionChannels {
    static constexpr int kMost = 9;
    bool coloured = false;  ///< true wherever there is more than one channel
    std::vector<Rgb> tints{Rgb(1)};
    /// For each channel the lights of the scene in which it casts shadows, as ViewVolume::shadows.
    std::vector<std::vector<bool>> shadows{{}};
    /// For each volume of the scene, by channel: the factor on the volume's extinction in the
    /// colour where it is largest.
    std::vector<std::vector<Real>> weights;

    int count() const { return static_cast<int>(tints.size()); }
    /// The channels that cast shadows in light `light` of the scene.
    std::vector<int> castIn(std::size_t light) const;
};

/// The channels of a scene. Throws Error(usage) if there are too many.
ExtinctionChannels extinctionChannels(const ViewScene& scene);

/// The light that is solved for together, because it belongs to the same layer.
struct ScatterTarget {
    std::optional<Output> output;  ///< none: the beauty
    std::vector<int> lights;       ///< indices into ViewScene::lights
    bool ambient = false, emission = false;
};

/// Part of space that scattered light is solved for on cells of one size (solve/scatter_domains.h).
/// All lists are for each of ViewScene::volumes.
struct ScatterDomain {
    std::vector<bool> volumes;  ///< whether the cells keep its light
    std::vector<bool> held;     ///< whether the cells have its voxels: volumes of the same or smaller ones
    std::vector<bool> larger;   ///< whether they have those of its larger voxels that the domain around has
    double edge = 0;            ///< of the cells, world units
    int parent = -1;            ///< the number of the domain around; -1: the domain is the whole scene
    bool filled = false;        ///< cells fill the box around the volumes, because larger voxels matter between them
};

struct TransportPlan {
    std::vector<ScatterTarget> targets;  ///< empty: no volume scatters light more than once
    std::vector<ScatterDomain> domains;  ///< each after the one around it
    double cells = 0;                    ///< approximate number of all cells
    int ordinates = 64;
    bool isotropic = true;
    bool coarse = false;     ///< cells are larger than requested, to measure the effect
    bool brightest = false;  ///< only the brightest colour is solved for, and stands for all
    std::size_t bytes = 0;   ///< upper bound, approximately

    bool any() const { return !targets.empty(); }
    /// The lights of all targets, as indices into ViewScene::lights.
    std::vector<int> lights() const;
};

/// Volumes whose light is kept on cells of like size (cells/cell_levels.h).
struct CellLevel {
    std::vector<bool> volumes;  ///< for each of ViewScene::volumes
    std::vector<bool> around;   ///< likewise, those that may hold back its light (cells/cell_levels.h); empty: all
    std::vector<double> edges;  ///< for each light of CellLightPlan the edge of its cells, world units
    double features = 0;        ///< about the size of what light shows, world units: the most for cells of octaves
    double coarser = 1;         ///< how much larger cells are than they should be, for want of memory

    double smallest() const { return *std::min_element(edges.begin(), edges.end()); }
};

/// Lights that are kept on cells (passes/light_cells.h) instead of being sums of shadow buffers.
struct CellLightPlan {
    std::vector<int> lights;        ///< indices into ViewScene::lights
    std::vector<CellLevel> levels;  ///< as cellLevels() orders them
    std::size_t bytes = 0;          ///< approximately
    std::string lamp;               ///< name of the first of them whose place shows: a lamp, or a surface among volumes
    std::string unfit;              ///< the reason why no light can be kept on cells; empty: there is none

    bool has(std::size_t light) const;
    /// The edge of the smallest cells that keep the light lights[i], world units.
    double edge(std::size_t i) const;
    /// How much larger cells of any level are than they should be.
    double coarser() const;
};

struct EyePart {
    PixelWindow window;  ///< pixels of the picture that the part contributes to, before any crop
    bool whole = true;   ///< this is the only part: its weight is 1 everywhere
    /// Otherwise the weight is left(x) (1 - right(x)) top(y) (1 - bottom(y)). Each factor is a ramp from 0 to 1 over
    /// the raster positions [first, second]; if both are equal, ramp and 1 - ramp are both 1 everywhere.
    Vec2 left{0}, right{0}, top{0}, bottom{0};
    /// Unit, away from the eye; the rays of this part that meet the volume lie in their cone.
    std::vector<Vec3> wsDirections;

    double weight(double x, double y) const;
};

/// A light as one sweep sees it: the raster of its shadow buffer and the map between raster and sheets.
///
/// The raster is parallel to the sheets. A cell (i, j) is a light ray, identified by where it crosses the plane N = 0
/// (distant lights) or by its slope (point lights). In both cases the cells on one sheet form a scaled and shifted
/// lattice: texel = offset + cell * scale. The projective map of ZC02 eq. 4 thus separates into rows and columns; for
/// distant lights the scale is 1 on every sheet, and resampling is a streaming operation.
struct LightView {
    /// Texel coordinates of cell (i, j) on one sheet: offset + (i, j) * scale.
    struct Cells {
        double offsetU = 0, offsetV = 0, scale = 1;
    };

    bool distant = true;
    Vec3 tsSource{0};  ///< distant: (dU/dN, dV/dN, 0) of all rays; point: the source's position
    Vec2 first{0};     ///< cell (0, 0): (U, V) at N = 0 (distant), (dU/dN, dV/dN) (point)
    double cell = 1;   ///< distance between cells, in the units of `first`
    int width = 0;     ///< in cells, a multiple of kTileEdge
    int height = 0;
    double slopeScale = 1;  ///< texel / thickness: turns dU/dN into the slope du/dw

    /// The slope (du/dw, dv/dw) of the ray through cell (i, j), the same on every sheet; a distant
    /// light's is the same in all cells.
    Vec2 slopeAt(double i, double j) const {
        return (distant ? Vec2(tsSource) : first + cell * Vec2(i, j)) * slopeScale;
    }

    /// The difference of the slopes of two cells side by side.
    double slopeStep() const { return distant ? 0 : cell * slopeScale; }

    /// True if the light reaches the middle plane of sheet n. A point light needs half a sheet of
    /// distance, since its rays cannot be distinguished closer than that.
    bool reaches(int n) const { return distant || n + 0.5 - tsSource.z >= 0.5; }

    /// The fraction in [0, 1] of sheet n's thickness that lies in front of a point light (1 for a
    /// distant one): the sheet that contains the light is lit in part.
    double litPart(int n) const { return distant ? 1.0 : std::clamp(n + 1 - tsSource.z, 0.0, 1.0); }

    /// The map at the middle plane of sheet n, which the light must reach.
    Cells at(int n) const { return atPlane(n + 0.5); }
    /// The map on the plane N = `middle`.
    Cells atPlane(double middle) const {
        if (distant) return {first.x + tsSource.x * middle, first.y + tsSource.y * middle, cell};
        const double z = middle - tsSource.z;
        return {tsSource.x + first.x * z, tsSource.y + first.y * z, cell * z};
    }
};

/// Half the opening angle of a window of a split light, radians.
constexpr double kWindowAngle = 0.5585;  // 32 degrees

/// A light of a sweep, from grouping to shading: a light of the plan, or the part of it in one window of directions.
/// Grouping sets the first members, planLight the others once the sheets are known.
struct PlannedLight {
    PlanLight light{};
    std::vector<Vec3> wsDirections;  ///< unit directions of travel; all rays that meet the volume lie in their cone
    /// Axes of all windows that overlap this part's window, including that one; empty: not split.
    std::vector<Vec3> wsWindows;
    int window = 0;    ///< index of this part's window among them
    double share = 1;  ///< of the light's intensity; below 1 during a cross-fade between two sweeps

    bool shadowed = true;
    /// The size of its raster's cells, relative to what the dial `shadow_texel` says: more than 1
    /// where these would be too many.
    double coarser = 1;
    LightView view = {};
    std::vector<Vec3> ssWindows = {};  ///< wsWindows in sweep space, see SheetLight
    Lattice lattice = {};              ///< lattice of the sheets that it passes through: the shared one, or its own
};

/// The part of a sweep's sheets that the picture needs: what its pixels see, and what light passes
/// on the way there. Sheets and tiles keep their places. What is culled is not splatted, and a
/// crop's pixels equal those of the whole picture.
struct NeededTiles {
    std::vector<Box2<int>> sheets;  ///< for each sheet, the box of needed tiles
    int first = 0, last = 0;        ///< all needed tiles are in sheets [first, last)

    /// The box around those of sheets [from, to), which may extend beyond the stack.
    Box2<int> over(int from, int to) const;
    /// The fraction, in [0, 1], of all tiles that are needed.
    double share(const Sheets& s) const;
};

/// Lights that share a sweep, and the sweep. Grouping decides the axis and the lights.
struct GroupPlan {
    std::size_t eyePart = 0;  ///< index into Plan::eyeParts
    std::vector<PlannedLight> lights;
    bool sameSide = true;   ///< s = +1: eye and lights meet the same side of the sheets first
    Vec3 wsAxis{0, 0, -1};  ///< unit
    double slant = 0;       ///< largest angle between the axis and any ray of the eye or a light, radians
    /// Share of what one sweep owns, alpha and ambient light; shares sum to 1 over the groups of an eye part.
    double primary = 0;

    /// This sweep and the number of sweeps along this axis; more than one where the memory limit
    /// allows only some of the lights at a time.
    int pass = 1, passes = 1;
    Sheets sheets;
    int batchSheets = 1;  ///< number of sheets in memory at a time
    SweepOutputs outputs;
    NeededTiles needed;     ///< tiles of the sheets that are needed
    Lattice lattice;        ///< lattice of the sheets that the eye looks at: the shared one, or its own
    std::size_t bytes = 0;  ///< upper bound on all buffers of this group's sweep

    /// Volumes of much smaller voxels than others have sheets of their own. `volumes`: which of ViewScene::volumes are
    /// in these sheets; empty: all. `finer`: further levels of the same lights, each with the sheets of smaller voxels,
    /// coarsest first. A sheet of one level consists of a whole number of sheets of the next. What eye and lights pass
    /// is the sum of all levels.
    std::vector<bool> volumes = {};
    std::vector<GroupPlan> finer;

    /// Calls visit(level) for this level and all finer ones.
    template <class Visit>
    void forLevels(const Visit& visit) const {
        visit(*this);
        for (const GroupPlan& level : finer) visit(level);
    }
};

/// `window` of the picture in pixels of the antialiasing raster, with n x n for each pixel.
inline PixelWindow supersampled(const PixelWindow& window, int n) {
    return {window.x0 * n, window.y0 * n, window.x1 * n, window.y1 * n};
}

struct Plan {
    TransportPlan transport;          ///< for multiply scattered light
    CellLightPlan cellLights;         ///< for single scattering of extended lights
    SubLights subLights;              ///< the lights of all sweeps; none if nothing is visible
    std::vector<int> layersOfLights;  ///< lightOfLayer of each of the scene's lights
    std::vector<GroupPlan> groups;    ///< in the order of eye parts; empty if nothing is visible
    int threads = 1;                  ///< number of threads of the render
    Simd simd;                        ///< vector instructions of the render
    ExtinctionChannels extinction;
    /// The lights of the scene that light from cells belongs to.
    std::vector<int> lightsOnCells() const;
    /// True if the same cells keep the light of two volumes of the scene.
    bool onSameCells(std::size_t first, std::size_t second) const;
    /// For each volume the means of its phase function over what sub-lights stand for; null: none is wider than lobes.
    std::vector<std::shared_ptr<const PhaseOverCaps>> caps;
    bool perView = false;  ///< footprints are splatted into each view's own sheets instead of shared ones
    bool shadeAtPixels = false;
    std::string shadeReason;
    double voxel = 1;    ///< the unit of the dials, world units
    PixelWindow region;  ///< in pixels of the antialiasing raster
    /// For each light of the scene the reason why it is culled; empty: it is not.
    std::vector<std::string> culledLights;
    std::vector<EyePart> eyeParts;  ///< in pixels of the picture; windows cut to the region
    std::size_t bytes = 0;          ///< buffers at their largest, with the frame, without the fields
    /// The part of `bytes` that a deep picture may take at most, with a sample for every ray and
    /// sheet. Most scenes need a small part of it, so it is not a reason to refuse a scene. A
    /// render stops if it needs more than the next limit.
    std::size_t deepBytes = 0;
    std::size_t mostDeepBytes = 0;  ///< limit on the samples of a sweep by the memory limit; 0: none
    /// Rough counts of the work ahead: of footprints, and upper bounds on shaded texels, on cells
    /// of shadow buffers walked, and on pixel and sheet pairs.
    RenderWork work;
};

/// True if the eye sees the volume's balls in place of its voxels, whose sheets then are for lights alone.
inline bool seesBalls(const Plan& plan, const ViewVolume& volume) {
    return volume.balls && !plan.perView;
}

/// The light of the scene that light `i` of the plan belongs to.
inline const Light& ownerOf(const ViewScene& scene, const Plan& plan, PlanLight i) {
    return scene.lights[std::size_t(plan.subLights.ownerOf(i))];
}

}  // namespace scrim
