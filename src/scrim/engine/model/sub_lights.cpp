// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/model/sub_lights.h>

#include <scrim/scene/picture_cells.h>
#include <scrim/scene/optics.h>
#include <scrim/solid/mesh_parts.h>
#include <scrim/geometry/bounds.h>
#include <scrim/scene/light_at.h>
#include <scrim/scene/phase_over_caps.h>
#include <scrim/image/light_profile.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <glm/vector_relational.hpp>

namespace scrim {
namespace {

constexpr double kPi = std::numbers::pi;

// Points in the unit square that are evenly distributed along every line through it: one in each of `count` columns and
// of `count` rows. A shadow's edge in any direction is thus divided into about `count` fine steps, where a square grid
// would show the square root of that as bands. From column to column the row advances by the golden section, which
// wraps disks and spheres in Fibonacci's spiral; only the resulting order matters. One of the points is the centre.
std::vector<Vec2> evenPlaces(int count) {
    const auto height = [](int i) { return i / std::numbers::phi - std::floor(i / std::numbers::phi); };
    std::vector<int> columns(static_cast<std::size_t>(count));
    std::iota(columns.begin(), columns.end(), 0);
    std::sort(columns.begin(), columns.end(), [&](int a, int b) { return height(a) < height(b); });
    std::vector<Vec2> places(columns.size());
    for (int row = 0; row < count; ++row) {
        const int column = columns[std::size_t(row)];
        places[std::size_t(column)] = {(column + 0.5) / count, (row + 0.5) / count};
    }
    return places;
}

// Maps the unit square to the unit disk, preserving ratios of areas.
Vec2 onDisk(const Vec2& p) {
    return std::sqrt(p.x) * Vec2(std::cos(2 * kPi * p.y), std::sin(2 * kPi * p.y));
}

// Maps the unit square to the cap of the unit sphere with cos >= `cosine` to +z, preserving ratios of areas.
Vec3 onCap(const Vec2& p, double cosine) {
    const double z = 1 - p.x * (1 - cosine), r = std::sqrt(std::max(0.0, 1 - z * z));
    return {r * std::cos(2 * kPi * p.y), r * std::sin(2 * kPi * p.y), z};
}

// The radius of an element of a surface with this area, within which irradiance grows no further: a
// disk of the same area fills the half-space in front of it, 2 pi, and so does the element there.
double radiusOf(double area) {
    return std::sqrt(area / (2 * kPi));
}

Light elementAt(const Light& whole, const Vec3& ws, const Vec3& normal, double area, const Rgb& power) {
    Light light = whole;
    Light::Element element;
    element.spread = whole.area()->spread;
    element.radius = radiusOf(area);
    light.kind = element;
    light.wsPosition = ws;
    light.wsDirection = normal;
    light.slide.reset();
    light.intensity = power;
    return light;
}

Light sunFrom(const Light& whole, const Vec3& travel, const Rgb& irradiance) {
    Light light = whole;
    light.kind = Light::Distant();
    light.wsDirection = travel;
    light.intensity = irradiance;
    return light;
}

// The solid angle of a cone with this full angle, degrees.
double coneOf(double angle) {
    return 2 * kPi * (1 - std::cos(glm::radians(0.5 * angle)));
}
// The solid angle that a surface shines into.
double coneOf(const Light& light) {
    return coneOf(light.area()->spread);
}

// The solid angle of a light as seen from the point of the box `ws` that is closest to it.
double solidAngle(const Light& light, const Bounds& ws) {
    if (light.dome()) return 4 * kPi;
    if (!light.area()) return coneOf(std::get<Light::Distant>(light.kind).angle);
    if (ws.empty()) return 0;
    const double distance = ws.distance(light.wsPosition);
    // The solid angle of a disk of the same area, seen from its axis.
    return 2 * kPi * (1 - distance / std::hypot(distance, std::sqrt(light.area()->area() / kPi)));
}

// A window of the light's shape, with the picture on it, for a viewer who stands at the light.
std::shared_ptr<const Texture> windowOf(const Light& light) {
    constexpr int kEdge = 64, kParts = 8;  // of a disk's picture, and of a pixel at its rim
    const bool disk = light.area()->shape == AreaShape::disk;
    const Texture::Level* picture = light.slide ? &light.slide->image->levels().front() : nullptr;
    int width = disk ? kEdge : 1, height = width;
    if (picture && !disk) width = picture->width, height = picture->height;
    Image image = emptyImage({0, 0, width, height});
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            float* pixel = image.rgba.data() + image.indexOf(x, y);
            int inside = 0;
            for (int i = 0; disk && i < kParts * kParts; ++i)
                inside += std::hypot((x + (i % kParts + 0.5) / kParts) / kEdge - 0.5,
                                     (y + (i / kParts + 0.5) / kParts) / kEdge - 0.5) < 0.5
                              ? 1
                              : 0;
            std::fill_n(pixel, 4, disk ? static_cast<float>(inside) / (kParts * kParts) : 1.0f);
            if (picture) std::copy_n(picture->pixel(width - 1 - x, y), 4, pixel);
        }
    return std::make_shared<const Texture>(image);
}

// Parallel light through the light's window, in directions all over the cone that it shines into.
// Its power stays the same.
void addBeams(const Light& whole, int count, std::vector<Light>& out) {
    const Light::Area& area = *whole.area();
    const Spread spread(area.spread);
    const double cosine = std::cos(glm::radians(0.5 * area.spread)), each = coneOf(whole) / count;
    const Mat3 frame = lightFrame(whole);
    const std::shared_ptr<const Texture> window = windowOf(whole);
    const std::size_t first = out.size();
    double power = 0;
    for (const Vec2& p : evenPlaces(count)) {
        const Vec3 way = count == 1 ? Vec3(0, 0, 1) : onCap(p, cosine);
        power += each * spread.at(way.z) * way.z;
        Light& light = out.emplace_back(sunFrom(whole, frame * way, whole.intensity * (each * spread.at(way.z))));
        light.slide.emplace();
        light.slide->image = window;
        light.slide->width = area.shape == AreaShape::disk ? 2 * area.radius : area.width;
        light.slide->height = area.shape == AreaShape::disk ? 2 * area.radius : area.height;
    }
    for (std::size_t i = first; i < out.size() && power > 0; ++i) out[i].intensity *= kPi / power;
}

void addSurface(const Light& whole, int count, std::vector<Light>& out) {
    const Light::Area& area = *whole.area();
    const double all = area.area();
    if (whole.slide) {
        for (const PictureCell& cell : rectangleCells(whole, count))
            out.push_back(
                elementAt(whole, cell.center, whole.wsDirection, cell.share * all, whole.intensity * all * cell.sum));
        return;
    }
    const Mat3 frame = lightFrame(whole);
    const Rgb power = whole.intensity * (all / count);
    for (const Vec2& p : evenPlaces(count)) {
        Vec3 normal = whole.wsDirection, offset(0);
        if (area.shape == AreaShape::rectangle) {
            offset = frame * Vec3((p.x - 0.5) * area.width, (p.y - 0.5) * area.height, 0);
        } else if (area.shape == AreaShape::disk) {
            offset = frame * Vec3(area.radius * (count == 1 ? Vec2(0) : onDisk(p)), 0);
        } else if (area.shape == AreaShape::cylinder) {
            normal = frame * Vec3(0, std::cos(2 * kPi * p.y), std::sin(2 * kPi * p.y));
            offset = area.radius * normal + (p.x - 0.5) * area.width * frame[0];
        } else {
            normal = onCap(p, -1);
            offset = area.radius * normal;
        }
        out.push_back(elementAt(whole, whole.wsPosition + offset, normal, all / count, power));
    }
}

// A point that sends into each direction what a part of a mesh of this area sends there.
Light patchAt(const Light& whole, const Vec3& ws, const MeshPart& part, double area) {
    constexpr float kStep = 10;  // degrees
    Light light = whole;
    light.kind = Light::Point{radiusOf(area)};
    light.wsPosition = ws;
    light.wsDirection = Vec3(0, 0, -1);
    light.wsUp = Vec3(0, 1, 0);
    const Mat3 frame = lightFrame(light);
    FilePhotometry sent;
    for (float angle = 0; angle <= 180; angle += kStep) sent.vertical.push_back(angle);
    for (float angle = 0; angle <= 360; angle += kStep) sent.horizontal.push_back(angle);
    for (const float h : sent.horizontal)
        for (const float v : sent.vertical) {
            const double turn = glm::radians(double(h)), down = glm::radians(double(v));
            const Vec3 way =
                frame * Vec3(std::sin(down) * std::sin(turn), -std::sin(down) * std::cos(turn), std::cos(down));
            double seen = 0;
            for (const MeshPiece& piece : part) seen += std::max(glm::dot(piece.area, way), 0.0);
            sent.candela.push_back(static_cast<float>(seen));
        }
    const float most = *std::max_element(sent.candela.begin(), sent.candela.end());
    light.luminaire = Luminaire{"", "", std::make_shared<const LightProfile>(sent)};
    light.intensity = whole.intensity * double(most);
    return light;
}

// Scales the light of one part of a mesh so that at the corners and in the middle of the volumes as much arrives as
// from all its pieces. A point is not where they are: a tube of radius r that is bent around the volumes, at a distance
// d, would be 0.8 r / d off. Places beside the part, for which no point can stand, do not count.
void scaleToPieces(Light& light, const Rgb& radiance, const MeshPart& part, double reach, const Bounds& ws) {
    constexpr double kMost = 2, kBeside = 3;
    double pieces = 0, whole = 0;
    const auto weigh = [&](const Vec3& place) {
        if (glm::distance(place, light.wsPosition) < kBeside * reach) return;
        for (const MeshPiece& piece : part) {
            const Vec3 way = place - piece.at;
            pieces += largest(radiance) * std::max(glm::dot(piece.area, way), 0.0) /
                      std::pow(std::max(glm::dot(way, way), 1e-300), 1.5);
        }
        whole += largest(LightAt(light, 0).at(place).irradiance);
    };
    weigh(ws.center());
    for (const Vec3& corner : ws.corners()) weigh(corner);
    if (pieces > 0 && whole > 0) light.intensity *= std::clamp(pieces / whole, 1 / kMost, kMost);
}

// True if a part of a mesh is in media, where each place is lit by a few of its triangles alone.
bool isWithin(const Light& light, const ViewScene& scene) {
    constexpr int kPlaces = 96;
    const Bounds ws = wsBounds(scene), &own = light.area()->wsSurface;
    if (glm::any(glm::greaterThan(own.lower, ws.upper)) || glm::any(glm::lessThan(own.upper, ws.lower))) return false;
    FieldSamplers samplers;
    std::vector<VolumeOptics> media;
    for (const ViewVolume& volume : scene.volumes)
        if (!volume.field->empty()) media.emplace_back(volume, Kernel::linear, samplers);
    const MeshPlaces places(*light.area()->surface);
    return std::ranges::any_of(evenPlaces(kPlaces), [&](const Vec2& p) {
        const Vec3 at = places.at(p).at;
        return std::ranges::any_of(media, [&](const VolumeOptics& medium) { return medium.mostExtinction(at) > 0; });
    });
}

// Elements all over a mesh, in front of its triangles.
void addElements(const Light& whole, int count, std::vector<Light>& out) {
    const MeshPlaces places(*whole.area()->surface);
    const double own = places.area() / count;
    if (!(own > 0)) return;
    for (const Vec2& p : evenPlaces(count)) {
        const auto [at, normal] = places.at(p);
        out.push_back(elementAt(whole, at, normal, own, whole.intensity * own));
    }
}

// One sub-light for each compact part of the mesh: a point in its middle that shines as the part does, or an element if
// it is flat. If the mesh is itself in the way of its light, or in media, where cells know how it shines
// (AreaShine), elements all over it.
void addMesh(const Light& whole, int count, const ViewScene& scene, std::vector<Light>& out) {
    constexpr double kFlat = 0.95;
    if (!whole.area()->surface || whole.area()->surface->triangles.empty()) return;
    const bool own = scene.solids && std::ranges::any_of(scene.solids->all(), [&](const Solid& solid) {
                         return solid.shadows && solid.name == whole.area()->mesh;
                     });
    if (own || isWithin(whole, scene)) {
        constexpr int kOfNormals = 4;  // those of neighbours differ, which parts would even out
        addElements(whole, kOfNormals * count, out);
        return;
    }
    const Bounds ws = wsBounds(scene);
    for (const MeshPart& part : meshParts(*whole.area()->surface, ws, count)) {
        const PartShape shape = shapeOf(part);
        const double front = glm::length(shape.facing);
        out.push_back(front < kFlat * shape.area
                          ? patchAt(whole, shape.middle, part, shape.area)
                          : elementAt(whole, shape.middle, shape.facing / front, shape.area, whole.intensity * front));
        scaleToPieces(out.back(), whole.intensity, part, shape.reach, ws);
    }
}

void addSky(const Light& whole, int count, std::vector<Light>& out) {
    if (whole.slide) {
        for (const PictureCell& cell : domeCells(whole, count)) {
            out.push_back(sunFrom(whole, -cell.center, whole.intensity * cell.sum));
            out.back().slide.reset();
        }
        return;
    }
    for (const Vec2& p : evenPlaces(count))
        out.push_back(sunFrom(whole, onCap(p, -1), whole.intensity * (4 * kPi / count)));
}

void addSun(const Light& whole, double angle, int count, std::vector<Light>& out) {
    const Mat3 frame = lightFrame(whole);
    const double cosine = std::cos(glm::radians(0.5 * angle));
    for (const Vec2& p : evenPlaces(count))
        out.push_back(sunFrom(whole, count == 1 ? whole.wsDirection : glm::normalize(frame * onCap(p, cosine)),
                              whole.intensity * (1.0 / count)));
}

// A sphere at a distance d of at least twice its radius r from all volumes shines like points all
// over it that shine evenly: both send 1 + r^2 / 4 d^2 times the light of one point. (Elements
// would be off by 5 to 9 % from nine of them, at any distance, and by 0.7 % from a hundred.)
bool isFarSphere(const Light& light, const Bounds& ws) {
    const Light::Area* area = light.area();
    if (!area || area->shape != AreaShape::sphere || ws.empty()) return false;
    const Vec3 nearest = glm::clamp(light.wsPosition, ws.lower, ws.upper);
    return glm::distance(light.wsPosition, nearest) >= 2 * area->radius;
}

void addFarSphere(const Light& whole, int count, std::vector<Light>& out) {
    const double radius = whole.area()->radius;
    const std::vector<Vec3> points = pointsOfLamp(whole, count);
    const Vec3 middle = std::accumulate(points.begin(), points.end(), Vec3(0)) / double(count);
    for (const Vec3& point : points) {
        Light& light = out.emplace_back(whole);
        light.kind = Light::Point();
        light.wsPosition = point + whole.wsPosition - middle;  // so that no side gets more
        light.intensity = whole.intensity * (kPi * radius * radius / count);
    }
}

}  // namespace

int subLightCount(const ViewScene& scene, const Light& light) {
    if (!light.extended()) return 1;
    if (light.samples > 0) return light.samples;
    // The error of N sub-lights falls as 1 / N, and is smaller for a light that fills less of the sky. With a plume of
    // dense smoke, a sky left 0.85 / N, a sun of 20 degrees 0.09 / N, one of 5 degrees 0.02 / N and a soft box near by
    // 0.2 / N. All of these are about the square root of the light's share of the sky.
    constexpr double kPerRoot = 1;
    const double share = (shinesInBeams(scene, light) ? coneOf(light) : solidAngle(light, wsBounds(scene))) / (4 * kPi);
    // Half of the sub-lights of a sphere or a cylinder are on its far side. A mesh is cut into parts that shine to all
    // sides, or has four elements for each, but there is no knowing how far it extends.
    constexpr double kLeastOfMesh = 64;
    const auto shape = light.area() ? light.area()->shape : AreaShape::disk;
    const double used = shape == AreaShape::sphere || shape == AreaShape::cylinder ? 0.5 : 1;
    const double count = kPerRoot * std::sqrt(share) / (used * scene.dials.lightError);
    const double least = shape == AreaShape::mesh ? kLeastOfMesh : 1;
    return static_cast<int>(std::clamp(std::ceil(count), least, double(kMostSubLights)));
}

namespace {

// True if a phase function has a lobe so narrow that a sky shows in it.
bool anyLobe(const ViewScene& scene) {
    constexpr double kNarrow = 0.35;
    return std::ranges::any_of(scene.volumes, [](const ViewVolume& volume) {
        return !volume.classified && !volume.field->empty() && lobeWidth(volume.medium.phase) < kNarrow;
    });
}

}  // namespace

int pointsOnCells(const ViewScene& scene, const Light& light) {
    const int count = subLightCount(scene, light);
    if (light.samples > 0 || !light.extended()) return count;
    // How much of a sphere's light arrives is known, only its transmittance is sampled, which differs little.
    constexpr int kOfSphere = 12;
    constexpr double kPerSize = 120;
    if (isLampOnCells(scene, light)) {
        const double points = kPerSize * light.area()->radius / largest(wsBounds(scene).size());
        return std::min(count, std::max(kOfSphere, static_cast<int>(std::ceil(points))));
    }
    // In smoke of g = 0.8 a sky at noon left 3.0, 1.5 and 1.0 % with 130, 260 and 325 directions,
    // one at dusk 2.6, 2.5 and 2.1.
    constexpr double kForLobes = 2;
    const double more = light.dome() && light.slide && anyLobe(scene) ? kForLobes : 1;
    // Measured on a plume of noise: a dome of 128 directions instead of 200 has the same error, as
    // have 16 points of a soft box instead of 35.
    const int most = light.dome() ? kMostSubLights : count;
    return std::max(std::min(static_cast<int>(std::ceil(more * count * (light.dome() ? 0.65 : 0.5))), most),
                    std::min(count, 8));
}

bool isLampOnCells(const ViewScene& scene, const Light& light) {
    if (!light.extended()) return true;
    if (!light.area() || light.area()->shape != AreaShape::sphere) return false;
    constexpr double kSmall = 0.25;
    return light.area()->radius <= kSmall * largest(wsBounds(scene).size());
}

bool lampsShareCells(const ViewScene& scene) {
    constexpr std::ptrdiff_t kFew = 4;
    if (wants(scene, Layer::light) || solidsBlock(scene)) return false;
    return std::count_if(scene.lights.begin(), scene.lights.end(), [&](const Light& light) {
               return !light.distant() && !light.dome() && isLampOnCells(scene, light);
           }) > kFew;
}

bool sameColour(const Rgb& a, const Rgb& b) {
    return glm::length(glm::cross(a, b)) <= 1e-12 * glm::length(a) * glm::length(b);
}

std::vector<Vec3> pointsOfLamp(const Light& light, int count) {
    if (!light.extended() || count == 1) return {light.wsPosition};
    const double spread = std::sqrt(0.75) * light.area()->radius;
    std::vector<Vec3> points;
    for (const Vec2& p : evenPlaces(count)) points.push_back(light.wsPosition + spread * onCap(p, -1));
    return points;
}

int SubLights::countOf(int owner) const {
    const auto [first, last] = std::equal_range(owners.begin(), owners.end(), owner);
    return static_cast<int>(last - first);
}

double capOf(double solidAngle) {
    return std::acos(std::clamp(1 - solidAngle / (2 * kPi), -1.0, 1.0));
}

double widestCap(const Light& subLight, double part, const Bounds& ws) {
    if (subLight.distant()) return capOf(part);
    const double r = ws.distance(subLight.wsPosition);
    return std::min(std::sqrt(part / kPi) / std::max(r, 1e-300), 0.5 * kPi);
}

namespace {

// The solid angle of a sun or sky, or the area that a surface's sub-lights stand for: of a far
// sphere, that of its disk.
double measureOf(const Light& light, bool farSphere) {
    if (const Light::Area* area = light.area()) return area->area() * (farSphere ? 0.25 : 1);
    return solidAngle(light, {});
}

// The suns in the picture of a sky, whole.
std::vector<Light> wholeSuns(const Light& dome) {
    std::vector<Light> suns;
    if (!dome.dome() || !dome.slide || !dome.slide->parts || !dome.slide->parts->smooth) return suns;
    for (const SkySun& sun : dome.slide->parts->suns) {
        Light& whole = suns.emplace_back(sunFrom(dome, -domeDirection(dome, sun.u, sun.v), dome.intensity * sun.light));
        whole.kind = Light::Distant(sun.angle);
        whole.slide.reset();
        whole.samples = 0;
    }
    return suns;
}

void addSuns(const ViewScene& scene, const Light& dome, SubLights& all) {
    for (const Light& whole : wholeSuns(dome)) {
        const int count = subLightCount(scene, whole);
        addSun(whole, std::get<Light::Distant>(whole.kind).angle, count, all.lights);
        all.parts.resize(all.lights.size(), measureOf(whole, false) / count);
        all.suns.resize(all.lights.size(), true);
    }
}

// The lights that buffers bring to a volume; empty: all of them.
std::vector<bool> litIn(const SubLights& all, const std::vector<ServedLight>& served, std::size_t volume) {
    std::vector<bool> lit;
    for (std::size_t i = 0; i < all.owners.size(); ++i) {
        const Server server = served[std::size_t(all.owners[i])].volumes[volume];
        lit.push_back(server == Server::buffers || (all.suns[i] && server != Server::none));
    }
    if (std::ranges::find(lit, false) == lit.end()) lit.clear();
    return lit;
}

}  // namespace

std::vector<Light> sunsOfSky(const ViewScene& scene, const Light& dome) {
    SubLights suns;
    addSuns(scene, dome, suns);
    return suns.lights;
}

SubLights subLights(const ViewScene& scene) {
    return subLights(scene, servedLights(scene));
}

SubLights subLights(const ViewScene& scene, const std::vector<ServedLight>& served) {
    SubLights all;
    const Bounds ws = wsBounds(scene);
    for (std::size_t i = 0; i < scene.lights.size(); ++i) {
        const Light& light = scene.lights[i];
        const int count = subLightCount(scene, light);
        const std::size_t first = all.lights.size();
        const bool beams = shinesInBeams(scene, light);
        if (!served[i].inSweeps) {
            // Only its suns take sweeps.
        } else if (beams)
            addBeams(light, count, all.lights);
        else if (isFarSphere(light, ws))
            addFarSphere(light, count, all.lights);
        else if (light.area() && light.area()->shape == AreaShape::mesh)
            addMesh(light, count, scene, all.lights);
        else if (light.area())
            addSurface(light, count, all.lights);
        else if (light.dome())
            addSky(light, count, all.lights);
        else if (light.extended())
            addSun(light, std::get<Light::Distant>(light.kind).angle, count, all.lights);
        else
            all.lights.push_back(light);
        all.suns.resize(all.lights.size(), false);
        const double measure = beams ? coneOf(light) : light.extended() ? measureOf(light, isFarSphere(light, ws)) : 0;
        // The directions of a picture are where its light is. Lobes show them best with a quarter of an even share: a
        // clear sky was 10 % off in smoke of g = 0.8 with a whole one, and 1.5 % with this.
        constexpr double kOfShare = 0.25;
        const double share = light.dome() && light.slide ? kOfShare : 1;
        all.parts.resize(all.lights.size(), share * measure / double(all.lights.size() - first));
        addSuns(scene, light, all);
        if (all.lights.size() == all.owners.size()) {  // its picture is black, or it is on cells: it is culled
            all.suns.push_back(false);
            all.parts.push_back(0);
            all.lights.push_back(sunFrom(light, light.wsDirection, Rgb(0)));
            all.lights.back().slide.reset();
        }
        all.owners.resize(all.lights.size(), static_cast<int>(i));
    }
    for (std::size_t v = 0; v < scene.volumes.size(); ++v) all.lit.push_back(litIn(all, served, v));
    return all;
}

namespace {

// Puts skies in the place of what stands for them.
void keepSkies(const ViewScene& scene, SubLights& all) {
    SubLights kept;
    kept.lit.resize(all.lit.size());
    for (std::size_t i = 0; i < all.lights.size(); ++i) {
        const auto owner = std::size_t(all.owners[i]);
        const bool sky = scene.lights[owner].dome() != nullptr;
        if (sky && i > 0 && all.owners[i - 1] == all.owners[i]) continue;
        kept.lights.push_back(sky ? scene.lights[owner] : all.lights[i]);
        kept.owners.push_back(all.owners[i]);
        for (std::size_t v = 0; v < all.lit.size(); ++v)
            kept.lit[v].push_back(sky ? litBy(scene.volumes[v].lights, owner) : litBy(all.lit[v], i));
    }
    all = std::move(kept);
}

}  // namespace

ViewScene withFewSubLights(const ViewScene& scene, int count, Skies skies) {
    ViewScene few = scene;
    for (Light& light : few.lights) {
        if (!light.extended()) continue;
        light.samples = light.samples > 0 ? std::min(light.samples, count) : count;
        if (light.slide && !light.slide->image) light.slide.reset();
    }
    SubLights all = subLights(few);
    if (skies == Skies::whole) keepSkies(few, all);
    few.lights = all.lights;
    for (std::size_t v = 0; v < few.volumes.size(); ++v) {
        ViewVolume& volume = few.volumes[v];
        const std::vector<bool> shadowsByOwner = std::exchange(volume.shadows, {});
        for (std::size_t i = 0; i < all.owners.size() && !shadowsByOwner.empty(); ++i)
            volume.shadows.push_back(shadowsByOwner[std::size_t(all.owners[i])]);
        volume.lights = all.lit[v];
    }
    return few;
}

bool shinesInBeams(const ViewScene& scene, const Light& light) {
    // Windows lean with the directions: at half of this, one of 15 degrees is 3.4 % narrower than it should be.
    constexpr double kMostSpread = 30;
    if (!light.area() || light.area()->spread > kMostSpread || light.shadow == ShadowMethod::cells) return false;
    const Bounds ws = wsBounds(scene);
    if (ws.empty() || (light.slide && !light.slide->image)) return false;
    const auto corners = ws.corners();
    const double distance = glm::distance(ws.center(), light.wsPosition);
    return coneOf(light) < std::min(light.area()->area() / (distance * distance), 2 * kPi) &&
           std::all_of(corners.begin(), corners.end(),
                       [&](const Vec3& corner) { return glm::dot(corner - light.wsPosition, light.wsDirection) > 0; });
}

}  // namespace scrim
