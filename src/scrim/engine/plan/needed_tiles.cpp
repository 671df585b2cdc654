// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/plan/needed_tiles.h>

#include <scrim/engine/plan/view_frustum.h>
#include <scrim/engine/splat/field_planes.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace scrim {
namespace {

// Texels around what is seen that look-ups, sharpening and shadow buffers' cells reach into.
constexpr double kMargin = 6;

using Points = std::vector<Vec3>;

// Grows `box` by the part of the points' convex hull that lies within [lower, upper] along N.
void includeSlice(const Points& hull, double lower, double upper, Bounds& box) {
    for (std::size_t i = 0; i < hull.size(); ++i)
        for (std::size_t j = 0; j <= i; ++j) {
            const Vec3 &a = hull[i], &b = hull[j];
            if (std::max(a.z, b.z) < lower || std::min(a.z, b.z) > upper) continue;
            for (const double n : {lower, upper, a.z, b.z}) {
                const double at =
                    std::clamp(n, std::max(lower, std::min(a.z, b.z)), std::min(upper, std::max(a.z, b.z)));
                const double t = a.z == b.z ? 0 : (at - a.z) / (b.z - a.z);
                box.include(a + std::clamp(t, 0.0, 1.0) * (b - a));
            }
        }
}

// The points, and where the light's rays to them come from: the front of the stack, or the light within it.
Points withWayOf(const Light& light, const Sheets& sheets, const Points& points) {
    Points hull = points;
    for (const Vec3& p : points) {
        Vec3 back = light.type == LightType::distant ? sheets.tsVector(light.wsDirection)
                                                     : p - sheets.tsPoint(light.wsPosition);
        if (light.type != LightType::distant && p.z - back.z > 0) {
            hull.push_back(p - back);  // the light itself
            continue;
        }
        back.z = std::max(back.z, 1e-6);
        hull.push_back(p - std::max(p.z, 0.0) / back.z * back);
    }
    return hull;
}

PlaneStack::TileBounds tilesAround(const Bounds& ts, const Sheets& sheets) {
    const auto tile = [](double texel, int tiles) {
        return static_cast<int>(std::clamp(std::floor(texel / kTileEdge), -1.0, double(tiles)));
    };
    if (ts.empty()) return {0, 0, -1, -1};
    return {std::max(0, tile(ts.lower.x - kMargin, sheets.tilesX())),
            std::max(0, tile(ts.lower.y - kMargin, sheets.tilesY())),
            std::min(sheets.tilesX() - 1, tile(ts.upper.x + kMargin, sheets.tilesX())),
            std::min(sheets.tilesY() - 1, tile(ts.upper.y + kMargin, sheets.tilesY()))};
}

bool isEmpty(const PlaneStack::TileBounds& box) {
    return box.x1 < box.x0 || box.y1 < box.y0;
}

}  // namespace

PlaneStack::TileBounds NeededTiles::over(int from, int to) const {
    PlaneStack::TileBounds all{0, 0, -1, -1};
    for (int n = std::max(from, 0); n < std::min(to, static_cast<int>(sheets.size())); ++n) {
        const PlaneStack::TileBounds& box = sheets[static_cast<std::size_t>(n)];
        if (isEmpty(box)) continue;
        all = isEmpty(all) ? box
                           : PlaneStack::TileBounds{std::min(all.x0, box.x0), std::min(all.y0, box.y0),
                                                    std::max(all.x1, box.x1), std::max(all.y1, box.y1)};
    }
    return all;
}

double NeededTiles::share(const Sheets& s) const {
    double tiles = 0;
    for (const PlaneStack::TileBounds& box : sheets)
        if (!isEmpty(box)) tiles += double(box.x1 - box.x0 + 1) * (box.y1 - box.y0 + 1);
    return tiles / (double(s.tilesX()) * s.tilesY() * s.count);
}

NeededTiles neededTiles(const ViewScene& scene, const PixelWindow& window, const Sheets& sheets,
                        const std::vector<const Light*>& shadowed, const Checkpoint& checkpoint) {
    const ViewFrustum frustum(scene.camera, window);
    Bounds seen;
    for (const Vec3& p : frustum.visibleParts(wsCorners(scene))) seen.include(sheets.tsPoint(p));
    NeededTiles needed;
    needed.sheets.assign(static_cast<std::size_t>(sheets.count), {0, 0, -1, -1});
    if (seen.empty()) return needed;

    // A sheet's neighbours count where something is made of their values, too.
    double reach = 1;
    for (const ViewVolume& volume : scene.volumes) reach = std::max(reach, 1.0 + VolumePlanes::halo(volume, sheets));
    const std::array<Vec3, 8> box = seen.corners();
    const Points eye(box.begin(), box.end());
    std::vector<Points> hulls{eye};
    for (const Light* light : shadowed) hulls.push_back(withWayOf(*light, sheets, eye));
    for (int n = 0; n < sheets.count; ++n) {
        checkpoint();
        Bounds slice;
        for (const Points& hull : hulls) includeSlice(hull, n - reach, n + 1 + reach, slice);
        needed.sheets[static_cast<std::size_t>(n)] = tilesAround(slice, sheets);
        if (isEmpty(needed.sheets[static_cast<std::size_t>(n)])) continue;
        if (needed.last == 0) needed.first = n;
        needed.last = n + 1;
    }
    return needed;
}

}  // namespace scrim
