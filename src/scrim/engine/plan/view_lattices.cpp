// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/plan/view_lattices.h>

#include <scrim/base/error.h>
#include <scrim/engine/model/eye_view.h>
#include <scrim/engine/plan/sheet_stack.h>
#include <scrim/volume/kernel.h>

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <glm/geometric.hpp>

namespace scrim {
namespace {

constexpr double kMargin = 8;  // cells; a footprint's rounded-up rows must lie within

// The smallest angle between rays and the sheets: half a degree, in radians.
constexpr double kLeastRise = 0.0087;
// The smallest angle between rays and the plane of the raster, in radians; rays may be slanted by 85 degrees at most.
constexpr double kLeastCrossing = 0.0872;

// A linear form on sweep space relative to a point, as a row that acts on (U, V, N, 1).
glm::dvec4 rowOf(const Vec3& ssForm, const Vec3& step, const Vec3& tsFrom) {
    const Vec3 form = ssForm * step;
    return {form.x, form.y, form.z, -glm::dot(form, tsFrom)};
}

Vec3 meanOf(const std::vector<Vec3>& directions) {
    Vec3 sum(0);
    for (const Vec3& d : directions) sum += d;
    return glm::normalize(sum);
}

// The lattice with cells of size `cell` around the extent, from the rows x, y and w, whose units
// `cell` and the extent have.
Lattice layRaster(const Box2<double>& extent, double cell, const glm::dvec4& x, const glm::dvec4& y,
                  const glm::dvec4& w, double& coarser) {
    coarser = coarserFor(extent, cell);
    cell *= coarser;
    const auto size = [&](double first, double last) {
        const int cells = static_cast<int>(std::ceil((last - first) / cell + 2 * kMargin));
        return roundUpToTile(cells);
    };
    Lattice raster;
    raster.kind = Lattice::Kind::parallel;
    raster.width = size(extent.x0, extent.x1);
    raster.height = size(extent.y0, extent.y1);
    const glm::dvec4 column = x / cell + (kMargin - extent.x0 / cell) * w;
    const glm::dvec4 row = y / cell + (kMargin - extent.y0 / cell) * w;
    for (int c = 0; c < 4; ++c) raster.rsFromTs[c] = {column[c], row[c], c == 2 ? 1.0 : 0.0, w[c]};
    return raster;
}

// The normal, in sweep space, of the planes in which a light's own sheets lie: along the light or
// along the viewing axis, as the dial says.
Vec3 planeNormal(const ViewScene& scene, const Light& light, const Sheets& sheets, const Vec3& along) {
    if (scene.dials.shadowPlane != ShadowPlane::image) return along;
    Vec3 normal = sheets.ssFromWs * viewingAxis(scene.camera);
    if (glm::dot(normal, along) < 0) normal = -normal;
    if (glm::dot(normal, along) < kLeastCrossing)
        throw Error(ErrorKind::render,
                    fmt::format("light '{}' runs along the image plane, to which its shadow buffer cannot be aligned; "
                                "shadow_plane = \"light\" can",
                                light.name));
    return normal;
}

// The number of tiles around the picture that footprints of voxels just outside of it may reach.
int guardTiles(const ViewScene& scene, const Camera& camera, const Sheets& sheets) {
    if (camera.type != CameraType::orthographic) return 1;  // footprints are clipped at the border there
    const Lattice raster = EyeView(camera, sheets).lattice({0, 0, 1, 1}, 0);
    double reach = 0;
    for (const ViewVolume& volume : scene.volumes) {
        const Mat4 rsFromIs = raster.rsFromTs * sheets.tsFrom(volume.wsFromIs);
        for (int axis = 0; axis < 2; ++axis)
            reach = std::max(reach, kernelExtent(volume.kernel.value_or(scene.dials.kernel),
                                                 {rsFromIs[0][axis], rsFromIs[1][axis], rsFromIs[2][axis]}));
    }
    return static_cast<int>(std::ceil((2 * reach + 6) / kTileEdge));
}

}  // namespace

Lattice lightLattice(const ViewScene& scene, const Light& light, const std::vector<Vec3>& corners, const Sheets& sheets,
                     PlannedLight& part) {
    const bool distant = light.distant();
    const Vec3 step(sheets.texel, sheets.texel, sheets.thickness);

    Vec3 along = sheets.ssFromWs * meanOf(part.wsDirections);
    if (std::abs(along.z) < kLeastRise) along = glm::normalize(Vec3(along.x, along.y, kLeastRise));
    const Vec3 normal = planeNormal(scene, light, sheets, along);
    const Mat3 frame = frameAround(normal);
    const Vec3 ey = frame[0], ex = -frame[1];

    auto extent = Box2<double>::nothing();
    if (distant) {
        // Projects points along the light onto the plane.
        const double crossing = glm::dot(normal, along);
        const Vec3 fx = ex - normal * (glm::dot(ex, along) / crossing);
        const Vec3 fy = ey - normal * (glm::dot(ey, along) / crossing);
        const glm::dvec4 x = rowOf(fx, step, Vec3(0)), y = rowOf(fy, step, Vec3(0)), w(0, 0, 0, 1);
        for (const Vec3& corner : corners) {
            const glm::dvec4 ts(sheets.tsPoint(corner), 1.0);
            extent.include(glm::dot(x, ts), glm::dot(y, ts));
        }
        return layRaster(extent, scene.dials.shadowTexel * sheets.texel, x, y, w, part.coarser);
    }

    const Vec3 source = sheets.tsPoint(light.wsPosition);
    const glm::dvec4 x = rowOf(ex, step, source), y = rowOf(ey, step, source), w = rowOf(normal, step, source);
    double farthest = 0;
    bool inFront = true;
    for (const Vec3& corner : corners) {
        const glm::dvec4 ts(sheets.tsPoint(corner), 1.0);
        const double depth = glm::dot(w, ts);
        farthest = std::max(farthest, depth);
        inFront = inFront && depth > 0.5 * sheets.thickness;
        if (inFront) extent.include(glm::dot(x, ts) / depth, glm::dot(y, ts) / depth);
    }
    if (!inFront || !part.wsWindows.empty()) {
        extent = Box2<double>::nothing();
        for (const Vec3& ws : part.wsDirections) {
            const Vec3 d = sheets.ssFromWs * ws;
            const double depth = std::max(glm::dot(normal, d), kLeastCrossing);
            extent.include(glm::dot(ex, d) / depth, glm::dot(ey, d) / depth);
        }
    }
    Lattice raster = layRaster(extent, scene.dials.shadowTexel * sheets.texel / std::max(farthest, sheets.thickness), x,
                               y, w, part.coarser);
    raster.kind = Lattice::Kind::perspective;
    return raster;
}

Lattice eyeLattice(const ViewScene& scene, const PixelWindow& window, const Sheets& sheets) {
    const int n = scene.dials.antialias;
    const Camera camera = supersampled(scene.camera, n);
    return EyeView(camera, sheets).lattice(supersampled(window, n), guardTiles(scene, camera, sheets));
}

}  // namespace scrim
