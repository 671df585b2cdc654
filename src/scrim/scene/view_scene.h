// SPDX-License-Identifier: Apache-2.0
// What a sweep needs to know of a scene at one frame: fields in memory, no files, no names to resolve.
#pragma once

#include <scrim/geometry/bounds.h>
#include <scrim/geometry/camera.h>
#include <scrim/image/depth_picture.h>
#include <scrim/image/image.h>
#include <scrim/scene/light.h>
#include <scrim/scene/dials.h>
#include <scrim/scene/scene.h>
#include <scrim/scene/classified.h>
#include <scrim/scene/medium.h>
#include <scrim/solid/solids.h>
#include <scrim/volume/sparse_field.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace scrim {

/// A further field of a volume.
struct ViewField {
    std::shared_ptr<const SparseField> field;
    Mat4 wsFromIs{1.0};
};

/// Radiance per world unit = field value times `color`.
struct ViewEmission {
    ViewField field;
    Rgb color{1};
};

/// What the reference alone takes fields from elsewhere by: at x it sees what they hold at x - wsPath velocity(x). What
/// is rendered has fields that were moved before.
struct ViewVelocity {
    std::vector<ViewField> parts;  ///< of x, y and z the parts above and below 0, as GridPart has them
    Mat3 wsPath{0};                ///< velocity to way, world space

    /// World space box around all ways; `most`: the largest value of a part that counts.
    Bounds wsRange(const std::function<double(const SparseField&)>& most = [](const SparseField& part) {
        return double(part.maxValue);
    }) const;
};

/// Where a volume goes until the next frame, for the layer `motion`.
struct VolumeMotion {
    Mat4 wsNextFromWs{1.0};  ///< takes it as a whole
    /// Density times (velocity - least), of x, y and z, on the lattice of the density; none: no velocity.
    std::vector<ViewField> flow = {};
    Vec3 least{0}, most{0};   ///< of the grid's velocity
    Mat3 wsPerVelocity{0.0};  ///< velocity to way in a frame, world space
};

struct ViewVolume {
    std::string name;
    std::shared_ptr<const SparseField> field;
    Mat4 wsFromIs{1.0};  ///< the field's own map followed by the volume's transform
    Medium medium;
    std::shared_ptr<const Classified> classified = nullptr;  ///< shaded so instead of as a medium
    /// Where the albedo is a grid: of red, green and blue the density times the albedo, on the lattice of `field`. What
    /// is scattered is this times medium.densityScale; medium.albedo does not count.
    std::vector<ViewField> scatter = {};
    std::vector<ViewEmission> emission = {};  ///< they add up
    std::vector<bool> lights = {};            ///< for each light of the scene: does it light this volume? Empty: all do
    std::shared_ptr<const ViewVelocity> velocity = nullptr;  ///< null: the fields are where they are to be seen
    bool holdout = false;                                    ///< hides and shadows, and adds neither colour nor alpha
    std::shared_ptr<const VolumeMotion> motion = nullptr;    ///< null: it stands still
    int place = -1;  ///< index into Scene::volumes, some of which may be culled; -1: its index here
};

/// Does the volume's medium scatter light more than once?
inline bool scattersFully(const ViewVolume& volume) {
    return volume.medium.scattering == Scattering::full && !volume.holdout && !volume.classified &&
           !volume.field->empty();
}

/// A deep picture beside the flat one.
struct ViewDeep {
    double tolerance = 0.01;  ///< of merging samples: of alpha, and of colour as a part of the pixel's
};

struct ViewScene;

/// What is seen while a shutter is open, moment by moment: only a check of the picture needs to know.
struct ViewMoments {
    double open = 0, close = 0;           ///< frames about the frame
    double path = 0;                      ///< the longest way that anything goes meanwhile, pixels
    std::function<ViewScene(double)> at;  ///< the scene so many frames about the frame, fields where files have them
};

/// What the picture is the mean of, for the plan.
struct ViewShutter {
    double open = 0, close = 0;  ///< frames about the frame
    int samples = 1;             ///< renders
    double path = 0;             ///< the longest way that anything goes meanwhile, pixels
    bool moves = false;          ///< does anything?
};

struct ViewScene {
    Camera camera;
    PixelWindow region;   ///< the pixels to render, within the display window or beyond it (overscan)
    PixelWindow picture;  ///< the whole picture that `region` is a crop of; empty: region and display window
    std::vector<ViewVolume> volumes;
    std::vector<Light> lights;
    std::shared_ptr<const Solids> solids = nullptr;        ///< null: there are none
    std::shared_ptr<const DepthPicture> depths = nullptr;  ///< hides what is behind it; null: there is none
    Rgb ambient{0};                                        ///< radiance of an unshadowed environment
    Dials dials;
    /// Volumes that are culled, and why: names and reasons, for the plan.
    std::vector<std::pair<std::string, std::string>> culled;
    std::vector<Layer> layers;           ///< to render beside the beauty
    std::optional<Camera> nextCamera;    ///< a frame later, for the layer `motion`; none: it stands still
    std::size_t volumeCount = 0;         ///< of the scene's volumes, culled ones too; 0: those that are here
    std::optional<ViewDeep> deep;        ///< none: the flat picture alone
    std::optional<ViewShutter> shutter;  ///< none: the scene has no shutter
    /// Null: the picture is that of a moment, which is this scene. Else the mean over moments, of which this is one.
    std::shared_ptr<const ViewMoments> moments;
    std::shared_ptr<const SceneLines> lines;  ///< where the scene's text says what; or null
    std::size_t memoryLimit = 0;              ///< bytes that buffers may take; 0: no limit
};

bool wants(const ViewScene& scene, Layer layer);

/// The volume of the scene's that `volumes[i]` is, of all that there are.
int placeOf(const ViewScene& scene, std::size_t i);
std::size_t placesOf(const ViewScene& scene);

/// The fields of a volume that are not empty, each on a lattice of its own: density and emission.
std::vector<ViewField> fieldsOf(const ViewVolume& volume);

/// World-space corners of a volume's boxes, kernels included; eight a field that is not empty.
std::vector<Vec3> wsCorners(const ViewVolume& volume, Kernel kernel);

/// World-space corners of all volumes' boxes, kernels included.
std::vector<Vec3> wsCorners(const ViewScene& scene);

/// Is there more to what hides than what shows? Then alpha is not what transmittance leaves: a volume is held out, or a
/// deep picture lets a part through.
bool holdsOut(const ViewScene& scene);

/// The pixels of the whole picture, overscan included.
PixelWindow wholePicture(const ViewScene& scene);

/// The smallest edge of the finest grid, world units: the unit of the dials. 1 where all volumes are empty.
double voxelUnit(const ViewScene& scene);

}  // namespace scrim
