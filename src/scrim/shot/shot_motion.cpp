// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/shot_motion.h>

#include <scrim/base/parallel.h>
#include <scrim/engine/sweep.h>
#include <scrim/scene/field_rays.h>
#include <scrim/scene/quality.h>

#include <algorithm>
#include <cmath>
#include <optional>
#include <utility>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

constexpr int kMostSamples = 128;

// The mean of frames of equal weight.
class MeanFrame {
  public:
    explicit MeanFrame(int count) : m_weight(1.0f / static_cast<float>(count)) {}

    void add(Frame frame) {
        if (m_mean.image.rgba.empty()) start(frame);
        addTo(m_mean.image.rgba, frame.image.rgba);
        for (std::size_t i = 0; i < m_mean.layers.size(); ++i) {
            if (m_mean.layers[i].layer == Layer::motion)
                addMotion(m_mean.layers[i].data, frame.layers[i].data, frame.image);
            else if (m_mean.layers[i].layer == Layer::depth)
                addDepth(m_mean.layers[i].data, frame.layers[i].data, frame.image);
            else
                addTo(m_mean.layers[i].data, frame.layers[i].data);
        }
        m_mean.work += frame.work;
        m_mean.times += frame.times;
        m_mean.scatterChange = std::max(m_mean.scatterChange, frame.scatterChange);
        m_mean.scatterConverged = m_mean.scatterConverged && frame.scatterConverged;
    }
    /// The mean of the `count` frames that were added so far.
    Image soFar(int count) const {
        Image image = m_mean.image;
        for (float& value : image.rgba) value /= m_weight * static_cast<float>(count);
        return image;
    }
    Frame take() {
        for (FrameLayer& layer : m_mean.layers)
            for (std::size_t i = 0; layer.layer == Layer::motion && i < layer.data.size(); ++i)
                if (const float alpha = m_mean.image.rgba[i / 2 * 4 + 3]; alpha > 0) layer.data[i] /= alpha;
        for (FrameLayer& layer : m_mean.layers)
            for (std::size_t i = 0; layer.layer == Layer::depth && i < m_alpha.size(); ++i)
                if (m_alpha[i] > 0) layer.data[2 * i + 1] /= m_alpha[i];
        return std::move(m_mean);
    }

  private:
    void start(const Frame& frame) {
        m_mean.image = emptyImage(frame.image.window);
        m_alpha.resize(frame.image.rgba.size() / 4);
        for (const FrameLayer& layer : frame.layers)
            m_mean.layers.push_back({layer.layer, layer.light, std::vector<float>(layer.data.size()), layer.volume});
    }
    void addTo(std::vector<float>& sum, const std::vector<float>& values) const {
        for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += m_weight * values[i];
    }
    // Weighted by opacity.
    void addMotion(std::vector<float>& sum, const std::vector<float>& motion, const Image& image) const {
        for (std::size_t i = 0; i < sum.size(); ++i) sum[i] += m_weight * image.rgba[i / 2 * 4 + 3] * motion[i];
    }
    // Both depths are 0 where nothing is visible.
    void addDepth(std::vector<float>& sum, const std::vector<float>& depth, const Image& image) {
        for (std::size_t i = 0; i < m_alpha.size(); ++i) {
            const float first = depth[2 * i], alpha = image.rgba[4 * i + 3];
            if (first == 0 && depth[2 * i + 1] == 0) continue;
            sum[2 * i] = m_alpha[i] > 0 ? std::min(sum[2 * i], first) : first;
            sum[2 * i + 1] += alpha * depth[2 * i + 1];
            m_alpha[i] += alpha;
        }
    }

    float m_weight;
    Frame m_mean;
    std::vector<float> m_alpha;  // summed over frames in which the pixel has a depth
};

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
    const double turn = glm::length(a.wsDirection - b.wsDirection) * radius;
    if (a.distant()) return a.slide ? turn + glm::distance(a.wsPosition, b.wsPosition) : turn;
    const double distance = std::max(glm::distance(ws.center(), a.wsPosition), 1e-6 * radius);
    return (a.spot() || a.slide ? turn : 0) +
           glm::distance(a.wsPosition, b.wsPosition) * std::min(2 * radius / distance, 4.0);
}

bool sameLook(const SceneVolume& a, const SceneVolume& b) {
    if (a.albedoGrid && a.albedoGrid->scale != b.albedoGrid->scale) return false;
    for (std::size_t i = 0; i < a.emission.size(); ++i)
        if (a.emission[i].scale != b.emission[i].scale || a.emission[i].ramp != b.emission[i].ramp) return false;
    return true;
}

}  // namespace

ShotMotion::ShotMotion(const LoadedShot& shot, const RenderOptions& options) : m_shot(shot), m_options(options) {
    if (!shot.scene.shutter) return;
    m_shutter = *shot.scene.shutter;
    m_moves =
        shot.scene.movesWithin || std::any_of(shot.fields.begin(), shot.fields.end(), [](const VolumeFields& fields) {
            return std::any_of(fields.velocity.begin(), fields.velocity.end(),
                               [](const auto& part) { return part && !part->empty(); });
        });
    if (!m_moves) return;
    m_path = longestPath();
    m_samples = shot.scene.dials.shutterSamples.value_or(samplesFor(m_path));
}

ViewScene ShotMotion::viewAt(double t, double lod, VolumesOf volumesOf, Moved moved) const {
    return m_shot.viewAt(t, m_options, lod, volumesOf, moved);
}

ViewScene ShotMotion::view() const {
    const double lod = m_shot.scene.dials.lod;
    ViewScene view = m_moves ? viewAt(middle(), lod, VolumesOf::picture, Moved::byVoxels)
                             : m_shot.view(m_options, lod, VolumesOf::picture);
    if (m_shot.scene.shutter) view.shutter = ViewShutter{m_shutter.open, m_shutter.close, m_samples, m_path, m_moves};
    return view;
}

ViewScene ShotMotion::truth() const {
    if (!m_moves) return m_shot.view(m_options, 0, VolumesOf::scene);
    ViewScene out = viewAt(middle(), 0, VolumesOf::scene, Moved::byVelocity);
    auto moments = std::make_shared<ViewMoments>();
    moments->open = m_shutter.open;
    moments->close = m_shutter.close;
    moments->path = m_path;
    moments->at = [this, base = std::make_shared<const ViewScene>(out)](double t) { return truthAt(t, *base); };
    out.moments = std::move(moments);
    return out;
}

// The view at `t`. It shares the fields of `base`, as many moments do, unless their look changes.
ViewScene ShotMotion::truthAt(double t, const ViewScene& base) const {
    const Scene at = m_shot.sceneAt(t), middle = m_shot.sceneAt(this->middle());
    for (std::size_t i = 0; i < at.volumes.size(); ++i)
        if (!sameLook(at.volumes[i], middle.volumes[i])) return viewAt(t, 0, VolumesOf::scene, Moved::byVelocity);
    ViewScene out = base;
    out.camera = at.camera;
    out.lights = at.lights;
    out.ambient = at.ambient;
    out.solids = solidsOf(at);
    for (ViewVolume& volume : out.volumes) {
        const auto i = static_cast<std::size_t>(
            std::find_if(at.volumes.begin(), at.volumes.end(), [&](const auto& v) { return v.name == volume.name; }) -
            at.volumes.begin());
        const SceneVolume& now = at.volumes[i];
        const auto place = [&](ViewField& field) { field.wsFromIs = now.wsFromAsset * field.field->wsFromIs; };
        volume.wsFromIs = now.wsFromAsset * volume.field->wsFromIs;
        volume.medium = now.medium;
        for (ViewField& field : volume.scatter) place(field);
        for (ViewEmission& emission : volume.emission) place(emission.field);
        volume.velocity = velocityOf(now, m_shot.fieldsAt(t)[i]);
    }
    return out;
}

double ShotMotion::longestPath() {
    constexpr int kMoments = 9;
    std::vector<Places> places;
    double wsWay = 0;  // displacement by velocities
    // For velocities with outliers: the displacement that counts, and the longest one.
    std::pair<double, double> outlier{0, 0};
    const ViewScene base = viewAt(middle(), 0, VolumesOf::scene, Moved::byVelocity);
    for (int i = 0; i < kMoments; ++i) {
        const double part = static_cast<double>(i) / (kMoments - 1);
        const ViewScene view = truthAt((1 - part) * m_shutter.open + part * m_shutter.close, base);
        places.push_back(pointsOf(view));
        if (i == 0 || i == kMoments - 1)
            for (const ViewVolume& volume : view.volumes)
                if (volume.velocity) {
                    const auto longest = [](const Bounds& ways) {
                        double most = 0;
                        for (const Vec3& way : ways.corners()) most = std::max(most, glm::length(way));
                        return most;
                    };
                    // A few fast voxels are no reason for a hundred renders.
                    const double usual = longest(volume.velocity->wsRange(usualMost)),
                                 most = longest(volume.velocity->wsRange());
                    wsWay = std::max(wsWay, usual);
                    if (most > usual && most > outlier.second) outlier = {usual, most};
                }
    }
    if (m_shutter.open < 0 && m_shutter.close > 0)
        wsWay *= (m_shutter.close - m_shutter.open) / std::max(-m_shutter.open, m_shutter.close);
    const Bounds box = boundsOf(places.front().ws);
    if (box.empty()) return 0;
    const double least = 1e-3 * glm::length(box.size());
    std::vector<double> paths(places.front().ws.size());
    double lights = 0;
    for (int i = 1; i < kMoments; ++i) {
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
    const double distance = glm::distance(glm::clamp(camera.wsPosition, box.lower, box.upper), camera.wsPosition);
    const double pixel = pixelAt(camera, std::max(distance, 0.25 * glm::length(box.size())));
    // No picture shows finer voxels than these one by one.
    constexpr double kFinest = 0.7;
    m_voxelPixels = std::max(voxelUnit(base) / pixel, kFinest);
    if (outlier.second > 0)
        notify(m_options.messages, Severity::warning,
               fmt::format("motion blur: fewer than one in 5,000 voxels of a velocity move up to {:.3g} pixels, all "
                           "others at most {:.3g}; the number of renders ignores these few",
                           outlier.second / pixel, outlier.first / pixel));
    const double most = 2.0 * (camera.resolution.x + camera.resolution.y);  // anything beyond this has left the picture
    return std::min(*std::max_element(paths.begin(), paths.end()) + (wsWay + lights) / pixel, most);
}

int ShotMotion::samplesFor(double path) const {
    const Scene& scene = m_shot.scene;
    // Measured error of the mean: about 1.2 % for steps of one voxel, s^2 times that for s voxels, and about a fifth of
    // a step for the hard edges of solids. Half of the promised error is reserved for it.
    constexpr double kOfVoxelSteps = 0.012, kOfHardSteps = 0.2, kShare = 0.5;
    const bool classified =
        std::any_of(scene.volumes.begin(), scene.volumes.end(), [](const auto& v) { return v.classified != nullptr; });
    const double error = scene.tolerance > 0 ? scene.tolerance : promisedError(scene.quality, classified);
    double wanted = std::max(path / m_voxelPixels / std::sqrt(kShare * error / kOfVoxelSteps), 4.0);
    if (m_shot.solids) wanted = std::max(wanted, kOfHardSteps / error);
    if (wanted > kMostSamples)
        notify(m_options.messages, Severity::warning,
               fmt::format("motion blur: the longest motion is {:.0f} pixels, which needs {} renders of the frame, but "
                           "{} are made; shutter_samples sets another number",
                           path, std::ceil(wanted), kMostSamples));
    return static_cast<int>(std::ceil(std::min(wanted, double(kMostSamples))));
}

Frame ShotMotion::render(const ViewScene& view, const ProgressSink& progress) const {
    MeanFrame mean(m_samples);
    for (int i = 0; i < m_samples; ++i) {
        const double t = m_shutter.open + (i + 0.5) / m_samples * (m_shutter.close - m_shutter.open);
        ViewScene moment = viewAt(t, view.dials.lod, VolumesOf::picture, Moved::byVoxels);
        moment.dials = view.dials;
        const double from = double(i) / m_samples, to = double(i + 1) / m_samples;
        const Plan plan = makePlan(moment, threadCount(), partOf(progress, from, from));
        mean.add(scrim::render(moment, plan, partOf(progress, from, to)));
        if (m_options.shown) m_options.shown([&] { return mean.soFar(i + 1); });
    }
    return mean.take();
}

}  // namespace scrim
