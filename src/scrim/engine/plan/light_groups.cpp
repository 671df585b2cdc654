// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/plan/light_groups.h>

#include <scrim/base/error.h>
#include <scrim/engine/plan/flat_voxels.h>
#include <scrim/image/light_profile.h>
#include <scrim/scene/slide_map.h>
#include <scrim/geometry/enclosing_cone.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string_view>
#include <tuple>

#include <fmt/format.h>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>

namespace scrim {
namespace {

constexpr double kCosSlack = 1e-12;  // rounding of a cosine and its inverse
constexpr int kPointsOfRim = 16;     // directions that stand for a cone

double angleOf(double cosine) {
    return std::acos(std::clamp(cosine, -1.0, 1.0));
}

// 42 directions spread evenly over the sphere: the corners of an icosahedron and the middles of its edges. Every
// direction is within 21 degrees of one of them, so windows of 32 degrees overlap well.
const std::vector<Vec3>& windowAxes() {
    static const std::vector<Vec3> axes = [] {
        const double golden = (1 + std::sqrt(5.0)) / 2;
        std::vector<Vec3> corners;
        for (const double a : {-1.0, 1.0})
            for (const double b : {-golden, golden})
                for (int axis = 0; axis < 3; ++axis) {
                    Vec3 p(0);
                    p[(axis + 1) % 3] = a;
                    p[(axis + 2) % 3] = b;
                    corners.push_back(p);
                }
        std::vector<Vec3> all;
        for (const Vec3& p : corners) all.push_back(glm::normalize(p));
        for (std::size_t i = 0; i < corners.size(); ++i)
            for (std::size_t j = 0; j < i; ++j)
                if (glm::distance(corners[i], corners[j]) < 2.1)  // edges have length 2
                    all.push_back(glm::normalize(corners[i] + corners[j]));
        return all;
    }();
    return axes;
}

// Divides a light's directions into the windows that meet the volume's cone (all windows, for a
// light inside) and the light's own beam.
void addWindows(PlanLight index, const Light& light, const Beam& beam, const Cone& cone,
                std::vector<PlannedLight>& parts) {
    const std::vector<Vec3>& axes = windowAxes();
    const double volumeAngle = cone.cosAngle > 0 ? std::acos(cone.cosAngle) : std::numbers::pi;
    for (const Vec3& axis : axes) {
        if (angleOf(glm::dot(axis, cone.axis)) > volumeAngle + kWindowAngle) continue;
        if (angleOf(glm::dot(axis, light.wsDirection)) > beam.angle + kWindowAngle) continue;
        PlannedLight part;
        part.light = index;
        part.wsDirections = rimOfCone(axis, kWindowAngle);
        for (const Vec3& other : axes) {
            if (angleOf(glm::dot(axis, other)) >= 2 * kWindowAngle) continue;
            if (other == axis) part.window = static_cast<int>(part.wsWindows.size());
            part.wsWindows.push_back(other);
        }
        parts.push_back(std::move(part));
    }
}

void addParts(PlanLight index, const Light& light, const std::vector<Vec3>& corners, std::vector<PlannedLight>& parts) {
    if (light.distant()) {
        parts.push_back({index, {light.wsDirection}, {}, 0});
        return;
    }
    std::vector<Vec3> directions;
    const Cone cone = coneToCorners(light.wsPosition, corners, directions);
    const Beam beam = beamOf(light);
    const double volumeAngle = angleOf(cone.cosAngle);
    // A slide that misses the volume needs no work, and a slide that is narrower than the volume
    // leaves most of it alone.
    if (passesBy(light, beam, cone)) return;
    if (light.slide && beam.angle < std::min(volumeAngle, kWidestView)) {
        parts.push_back({index, beam.directions, {}, 0});
        return;
    }
    if (volumeAngle <= kWidestView) {
        parts.push_back({index, std::move(directions), {}, 0});
        return;
    }
    // A spot's own cone may be narrow enough where the volume is not.
    if (beam.angle <= kWidestView) {
        parts.push_back({index, beam.directions, {}, 0});
        return;
    }
    addWindows(index, light, beam, cone, parts);
}

// The eye's rays, reversed if eye and light face each other.
std::vector<Vec3> turnedEye(const std::vector<Vec3>& eye, bool sameSide) {
    std::vector<Vec3> directions;
    for (const Vec3& d : eye) directions.push_back(sameSide ? d : -d);
    return directions;
}

// The cone around the eye's rays and the lights' rays.
Cone groupCone(const std::vector<Vec3>& eye, const std::vector<const PlannedLight*>& parts, bool sameSide) {
    std::vector<Vec3> directions = turnedEye(eye, sameSide);
    for (const PlannedLight* part : parts)
        directions.insert(directions.end(), part->wsDirections.begin(), part->wsDirections.end());
    return enclosingCone(directions);
}

Vec3 meanDirection(const std::vector<Vec3>& directions) {
    Vec3 sum(0);
    for (const Vec3& d : directions) sum += d;
    return sum;
}

struct Item {
    PlannedLight part;
    // Those of its directions that matter to cones, since every group is tested against them.
    std::vector<Vec3> corners;
    bool sameSide;
    double slant;      // of the best sweep for this part alone
    double meanSlant;  // mean over both sides that serve the part, weighted by their shares
    Vec3 mean;
    std::string name;
    std::optional<FlatSheets> flat;  // where these serve it better
};

// The share of the sweep with s = +1 in a light whose angle to the eye has this cosine.
double shareOfSameSide(double cosine, double crossFade) {
    const double edge = std::sin(glm::radians(crossFade));
    // Rounding must not decide the side of a light that is perpendicular to the eye.
    if (edge <= 0) return cosine >= -1e-9 ? 1 : 0;
    const double t = std::clamp(0.5 + 0.5 * cosine / edge, 0.0, 1.0);
    return t * t * (3 - 2 * t);
}

// The parts in an order that does not depend on the scene's, with those closest to the eye's axis first.
std::vector<Item> orderedParts(const ViewScene& scene, const SubLights& lights, const std::vector<Vec3>& corners,
                               const EyePart& eye, const FlatVoxels& flatVoxels, const std::vector<std::string>& culled,
                               const Checkpoint& checkpoint) {
    std::vector<PlannedLight> parts;
    for (std::size_t i = 0; i < lights.lights.size(); ++i)
        if (culled.empty() || culled[i].empty()) addParts(PlanLight(i), lights.lights[i], corners, parts);

    const Vec3 axis = eye.whole ? viewingAxis(scene.camera) : glm::normalize(meanDirection(eye.wsDirections));
    std::vector<Item> items;
    for (const PlannedLight& part : parts) {
        checkpoint();
        const Vec3 mean = meanDirection(part.wsDirections);
        const double fade = scene.dials.crossFade.value_or(kCrossFade);
        const double same = shareOfSameSide(glm::dot(mean, axis) / glm::length(mean), fade);
        double meanSlant = 0;
        const std::size_t first = items.size();
        const std::vector<Vec3> outer = cornersOf(part.wsDirections);
        if (const auto flat = flatVoxels.sheets(eye.wsDirections, part.wsDirections)) {
            items.push_back(
                {part, outer, flat->sameSide, flat->slant, flat->slant, mean, lights.of(part.light).name, flat});
            items.back().part.share = 1;
            continue;
        }
        for (const bool sameSide : {true, false}) {
            const double share = sameSide ? same : 1 - same;
            if (share <= 0) continue;
            std::vector<Vec3> all = turnedEye(eye.wsDirections, sameSide);
            all.insert(all.end(), outer.begin(), outer.end());
            const double slant = angleOf(enclosingCone(all).cosAngle);
            items.push_back({part, outer, sameSide, slant, 0, mean, lights.of(part.light).name, {}});
            items.back().part.share = share;
            meanSlant += share * slant;
        }
        for (std::size_t i = first; i < items.size(); ++i) items[i].meanSlant = meanSlant;
    }
    std::stable_sort(items.begin(), items.end(), [](const Item& a, const Item& b) {
        return std::tie(a.slant, a.mean.x, a.mean.y, a.mean.z, a.name) <
               std::tie(b.slant, b.mean.x, b.mean.y, b.mean.z, b.name);
    });
    return items;
}

void setAxis(GroupPlan& group, const ViewScene& scene, const std::vector<Vec3>& eye) {
    std::vector<const PlannedLight*> parts;
    for (const PlannedLight& part : group.lights) parts.push_back(&part);
    const Cone cone = groupCone(eye, parts, group.sameSide);
    group.wsAxis = cone.axis;
    group.slant = angleOf(cone.cosAngle);
    if (scene.dials.sheets == SheetAxis::imageAligned) {
        group.wsAxis = group.sameSide ? viewingAxis(scene.camera) : -viewingAxis(scene.camera);
        double least = 1;
        for (const Vec3& d : eye) least = std::min(least, std::abs(glm::dot(d, group.wsAxis)));
        for (const PlannedLight* part : parts)
            for (const Vec3& d : part->wsDirections) least = std::min(least, glm::dot(d, group.wsAxis));
        group.slant = angleOf(least);
    }
}

// Distributes alpha and ambient light. They belong to the sweep with the least slant, which is that of the light
// closest to the eye's axis. In the next frame this may be another light. Therefore all lights that are about as close
// have a share, which grows as smoothly as their own share does. `groupOf`: the group of each item.
void sharePrimary(const std::vector<Item>& items, const std::vector<std::size_t>& groupOf, double crossFade,
                  std::vector<GroupPlan>& groups) {
    const double edge = glm::radians(crossFade);
    if (items.empty() || edge <= 0) {
        groups.front().primary = 1;
        return;
    }
    double least = items.front().meanSlant, sum = 0;
    for (const Item& item : items) least = std::min(least, item.meanSlant);
    for (std::size_t i = 0; i < items.size(); ++i) {
        const double t = std::clamp(1 - (items[i].meanSlant - least) / edge, 0.0, 1.0);
        groups[groupOf[i]].primary += items[i].part.share * t * t * (3 - 2 * t);
    }
    for (const GroupPlan& group : groups) sum += group.primary;
    for (GroupPlan& group : groups) group.primary /= sum;
}

// A group that parts of lights still join.
struct OpenGroup {
    GroupPlan plan;
    GrowingCone cone;
    std::optional<FlatSheets> flat;
};

// The group that a part joins: that in which it adds the least slant, of at most `limit` radians; the number of groups
// if it needs one of its own. Parts with sheets along flat voxels share one for each side.
std::size_t groupFor(const Item& item, const std::vector<OpenGroup>& groups, double limit) {
    const auto mayJoin = [&](const OpenGroup& group) {
        return group.plan.sameSide == item.sameSide && group.flat.has_value() == item.flat.has_value();
    };
    std::size_t best = groups.size();
    for (std::size_t g = 0; g < groups.size(); ++g) {
        if (!mayJoin(groups[g])) continue;
        if (item.flat) return g;
        const double cosMost = std::cos(limit) - kCosSlack;
        if (groups[g].cone.cone().cosAngle < cosMost) continue;  // its slant is too large already
        const double slant = angleOf(groups[g].cone.with(item.corners, cosMost).cosAngle);
        if (slant <= limit) {
            limit = slant;
            best = g;
        }
    }
    // A group with a larger slant takes a part that does not increase its slant, such as a window
    // that other lights have, too.
    for (std::size_t g = 0; g < groups.size() && best == groups.size(); ++g)
        if (mayJoin(groups[g]) && groups[g].cone.holds(item.corners)) best = g;
    return best;
}

void checkSlants(const ViewScene& scene, const std::vector<GroupPlan>& groups) {
    for (const GroupPlan& group : groups) {
        if (group.slant <= kSlantLimit) continue;
        // Lights cross the paper's own sheets at any slant, with visible errors (ZC02 Fig. 17).
        if (scene.dials.sheets == SheetAxis::imageAligned && scene.dials.splat == SplatMode::perView) continue;
        const std::string_view cause = scene.dials.sheets == SheetAxis::imageAligned
                                           ? "image-aligned sheets do not suit this scene (sheets = \"half-way\" "
                                             "does)"
                                           : "the camera's field of view is too wide";
        throw Error(ErrorKind::render,
                    fmt::format("{}: rays lean {:.1f} degrees from the sweep's axis, at most {:.0f} can be rendered",
                                cause, glm::degrees(group.slant), glm::degrees(kSlantLimit)));
    }
}

}  // namespace

std::vector<GroupPlan> groupLights(const ViewScene& scene, const SubLights& lights, const std::vector<Vec3>& corners,
                                   const EyePart& part, const std::vector<std::string>& culled,
                                   const Checkpoint& checkpoint) {
    const std::vector<Vec3>& eye = part.wsDirections;
    std::vector<OpenGroup> open;
    std::vector<std::size_t> groupOf;
    const FlatVoxels flat(scene);
    const std::vector<Item> items = orderedParts(scene, lights, corners, part, flat, culled, checkpoint);
    for (const Item& item : items) {
        checkpoint();
        const std::size_t g = groupFor(item, open, glm::radians(scene.dials.maxSlant));
        if (g == open.size()) {
            open.push_back({{}, GrowingCone(turnedEye(eye, item.sameSide)), item.flat});
            open.back().plan.sameSide = item.sameSide;
        }
        open[g].plan.lights.push_back(item.part);
        open[g].cone.add(item.corners);
        if (item.flat) open[g].flat->slant = std::max(open[g].flat->slant, item.slant);
        groupOf.push_back(g);
    }
    // The primary group exists even without lights.
    if (open.empty()) open.push_back({{}, GrowingCone(eye), flat.sheets(eye, {})});

    std::vector<GroupPlan> groups;
    for (OpenGroup& group : open) {
        if (group.flat) {
            group.plan.wsAxis = group.flat->wsAxis;
            group.plan.slant = group.flat->slant;
        } else {
            setAxis(group.plan, scene, eye);
        }
        groups.push_back(std::move(group.plan));
    }
    sharePrimary(items, groupOf, scene.dials.crossFade.value_or(kCrossFade), groups);
    checkSlants(scene, groups);
    return groups;
}

std::vector<Vec3> rimOfCone(const Vec3& axis, double angle) {
    const Mat3 frame = frameAround(axis);
    std::vector<Vec3> directions;
    for (int i = 0; i < kPointsOfRim; ++i) {
        const double t = 2 * std::numbers::pi * i / kPointsOfRim;
        directions.push_back(std::cos(angle) * axis +
                             std::sin(angle) * (std::cos(t) * frame[0] + std::sin(t) * frame[1]));
    }
    return directions;
}

Cone coneToCorners(const Vec3& wsPoint, const std::vector<Vec3>& corners, std::vector<Vec3>& directions) {
    for (const Vec3& corner : corners)
        if (glm::distance(corner, wsPoint) > 0) directions.push_back(glm::normalize(corner - wsPoint));
    return enclosingCone(directions);
}

namespace {

// Directions around a cone between which no ray of it passes. Between those of rimOfCone, rasters
// that are laid over them would lose up to 1.9 % of the cone's radius.
std::vector<Vec3> aroundCone(const Vec3& axis, double angle) {
    const double touching = std::cos(std::numbers::pi / kPointsOfRim);
    return rimOfCone(axis, std::atan2(std::sin(angle), std::cos(angle) * touching));
}

}  // namespace

Beam beamOf(const Light& light) {
    constexpr double pi = std::numbers::pi;
    Beam beam{{}, pi};
    if (const Light::Spot* spot = light.spot()) {
        beam.angle = glm::radians(0.5 * spot->coneAngle);
        beam.directions = aroundCone(light.wsDirection, beam.angle);
    }
    if (const Light::Element* element = light.element()) {
        beam.angle = glm::radians(0.5 * element->spread);
        beam.directions = aroundCone(light.wsDirection, beam.angle);
    }
    if (light.luminaire && light.luminaire->profile) {
        const double angle = glm::radians(light.luminaire->profile->reach());
        if (angle < beam.angle) beam = {aroundCone(light.wsDirection, angle), angle};
    }
    if (!light.slide) return beam;
    if (light.slide->outside == SlideOutside::black) {
        const double angle = slideHalfAngle(light);
        if (angle < beam.angle) beam = {slideCorners(light), angle};
    }
    beam.angle = std::min(beam.angle, 0.5 * pi);  // a slide lights nothing behind it
    return beam;
}

bool passesBy(const Light& light, const Beam& beam, const Cone& cone) {
    if (cone.cosAngle <= 0) return false;
    const double between = std::acos(std::clamp(glm::dot(light.wsDirection, cone.axis), -1.0, 1.0));
    return between > beam.angle + std::acos(std::min(cone.cosAngle, 1.0));
}

namespace {

// The direction of travel of the most important light.
Vec3 mainDirection(const ViewScene& scene, const Vec3& center) {
    for (const bool shadows : {true, false})
        for (const Light& light : scene.lights) {
            if (light.shadows != shadows || light.dome() || light.intensity == Rgb(0)) continue;
            const Vec3 way = light.distant() ? light.wsDirection : center - light.wsPosition;
            if (glm::length(way) > 0) return glm::normalize(way);
        }
    return {0, 0, -1};
}

}  // namespace

Camera cameraAlongLight(const ViewScene& scene) {
    Camera camera;
    const Bounds box = wsBounds(scene);
    if (box.empty()) return scene.camera;
    const Vec3 way = mainDirection(scene, box.center());
    const double size = std::max(glm::length(box.size()), 1e-300);
    camera.type = CameraType::orthographic;
    camera.height = 1.01 * size;
    camera.wsPosition = box.center() - size * way;
    camera.wsFromCamera = lookAt(camera.wsPosition, box.center(), {0, 1, 0});
    camera.resolution = {64, 64};
    return camera;
}

}  // namespace scrim
