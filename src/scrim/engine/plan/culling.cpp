// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/plan/culling.h>

#include <scrim/base/parallel.h>
#include <scrim/engine/plan/light_groups.h>
#include <scrim/engine/splat/surface.h>
#include <scrim/geometry/sheets.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

constexpr double kAround = 0.5;  // pixels

// The faces of a parallelepiped, by the indices of its corners.
constexpr int kFaces[6][4] = {{0, 1, 3, 2}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 3, 7, 5}};

// True if the point is inside of the parallelepiped.
bool contains(const std::array<Vec3, 8>& c, const Vec3& p) {
    const Mat3 edges(c[1] - c[0], c[2] - c[0], c[4] - c[0]);
    if (std::abs(glm::determinant(edges)) < 1e-300) return false;
    const Vec3 at = glm::inverse(edges) * (p - c[0]);
    return smallest(at) >= 0 && largest(at) <= 1;
}

// The part of space that a picture shows.
class ViewFrustum {
  public:
    ViewFrustum(const Camera& camera, const PixelWindow& window);

    // See visibleParts.
    std::vector<Vec3> visiblePart(const std::array<Vec3, 8>& wsCorners) const;
    std::vector<Vec3> visibleParts(const std::vector<Vec3>& wsCorners) const;

  private:
    struct Plane {
        Vec3 normal;  // points to the inside
        double offset;
        double side(const Vec3& ws) const { return glm::dot(normal, ws) - offset; }
    };
    std::vector<Plane> m_planes;
    std::vector<Vec3> m_corners;  // corners of the near plane, or the eye
};

ViewFrustum::ViewFrustum(const Camera& camera, const PixelWindow& window) {
    const RayFamily rays = wsRays(camera);
    const double x[2] = {window.x0 - kAround, window.x1 + kAround}, y[2] = {window.y0 - kAround, window.y1 + kAround};
    const Vec3 forward = viewingAxis(camera);
    const auto pointOn = [&](int i, int j, double t) {
        return rays.origin(x[i], y[j]) + t * rays.direction(x[i], y[j]);
    };
    const Vec3 inside = rays.origin(0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1])) +
                        (rays.near + 1) * rays.direction(0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1]));
    const auto add = [&](const Vec3& a, const Vec3& b, const Vec3& c) {
        const Vec3 cross = glm::cross(b - a, c - a);
        if (glm::dot(cross, cross) == 0) return;
        Plane plane{glm::normalize(cross), 0};
        plane.offset = glm::dot(plane.normal, a);
        if (plane.side(inside) < 0) plane = {-plane.normal, -plane.offset};
        m_planes.push_back(plane);
    };
    // Each side contains an edge of the raster at two depths; both are in front of the eye, where
    // rays of a perspective view meet.
    for (int i = 0; i < 2; ++i) {
        add(pointOn(i, 0, rays.near + 1), pointOn(i, 1, rays.near + 1), pointOn(i, 0, rays.near + 2));
        add(pointOn(0, i, rays.near + 1), pointOn(1, i, rays.near + 1), pointOn(0, i, rays.near + 2));
    }
    m_planes.push_back({forward, glm::dot(forward, pointOn(0, 0, rays.near))});
    for (int i = 0; i < 2; ++i)
        for (int j = 0; j < 2; ++j) m_corners.push_back(pointOn(i, j, rays.near));
}

std::vector<Vec3> ViewFrustum::visiblePart(const std::array<Vec3, 8>& wsCorners) const {
    std::vector<Vec3> visible;
    for (const auto& face : kFaces) {
        std::vector<Vec3> polygon;
        for (const int corner : face) polygon.push_back(wsCorners[corner]);
        for (const Plane& plane : m_planes) {
            std::vector<Vec3> cut;
            for (std::size_t i = 0; i < polygon.size(); ++i) {
                const Vec3 &a = polygon[i], &b = polygon[(i + 1) % polygon.size()];
                const double sideA = plane.side(a), sideB = plane.side(b);
                if (sideA >= 0) cut.push_back(a);
                if ((sideA < 0) != (sideB < 0)) cut.push_back(a + sideA / (sideA - sideB) * (b - a));
            }
            polygon = std::move(cut);
        }
        visible.insert(visible.end(), polygon.begin(), polygon.end());
    }
    // The frustum may begin inside of the box, and its edges may pass through it.
    for (const Vec3& corner : m_corners)
        if (contains(wsCorners, corner)) visible.push_back(corner);
    return visible;
}

std::vector<Vec3> ViewFrustum::visibleParts(const std::vector<Vec3>& wsCorners) const {
    std::vector<Vec3> visible;
    std::array<Vec3, 8> box;
    for (std::size_t i = 0; i + box.size() <= wsCorners.size(); i += box.size()) {
        std::copy_n(wsCorners.begin() + static_cast<std::ptrdiff_t>(i), box.size(), box.begin());
        const std::vector<Vec3> part = visiblePart(box);
        visible.insert(visible.end(), part.begin(), part.end());
    }
    return visible;
}

bool scatters(const ViewVolume& volume) {
    if (volume.field->empty()) return false;
    if (volume.classified) return true;
    return volume.medium.mostExtinction() > 0 && (!volume.scatter.empty() || volume.medium.albedo != Rgb(0));
}

// True if light that passes `from` may reach `to`. The test uses enclosing shapes, so a yes may be wrong.
bool shadowReaches(const Light& light, const std::vector<Vec3>& from, const std::vector<Vec3>& to) {
    if (light.extended()) return true;
    if (light.distant()) {
        const Mat3 alongLight = sweepRotation(light.wsDirection, apartFrom(light.wsDirection));
        const auto boxOf = [&](const std::vector<Vec3>& points) {
            Bounds box;
            for (const Vec3& p : points) box.include(alongLight * p);
            return box;
        };
        const Bounds a = boxOf(from), b = boxOf(to);
        return a.lower.x <= b.upper.x && b.lower.x <= a.upper.x && a.lower.y <= b.upper.y && b.lower.y <= a.upper.y &&
               a.lower.z <= b.upper.z;
    }
    std::vector<Vec3> directions;
    const Cone a = coneToCorners(light.wsPosition, from, directions);
    directions.clear();
    const Cone b = coneToCorners(light.wsPosition, to, directions);
    if (a.cosAngle <= 0 || b.cosAngle <= 0) return true;
    double farthest = 0;
    for (const Vec3& p : to) farthest = std::max(farthest, glm::distance(p, light.wsPosition));
    // No point of the boxes is nearer than the plane across the cone's axis through the nearest corner.
    double nearest = std::numeric_limits<double>::infinity();
    for (const Vec3& p : from) nearest = std::min(nearest, glm::dot(p - light.wsPosition, a.axis));
    const double between = std::acos(std::clamp(glm::dot(a.axis, b.axis), -1.0, 1.0));
    return nearest <= farthest && between <= std::acos(a.cosAngle) + std::acos(b.cosAngle);
}

}  // namespace

std::vector<Vec3> visibleParts(const Camera& camera, const PixelWindow& window, const std::vector<Vec3>& wsCorners) {
    return ViewFrustum(camera, window).visibleParts(wsCorners);
}

std::vector<std::string> culledLights(const ViewScene& scene, const SubLights& lights) {
    const ViewFrustum frustum(scene.camera, wholePicture(scene));
    std::vector<std::vector<Vec3>> visible;  // of volumes that scatter
    bool scattering = false;
    for (const ViewVolume& volume : scene.volumes) {
        scattering = scattering || scatters(volume);
        visible.push_back(scatters(volume) ? frustum.visibleParts(wsCorners(volume, scene.dials.kernel))
                                           : std::vector<Vec3>{});
    }
    std::vector<std::string> reasons;
    for (std::size_t i = 0; i < lights.lights.size(); ++i) {
        const Light& light = lights.lights[i];
        std::string& reason = reasons.emplace_back();
        if (light.intensity == Rgb(0)) {
            reason = "it is black";
            continue;
        }
        bool linked = false, sees = false, reaches = false;
        for (std::size_t v = 0; v < scene.volumes.size(); ++v) {
            if (!litBy(lights.lit[v], i)) continue;
            linked = true;
            if (visible[v].empty()) continue;
            sees = true;
            std::vector<Vec3> directions;
            reaches = reaches || light.distant() ||
                      !passesBy(light, beamOf(light), coneToCorners(light.wsPosition, visible[v], directions));
        }
        if (!scattering)
            reason = "no volume scatters light";
        else if (!linked)
            reason = "no volume is linked to it";
        else if (!sees)
            reason = "it lights nothing in view";
        else if (!reaches)
            reason = "its beam misses every volume in view";
    }
    return reasons;
}

std::vector<std::string> culledVolumes(const Camera& camera, const PixelWindow& picture,
                                       const std::vector<Light>& lights, const std::vector<VolumeBox>& volumes) {
    const ViewFrustum frustum(camera, picture);
    std::vector<std::vector<Vec3>> visible;
    bool allKnown = true;
    for (const VolumeBox& volume : volumes) {
        visible.push_back(frustum.visibleParts(volume.wsCorners.value_or(std::vector<Vec3>{})));
        allKnown = allKnown && volume.wsCorners;
    }
    const auto shades = [&](std::size_t v) {
        for (std::size_t i = 0; i < lights.size(); ++i)
            for (std::size_t w = 0; w < volumes.size(); ++w)
                if (lights[i].shadows && lights[i].intensity != Rgb(0) && litBy(volumes[v].shadows, i) &&
                    litBy(volumes[w].lights, i) && !visible[w].empty() &&
                    shadowReaches(lights[i], *volumes[v].wsCorners, visible[w]))
                    return true;
        return false;
    };
    // A volume with unknown bounds may receive shadows from any other.
    const bool mayShade =
        !allKnown && std::any_of(lights.begin(), lights.end(), [](const Light& l) { return l.shadows; });
    std::vector<std::string> reasons(volumes.size());
    for (std::size_t v = 0; v < volumes.size(); ++v) {
        if (!volumes[v].wsCorners || !visible[v].empty()) continue;
        if (!volumes[v].wsCorners->empty() && (mayShade || shades(v))) continue;
        reasons[v] = "it is out of view and casts no shadow into view";
    }
    return reasons;
}

namespace {

// Margin, in texels, around what is visible: look-ups, prefilters and shadow buffers' cells use neighbours.
constexpr double kMargin = 6;

using Points = std::vector<Vec3>;

// Extends `box` by the part of the points' convex hull within [lower, upper] along N.
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

// The points, and the places where the light's rays to them start: the front of the stack, or a light inside of it.
Points withWayOf(const Light& light, const Sheets& sheets, const Points& points) {
    Points hull = points;
    bool within = false;
    for (const Vec3& p : points) {
        Vec3 back = light.distant() ? sheets.tsVector(light.wsDirection) : p - sheets.tsPoint(light.wsPosition);
        if (!light.distant() && p.z - back.z > 0) {
            if (!within) hull.push_back(p - back);  // the light itself
            within = true;
            continue;
        }
        back.z = std::max(back.z, 1e-6);
        hull.push_back(p - std::max(p.z, 0.0) / back.z * back);
    }
    return hull;
}

Box2<int> tilesAround(const Bounds& ts, const Sheets& sheets) {
    if (ts.empty()) return {};
    const auto tile = [](double texel, int tiles) {
        return static_cast<int>(std::clamp(std::floor(texel / kTileEdge), -1.0, double(tiles)));
    };
    return intersection<int>(
        {0, 0, sheets.tilesX(), sheets.tilesY()},
        {tile(ts.lower.x - kMargin, sheets.tilesX()), tile(ts.lower.y - kMargin, sheets.tilesY()),
         tile(ts.upper.x + kMargin, sheets.tilesX()) + 1, tile(ts.upper.y + kMargin, sheets.tilesY()) + 1});
}

}  // namespace

NeededTiles neededTiles(const ViewScene& scene, const PixelWindow& window, const Sheets& sheets,
                        const std::vector<const Light*>& shadowed, const Checkpoint& checkpoint) {
    const ViewFrustum frustum(scene.camera, window);
    Bounds seen;
    for (const Vec3& p : frustum.visibleParts(wsCorners(scene))) seen.include(sheets.tsPoint(p));
    NeededTiles needed;
    needed.sheets.resize(std::size_t(sheets.count));
    if (seen.empty()) return needed;

    // Neighbouring sheets count where their values are used, too.
    double reach = 1;
    for (const ViewVolume& volume : scene.volumes)
        if (volume.classified) reach = 1 + Surface::kBefore;
    const std::array<Vec3, 8> box = seen.corners();
    const Points eye(box.begin(), box.end());
    std::vector<Points> hulls{eye};
    for (const Light* light : shadowed) hulls.push_back(withWayOf(*light, sheets, eye));
    checkpoint();
    parallelFor(needed.sheets.size(), [&](std::size_t sheet) {
        const auto n = static_cast<int>(sheet);
        Bounds slice;
        for (const Points& hull : hulls) includeSlice(hull, n - reach, n + 1 + reach, slice);
        needed.sheets[sheet] = tilesAround(slice, sheets);
    });
    for (int n = 0; n < sheets.count; ++n) {
        if (needed.sheets[std::size_t(n)].empty()) continue;
        if (needed.last == 0) needed.first = n;
        needed.last = n + 1;
    }
    return needed;
}

}  // namespace scrim
