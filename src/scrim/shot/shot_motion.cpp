// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/shot_motion.h>

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/engine/plan/transport_plan.h>
#include <scrim/engine/shared_light.h>
#include <scrim/engine/sweep.h>
#include <scrim/geometry/even_points.h>
#include <scrim/scene/field_rays.h>
#include <scrim/scene/quality.h>
#include <scrim/shot/mean_frame.h>
#include <scrim/shot/moved_field.h>
#include <scrim/shot/point_balls.h>
#include <scrim/shot/view_motion.h>
#include <scrim/verify/moment_dials.h>
#include <scrim/verify/pilot_picture.h>
#include <scrim/volume/coarser.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

constexpr int kMostSamples = 128, kMostWithLens = 512;
constexpr double kFinest = 0.7;    // pixels; no picture shows finer voxels than these one by one
constexpr double kBlurPart = 0.7;  // of the promised error; squares of this and of what texels and sheets leave add up

// The raster position of a point; no value where it is not in front of the camera.
std::optional<Vec2> rasterOf(const Camera& camera, const Vec3& ws, double least) {
    const RayFamily rays = wsRays(camera);
    const Mat3 ways(rays.directionX, rays.directionY, rays.direction0);
    const double depth = glm::dot(ws - camera.wsPosition, viewingAxis(camera));
    if (camera.type == CameraType::orthographic) {
        const Vec3 p = ws - rays.origin0;
        return Vec2(glm::dot(p, rays.originX) / glm::dot(rays.originX, rays.originX),
                    glm::dot(p, rays.originY) / glm::dot(rays.originY, rays.originY));
    }
    if (depth < least) return std::nullopt;
    const Vec3 p = glm::inverse(ways) * ((ws - camera.wsPosition) / depth);
    return Vec2(p.x / p.z, p.y / p.z);
}

struct Places {
    Camera camera;
    std::vector<Vec3> ws;  // the same points at each moment
    std::vector<Light> lights;
};

Bounds boundsOf(const std::vector<Vec3>& points) {
    Bounds box;
    for (const Vec3& p : points) box.include(p);
    return box;
}

Places pointsOf(const ViewScene& view) {
    Places out{view.camera, {}, view.lights};
    // The corners are those of the fields at rest, so that their number does not depend on whether there is a velocity.
    for (ViewVolume volume : view.volumes) {
        volume.velocity = nullptr;
        const std::vector<Vec3> corners = wsCorners(volume, view.dials.kernel);
        out.ws.insert(out.ws.end(), corners.begin(), corners.end());
    }
    if (view.solids)
        for (const Solid& solid : view.solids->all())
            for (const Vec3& corner : boundsOf(solid.mesh->points).corners())
                out.ws.push_back(transformPoint(solid.wsFromMesh, corner));
    return out;
}

// A rough estimate, in world units, of how far the shadows that a light throws move between two moments.
double lightWay(const Light& a, const Light& b, const Bounds& ws) {
    const double radius = 0.5 * glm::length(ws.size());
    const double roll = a.luminaire ? glm::length(a.wsUp - b.wsUp) : 0;
    const double turn = (glm::length(a.wsDirection - b.wsDirection) + roll) * radius;
    if (a.distant()) return a.slide ? turn + glm::distance(a.wsPosition, b.wsPosition) : turn;
    const double distance = std::max(glm::distance(ws.center(), a.wsPosition), 1e-6 * radius);
    return (a.spot() || a.slide || a.luminaire ? turn : 0) +
           glm::distance(a.wsPosition, b.wsPosition) * std::min(2 * radius / distance, 4.0);
}

bool sameLook(const SceneVolume& a, const SceneVolume& b) {
    if (a.albedoGrid && a.albedoGrid->scale != b.albedoGrid->scale) return false;
    for (std::size_t i = 0; i < a.emission.size(); ++i)
        if (a.emission[i].scale != b.emission[i].scale || a.emission[i].color != b.emission[i].color ||
            a.emission[i].ramp != b.emission[i].ramp)
            return false;
    return true;
}

// The scene as it is seen from a place on its lens.
Scene seenFrom(const Vec2& place, Scene scene) {
    if (scene.lens) scene.camera = throughLens(scene.camera, *scene.lens, place);
    return scene;
}

// The longest displacement by velocities, in world units, but for a few fast voxels, which are no
// reason for a hundred renders.
class UsualWays {
  public:
    void include(const ViewScene& view) {
        for (const ViewVolume& volume : view.volumes)
            if (volume.velocity) {
                const double usual = lengthOf(volume.velocity->wsRange([&](const SparseField& f) { return most(f); }));
                const double all = lengthOf(volume.velocity->wsRange());
                m_longest = std::max(m_longest, usual);
                if (all > usual && all > m_outlier.second) m_outlier = {usual, all};
            }
    }
    double longest() const { return m_longest; }
    // The usual and the longest displacement of the volume whose fastest voxels are farthest beyond
    // the usual; both are 0 where no volume has such voxels.
    const std::pair<double, double>& outlier() const { return m_outlier; }

  private:
    static double lengthOf(const Bounds& ways) {
        double most = 0;
        for (const Vec3& way : ways.corners()) most = std::max(most, glm::length(way));
        return most;
    }
    double most(const SparseField& part) {
        const auto [found, isNew] = m_most.try_emplace(&part, 0);
        if (isNew) found->second = double(usualMost(part));
        return found->second;
    }

    std::map<const SparseField*, double> m_most;
    double m_longest = 0;
    std::pair<double, double> m_outlier{0, 0};
};

// How long the ways by velocities are at these moments, one after the other, over how far they lead
// from the places at the frame: 1 from there straight on, 2 to and fro.
double waysPerReach(const std::vector<Fields>& moments) {
    double most = 1;
    for (std::size_t v = 0; v < moments.front().size(); ++v) {
        double way = 0, reach = 0;
        for (std::size_t i = 0; i < moments.size(); ++i) {
            reach = std::max(reach, std::abs(moments[i][v].time));
            if (i > 0) way += std::abs(moments[i][v].time - moments[i - 1][v].time);
        }
        constexpr double kRounding = 1e-9;
        if (way > (1 + kRounding) * reach) most = std::max(most, way / reach - kRounding);
    }
    return most;
}

}  // namespace

// The views of a shot at any moment. What does not depend on the moment is made once.
class ShotMotion::Moments {
  public:
    Moments(const LoadedShot& shot, const RenderOptions& options, double lod, double middle);
    double lod() const { return m_lod; }
    // The fields are where the files have them, beside the velocity that moves them.
    ViewScene inPlace(double t) const { return inPlace(t, m_shot.sceneAt(t)); }
    ViewScene inPlace(double t, const Scene& at) const;
    // The fields are moved, and volumes that the picture does not need are left out. `at`: the scene at time t.
    ViewScene moved(const Moment& moment, const Scene& at) const;

  private:
    void drawWays(const Moment& moment, ViewScene& view) const;
    const LoadedShot& m_shot;
    const RenderOptions& m_options;
    const double m_lod;
    const Scene m_middle;
    ViewScene m_base;
    std::vector<std::unique_ptr<const FieldMover>> m_movers;  // for each of the scene's volumes; null: no velocity
};

ShotMotion::Moments::Moments(const LoadedShot& shot, const RenderOptions& options, double lod, double middle)
    : m_shot(shot),
      m_options(options),
      m_lod(lod),
      m_middle(shot.sceneAt(middle)),
      m_base(shot.viewAt(middle, options, lod, VolumesOf::scene)),
      m_movers(shot.fields.size()) {
    for (const ViewVolume& volume : m_base.volumes) {
        std::vector<FieldPointer> velocity = shot.fields[std::size_t(volume.place)].velocity;
        if (velocity.empty()) continue;
        const bool glows = volume.field->empty() && !volume.emission.empty();
        const SparseField& weight = glows ? *volume.emission.front().field.field : *volume.field;
        // A coarser level of the fields moves by a velocity as coarse.
        const auto edgeOf = [](const SparseField& field) { return glm::length(Vec3(field.wsFromIs[0])); };
        for (FieldPointer& part : velocity)
            while (lod > 0 && !part->empty() && 1.5 * edgeOf(*part) < edgeOf(weight))
                part = std::make_shared<SparseField>(coarser(*part));
        m_movers[std::size_t(volume.place)] = std::make_unique<const FieldMover>(std::move(velocity), weight);
    }
}

ViewScene ShotMotion::Moments::inPlace(double t, const Scene& at) const {
    for (std::size_t i = 0; i < at.volumes.size(); ++i)
        if (!sameLook(at.volumes[i], m_middle.volumes[i])) {
            ViewScene out = m_shot.viewOf(at, t, m_options, m_lod, VolumesOf::scene);
            out.camera = at.camera;
            return out;
        }
    ViewScene out = m_base;
    out.camera = at.camera;
    out.lights = at.lights;
    out.ambient = at.ambient;
    if (m_shot.scene.movesWithin) out.solids = solidsOf(at);
    const Fields fields = m_shot.fieldsAt(t);
    for (ViewVolume& volume : out.volumes)
        place(at.volumes[std::size_t(volume.place)], fields[std::size_t(volume.place)], volume);
    return out;
}

// Lets balls be drawn along their ways from the begin of a moment to its end, seen by a camera that
// moves along its own.
void ShotMotion::Moments::drawWays(const Moment& moment, ViewScene& view) const {
    if (std::ranges::none_of(view.volumes, [](const ViewVolume& volume) { return volume.balls != nullptr; })) return;
    const std::array<double, 2> times{moment.time - 0.5 * moment.span, moment.time + 0.5 * moment.span};
    const std::array<Scene, 2> ends{seenFrom(moment.lens, m_shot.sceneAt(times[0])),
                                    seenFrom(moment.lens, m_shot.sceneAt(times[1]))};
    const std::array<Fields, 2> fields{m_shot.fieldsAt(times[0]), m_shot.fieldsAt(times[1])};
    view.span = {ends[0].camera, ends[1].camera};
    for (ViewVolume& volume : view.volumes) {
        const auto i = std::size_t(volume.place);
        if (volume.balls)
            volume.balls = movedBalls(*volume.balls, {&ends[0].volumes[i], &ends[1].volumes[i]},
                                      {fields[0][i].time, fields[1][i].time});
    }
}

ViewScene ShotMotion::Moments::moved(const Moment& moment, const Scene& at) const {
    const double t = moment.time;
    ViewScene out = inPlace(t, at);
    cull(at, out);
    const Fields fields = m_shot.fieldsAt(t);
    std::size_t bytes = 0;
    for (ViewVolume& volume : out.volumes) {
        VolumeFields own = fields[std::size_t(volume.place)];  // a volume and its detail have one place
        const FieldMover* mover = m_movers[std::size_t(volume.place)].get();
        if (!mover || own.time == 0) continue;
        const auto move = [&](std::shared_ptr<const SparseField>& field) {
            field = mover->moved(field, own.time);
            bytes += field->bytes();
        };
        move(volume.field);
        for (ViewField& field : volume.scatter) move(field.field);
        for (ViewEmission& emission : volume.emission) move(emission.field.field);
        own.time = 0;
        place(at.volumes[std::size_t(volume.place)], own, volume);
    }
    drawWays(moment, out);
    out.memoryLimit = limitBeside(out.memoryLimit, bytes);
    return out;
}

ShotMotion::ShotMotion(const LoadedShot& shot, const RenderOptions& options) : m_shot(shot), m_options(options) {
    if (shot.scene.shutter) m_shutter = *shot.scene.shutter;
    m_moves =
        shot.scene.shutter &&
        (shot.scene.movesWithin || std::any_of(shot.fields.begin(), shot.fields.end(), [](const VolumeFields& fields) {
             return std::any_of(fields.velocity.begin(), fields.velocity.end(),
                                [](const auto& part) { return part && !part->empty(); });
         }));
    if (!m_moves && !shot.scene.lens) return;
    m_moments = std::make_shared<const Moments>(shot, options, shot.scene.dials.lod.value_or(0), middle());
    m_light = KeyedLight(shot, m_shutter.open, m_shutter.close);
    m_path = longestPath();
    m_blur = largestBlur();
    const std::optional<int>& samples = shot.scene.dials.shutterSamples;
    m_samples = samples ? *samples : samplesFor(m_path);
    m_middle = viewAt({middle(), Vec2(0), (m_shutter.close - m_shutter.open) / m_samples});
    chooseDials();
}

ShotMotion::~ShotMotion() = default;

// With a lens alone, the places are a sunflower's seeds; if things move, too, moments are in the
// order of time, and each has a place of an evenly spread set (M. Roberts' R2).
Moment ShotMotion::momentOf(int i, int count) const {
    Moment moment;
    moment.time = m_shutter.open + (i + 0.5) / count * (m_shutter.close - m_shutter.open);
    moment.span = (m_shutter.close - m_shutter.open) / count;
    if (!m_shot.scene.lens) return moment;
    const double golden = std::numbers::pi * (3 - std::sqrt(5.0));
    const Vec2 square = evenPoint(i);
    const double radius = std::sqrt(m_moves ? square.x : (i + 0.5) / count);
    const double angle = m_moves ? 2 * std::numbers::pi * square.y : golden * i;
    moment.lens = radius * Vec2(std::cos(angle), std::sin(angle));
    return moment;
}

Scene ShotMotion::sceneAt(const Moment& moment) const {
    Scene at = m_shot.sceneAt(moment.time);
    m_light.average(moment.time - 0.5 * moment.span, moment.time + 0.5 * moment.span, at);
    return seenFrom(moment.lens, std::move(at));
}

ViewScene ShotMotion::viewAt(const Moment& moment) const {
    const Scene at = sceneAt(moment);
    ViewScene view = m_moments->moved(moment, at);
    if (wantsMotion(at)) {
        const Scene next = seenFrom(moment.lens, m_shot.nextAt(moment.time));
        addMotion(view, at, next, m_shot.fieldsAt(moment.time));
    }
    return view;
}

ViewScene ShotMotion::view() const {
    ViewScene view =
        blurs() ? m_middle : m_shot.view(m_options, m_shot.scene.dials.lod.value_or(0), VolumesOf::picture);
    if (m_shot.scene.shutter)
        view.shutter = ViewShutter{m_shutter.open, m_shutter.close, m_moves ? m_samples : 1, m_path, m_moves};
    if (m_shot.scene.lens) view.lens = ViewLens{*m_shot.scene.lens, m_samples, m_blur};
    return view;
}

ViewScene ShotMotion::truth() const {
    if (!blurs()) return m_shot.view(m_options, 0, VolumesOf::scene);
    const auto scenes =
        m_moments->lod() == 0 ? m_moments : std::make_shared<const Moments>(m_shot, m_options, 0, middle());
    ViewScene out = scenes->inPlace(middle());
    auto moments = std::make_shared<ViewMoments>();
    moments->open = m_shutter.open;
    moments->close = m_shutter.close;
    moments->path = m_path + m_blur;
    moments->lens = m_shot.scene.lens.has_value();
    moments->at = [this, scenes](const Moment& moment) { return scenes->inPlace(moment.time, sceneAt(moment)); };
    out.moments = std::move(moments);
    return out;
}

double ShotMotion::longestPath() {
    const int moments = m_moves ? 9 : 2;  // a lens alone needs what is the same at all of them
    std::vector<Places> places;
    UsualWays usual;
    std::vector<Fields> fields;
    for (int i = 0; i < moments; ++i) {
        const double part = static_cast<double>(i) / (moments - 1);
        const double t = (1 - part) * m_shutter.open + part * m_shutter.close;
        const ViewScene view = m_moments->inPlace(t);
        places.push_back(pointsOf(view));
        usual.include(view);
        fields.push_back(m_shot.fieldsAt(t));
    }
    const std::pair<double, double> outlier = usual.outlier();
    const double wsWay = usual.longest() * waysPerReach(fields);  // displacement by velocities
    const Bounds box = boundsOf(places.front().ws);
    if (box.empty()) return 0;
    const double least = 1e-3 * glm::length(box.size());
    std::vector<double> paths(places.front().ws.size());
    double lights = 0;
    for (int i = 1; i < moments; ++i) {
        const Places &a = places[std::size_t(i - 1)], &b = places[std::size_t(i)];
        for (std::size_t p = 0; p < std::min({paths.size(), a.ws.size(), b.ws.size()}); ++p) {
            const auto from = rasterOf(a.camera, a.ws[p], least), to = rasterOf(b.camera, b.ws[p], least);
            if (from && to) paths[p] += glm::distance(*from, *to);
        }
        double most = 0;
        for (std::size_t l = 0; l < a.lights.size(); ++l)
            most = std::max(most, lightWay(a.lights[l], b.lights[l], box));
        lights += most;
    }
    const Camera& camera = places.front().camera;
    const double distance = box.distance(camera.wsPosition);
    const double pixel = pixelAt(camera, std::max(distance, 0.25 * glm::length(box.size())));
    m_voxelPixels = std::max(voxelUnit(m_moments->inPlace(middle())) / pixel, kFinest);
    if (outlier.second > 0)
        notify(m_options.messages, Severity::warning,
               fmt::format("motion blur: fewer than one in 5,000 voxels of a velocity move up to {:.3g} pixels, all "
                           "others at most {:.3g}; the number of renders ignores these few",
                           outlier.second / pixel, outlier.first / pixel));
    const double most = 2.0 * (camera.resolution.x + camera.resolution.y);  // anything beyond this has left the picture
    return std::min(*std::max_element(paths.begin(), paths.end()) + (wsWay + lights) / pixel, most);
}

// Of the corners of all that the picture shows.
double ShotMotion::largestBlur() const {
    if (!m_shot.scene.lens) return 0;
    const Places places = pointsOf(m_moments->inPlace(middle()));
    const Camera& camera = places.camera;
    const double diagonal = std::hypot(camera.resolution.x, camera.resolution.y);
    double nearest = std::numeric_limits<double>::infinity(), farthest = 0;
    for (const Vec3& ws : places.ws) {
        const double depth = glm::dot(ws - camera.wsPosition, viewingAxis(camera));
        nearest = std::min(nearest, std::max(depth, camera.near));
        farthest = std::max(farthest, depth);
    }
    if (farthest <= 0) return 0;
    // What is nearer than this would be blurred to more than the picture.
    nearest = std::max(nearest, 1e-6 * farthest);
    const Lens& lens = *m_shot.scene.lens;
    return std::min(std::max(blurAt(camera, lens, nearest), blurAt(camera, lens, farthest)), diagonal);
}

double ShotMotion::promised() const {
    const Scene& scene = m_shot.scene;
    const bool classified =
        std::any_of(scene.volumes.begin(), scene.volumes.end(), [](const auto& v) { return v.classified != nullptr; });
    return scene.tolerance > 0 ? scene.tolerance : promisedError(scene.quality, classified);
}

// In most scenes the dials of a preset leave a third to a half of the error that it promises. Pilots of the scene at
// hand tell what they leave in it, if there are enough moments to pay for these.
void ShotMotion::chooseDials() {
    constexpr int kFewest = 4;
    // The mean of four moments or more has 0.4 to 0.8 of the error of each in most scenes. Where
    // only lights move, or edges move along themselves, it has 0.95 of it.
    constexpr double kOfMoment = 0.8;
    const Scene& scene = m_shot.scene;
    if (!scene.keepsPromise || m_samples < kFewest) return;
    // Surfaces and the edges of solids' shadows have bounds of their own.
    if (anyClassified(m_middle) || solidsBlock(m_middle)) return;
    const ProgressSink waits = partOf(m_options.progress, 0, 0);
    const double allowed = std::sqrt(1 - kBlurPart * kBlurPart) * promised() / kOfMoment;
    try {
        m_middle.dials = momentDials(m_middle, momentModel(m_middle, waits), allowed, waits);
    } catch (const Error& error) {
        // A crop may need less memory than pilots of the whole picture; it then has the dials of a still.
        if (error.kind() != ErrorKind::memory) throw;
    }
}

// Motion blur may take kBlurPart of the error that is promised.
int ShotMotion::samplesFor(double path) const {
    // Steps of one voxel are off by about 1.2 % of a cloud that is sharp at every voxel, and steps
    // of s voxels by s^2 times that; the hard edges of solids by about a fifth of a step. That is
    // the most renders; most pictures need far fewer.
    constexpr double kOfVoxelSteps = 0.012, kOfHardSteps = 0.14, kLeast = 4;
    const double error = kBlurPart * promised();
    double most = std::max(path / m_voxelPixels / std::sqrt(error / kOfVoxelSteps), kLeast);
    if (m_shot.solids) most = std::max(most, kOfHardSteps / error);
    // Places on the lens that are s voxels apart are off by 2.8 % times s^2: 8 of them by 2.5 %, of
    // a block that is hard at every voxel and blurred to 3 voxels.
    constexpr double kOfPlaces = 0.028;
    const bool lens = m_shot.scene.lens.has_value();
    // A lamp or mesh that is seen is as sharp as pixels are.
    const bool seen = m_shot.solids && wants(m_moments->inPlace(middle()), Layer::backdrop);
    const double across = 0.5 * m_blur / (seen ? kFinest : m_voxelPixels);
    if (lens) most += std::numbers::pi * across * across * kOfPlaces / error;
    // Moments and places together are a set in three dimensions, whose gaps close more slowly.
    if (lens && m_moves) most *= 3;
    // Where pixels bound the number, pilots up to it would take longer than they save.
    constexpr double kMostPilots = 32;
    const double wanted = std::min(wantedSamples(error, seen ? std::min(most, kMostPilots) : most), most);
    const int limit = lens ? kMostWithLens : kMostSamples;
    if (wanted > limit)
        notify(m_options.messages, Severity::warning,
               fmt::format("{}: {} {:.0f} pixels, which needs {} renders of the frame, but {} are made; "
                           "shutter_samples sets another number",
                           lens ? "depth of field" : "motion blur",
                           lens ? "a point is blurred to" : "the longest motion is", lens ? m_blur : path,
                           std::ceil(wanted), limit));
    return static_cast<int>(std::ceil(std::min(wanted, double(limit))));
}

// Small pictures with 2, 4, 8... moments tell how fast the error falls. They show the whole picture, whatever the crop,
// so that crops have as many moments as the whole. The midpoint rule's error falls with order 2 where the picture is
// smooth over a step and with less where an edge passes: 1.4 to 2.5 was measured from 2 to 16 moments.
double ShotMotion::wantedSamples(double error, double most) const {
    constexpr int kPilotEdge = 160, kPilotVoxel = 2;  // pixels
    // Of places on a lens, whose distances fall with the root of their number, it falls with half that order.
    const double order = m_shot.scene.lens ? 1 : 1.75;
    constexpr double kLeast = 2;
    const Int2 size = m_shot.scene.camera.resolution;
    const double scale = std::min(1.0, double(kPilotEdge) / std::max(size.x, size.y));
    const Moments moments(m_shot, m_options, std::max(kPilotVoxel / scale, m_shot.scene.dials.lod.value_or(0)),
                          middle());
    const ProgressSink waits = partOf(m_options.progress, 0, 0);
    std::optional<double> cell;
    const auto pilotAt = [&](const Moment& moment) {
        ViewScene coarse = moments.moved(moment, sceneAt(moment));
        coarse.dials = *presetDials(presetNames().front());
        coarse.dials.lightCell = cell;
        const bool backdrop = wants(coarse, Layer::backdrop);
        ViewScene pilot = pilotView(std::move(coarse), kPilotEdge);
        if (backdrop) pilot.layers = {Layer::backdrop};  // a lamp that is seen is blurred, too
        return pilot;
    };
    // What larger cells lack is in all pictures alike. Of a small picture they are most of the time.
    constexpr double kLarger = 2;
    ViewScene inMiddle = pilotAt({middle(), Vec2(0), m_shutter.close - m_shutter.open});
    if (const CellLightPlan cells = planCellLights(inMiddle); !cells.levels.empty())
        inMiddle.dials.lightCell = cell = kLarger * smallestCell(inMiddle, cells);
    const Plan middlePlan = makePlan(inMiddle, threadCount(), waits);
    SharedLight light(inMiddle, middlePlan);
    const auto picture = [&](int count) {
        MeanFrame mean(count);
        for (int i = 0; i < count; ++i) {
            const ViewScene pilot = pilotAt(momentOf(i, count));
            const Plan plan = makePlan(pilot, threadCount(), waits);
            mean.add(scrim::render(pilot, plan, waits, {}, light.servedTo(pilot, plan, waits)));
        }
        return mean.take().image;
    };
    Image coarse = picture(2);
    for (int count = 4;; count *= 2) {
        Image fine = picture(count);
        // The error of `fine`, if it falls with that order.
        const double left = differenceOf(coarse, fine).error / (std::pow(2, order) - 1);
        const double wanted = count * std::pow(left / error, 1 / order);
        // A further pilot pays where it may save renders.
        if (wanted <= 2 * count || 2 * count > most) return std::max(wanted, kLeast);
        coarse = std::move(fine);
    }
}

Frame ShotMotion::render(const ViewScene& view, const Plan& middlePlan, const ProgressSink& progress) const {
    // Half of the tolerance is for each moment, and half for their mean.
    MeanFrame mean(m_samples, view.deep ? 0.5 * view.deep->tolerance : 0);
    // Light on cells in the middle serves all moments in which only the camera is elsewhere.
    SharedLight light(view, middlePlan);
    for (int i = 0; i < m_samples; ++i) {
        const bool middle = 2 * i + 1 == m_samples && !m_shot.scene.lens;
        ViewScene moment = middle ? m_middle : viewAt(momentOf(i, m_samples));
        moment.dials = view.dials;
        if (view.deep) moment.deep = ViewDeep{0.5 * view.deep->tolerance};
        moment.memoryLimit = limitBeside(moment.memoryLimit, mean.deepBytes());
        const double from = double(i) / m_samples, to = double(i + 1) / m_samples;
        const Plan plan = makePlan(moment, threadCount(), partOf(progress, from, from));
        const KeptLight* kept = light.servedTo(moment, plan, partOf(progress, from, from));
        mean.add(scrim::render(moment, plan, partOf(progress, from, to), {}, kept));
        if (m_options.shown) m_options.shown([&] { return mean.soFar(i + 1); });
    }
    Frame frame = mean.take();
    if (light.kept()) account(*light.kept(), frame);
    return frame;
}

}  // namespace scrim
