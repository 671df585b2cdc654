// SPDX-License-Identifier: Apache-2.0
// A scene at one frame as a sweep needs it: fields are in memory, no file is left to read and no name to resolve.
#pragma once

#include <scrim/geometry/bounds.h>
#include <scrim/geometry/camera.h>
#include <scrim/geometry/half_space.h>
#include <scrim/image/depth_picture.h>
#include <scrim/image/image.h>
#include <scrim/scene/light.h>
#include <scrim/scene/dials.h>
#include <scrim/scene/scene.h>
#include <scrim/scene/classified.h>
#include <scrim/scene/medium.h>
#include <scrim/solid/solids.h>
#include <scrim/volume/sparse_field.h>

#include <array>
#include <cstddef>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace scrim {

/// A field of a volume.
struct ViewField {
    std::shared_ptr<const SparseField> field;
    Mat4 wsFromIs{1.0};
    std::optional<Kernel> kernel = {};  ///< reconstructs the field; none: Dials::kernel
};

/// Radiance per world unit is the field's value times `color`.
struct ViewEmission {
    ViewField field;
    Rgb color{1};
    bool ofBalls = false;  ///< the eye sees it at ViewVolume::balls, and its voxels only light volumes
};

/// Points that the eye sees as balls, or as discs that face it, in place of the voxels of a medium, which make shadows
/// and scattered light all the same. Fields are lists of points (PointRaster::list), all on one lattice.
struct ViewBalls {
    std::array<std::shared_ptr<const SparseField>, 3> place;  ///< x, y and z on that lattice's unit box
    std::shared_ptr<const SparseField> radius;                ///< in the asset's world; 0: there is no such point
    /// Within a ball: times medium.densityScale, extinction. A disc has this opacity, or 1 if it is
    /// more, and sends out what a world unit of its emission does.
    std::shared_ptr<const SparseField> density;
    std::vector<std::shared_ptr<const SparseField>> scatter = {};   ///< as ViewVolume::scatter
    std::vector<ViewEmission> emission = {};                        ///< within a ball; places do not count
    std::vector<std::shared_ptr<const SparseField>> velocity = {};  ///< as ViewVelocity::parts, or none
    bool discs = false;
    std::vector<HalfSpace> clip = {};  ///< centres beyond these faces are left out; in the asset's world
    /// At the begin and the end of the moment that is seen: the map from the asset's world to the scene's, and the time
    /// by which velocities have moved the points in the asset's. A point is drawn along its way.
    std::array<Mat4, 2> wsFromAsset{Mat4(1.0), Mat4(1.0)};
    std::array<double, 2> time{0, 0};

    /// The number of points that lists may hold, those without radius included.
    std::size_t count() const {
        return radius->empty() ? 0 : (std::size_t(radius->blockOrigins.back().x) / kBlockEdge + 1) * kBlockVoxels;
    }
};

/// Velocities by which the reference, and nothing else, moves fields: at x it sees what the fields
/// hold at x - wsPath velocity(x). The renderer gets fields that were moved beforehand.
struct ViewVelocity {
    /// For each of x, y and z the field of positive and the field of negative values, as GridPart has them.
    std::vector<ViewField> parts;
    Mat3 wsPath{0};  ///< converts a velocity to a displacement in world space

    /// World-space box around all displacements. `most` gives the largest value of a part that counts.
    Bounds wsRange(const std::function<double(const SparseField&)>& most = [](const SparseField& part) {
        return double(part.maxValue);
    }) const;
};

/// How a volume moves until the next frame, for the layer `motion`.
struct VolumeMotion {
    /// Maps the volume's world space at this frame to that at the next one: the motion as a whole.
    Mat4 wsNextFromWs{1.0};
    /// For each of x, y and z: density * (velocity - least), on the density's lattice. Empty: no
    /// velocity, or the volume is seen as balls, which have their own.
    std::vector<ViewField> flow = {};
    Vec3 least{0}, most{0};   ///< the grid's smallest and largest velocity
    Mat3 wsPerVelocity{0.0};  ///< converts a velocity to a displacement per frame in world space
};

struct ViewVolume {
    std::string name;
    std::shared_ptr<const SparseField> field;
    Mat4 wsFromIs{1.0};  ///< the field's own map followed by the volume's transform
    Medium medium;
    std::shared_ptr<const Classified> classified = nullptr;  ///< shades the volume in place of `medium`
    /// A classified volume ends at their faces, within voxels. The fields of media have been cut already.
    std::vector<HalfSpace> wsClip = {};
    /// Where the albedo is a grid: density times albedo for each of red, green and blue, on the lattice of `field`. The
    /// scattering coefficient is then this times medium.densityScale, and medium.albedo does not count.
    std::vector<ViewField> scatter = {};
    std::vector<ViewEmission> emission = {};  ///< sources of emission; they add up
    std::vector<bool> lights = {};   ///< for each light of the scene: whether it lights this volume; empty: all do
    std::vector<bool> shadows = {};  ///< likewise: whether the volume casts shadows in it; empty: in all
    std::shared_ptr<const ViewVelocity> velocity = nullptr;  ///< null: the fields are already where they are to be seen
    bool holdout = false;  ///< hides what is behind it and casts shadows, but adds neither colour nor alpha
    std::shared_ptr<const VolumeMotion> motion = nullptr;  ///< null: the volume stands still
    std::optional<Kernel> kernel = {};                     ///< reconstructs all its fields; none: Dials::kernel
    std::shared_ptr<const ViewBalls> balls = nullptr;      ///< null: the eye sees the fields
    int place = -1;  ///< index into Scene::volumes, some of which may be culled; -1: its index in this scene
};

/// True if light scatters more than once in the volume. What a held-out volume scatters and emits
/// reaches the others, too; only the eye does not see it.
inline bool scattersFully(const ViewVolume& volume) {
    const bool full = volume.classified ? volume.classified->scatters : volume.medium.scattering == Scattering::full;
    return full && !volume.field->empty();
}

/// A deep picture that is written beside the flat one.
struct ViewDeep {
    double tolerance = 0.01;  ///< largest change by merging samples: of alpha, and of a colour relative to the pixel's
};

struct ViewScene;

/// One of the pictures that a picture with motion blur or depth of field is the mean of.
struct Moment {
    double time = 0;  ///< frames relative to the scene's frame
    Vec2 lens{0};     ///< the place on the lens, in its radii
    double span = 0;  ///< the time that it stands for, around `time`, frames
};

/// What the camera sees moment by moment. Only checks of the picture need it.
struct ViewMoments {
    double open = 0, close = 0;  ///< frames relative to the scene's frame
    double path = 0;             ///< the longest way of anything from moment to moment, pixels
    bool lens = false;           ///< moments differ by places on the lens, too
    /// The scene at a moment, with the fields where the files have them.
    std::function<ViewScene(const Moment&)> at;
};

/// The moments that the picture averages, as the plan reports them.
struct ViewShutter {
    double open = 0, close = 0;  ///< frames relative to the scene's frame
    int samples = 1;             ///< number of renders
    double path = 0;             ///< longest path that anything travels while the shutter is open, pixels
    bool moves = false;          ///< something moves
};

/// The lens of the camera, as the plan reports it.
struct ViewLens {
    Lens lens;
    int samples = 1;  ///< number of renders
    double blur = 0;  ///< largest diameter of the picture of a point, pixels
};

struct ViewScene {
    Camera camera;
    PixelWindow region;   ///< the pixels to render, within the display window or beyond it (overscan)
    PixelWindow picture;  ///< the whole picture that `region` is a crop of; empty: region and display window
    std::vector<ViewVolume> volumes;
    std::vector<Light> lights;
    std::shared_ptr<const Solids> solids = nullptr;        ///< null: there are no solids
    std::shared_ptr<const DepthPicture> depths = nullptr;  ///< hides what is behind it; null: none
    Rgb ambient{0};                                        ///< radiance of an unshadowed environment
    Dials dials;
    /// Culled volumes with the reason why, for the plan: (name, reason).
    std::vector<std::pair<std::string, std::string>> culled;
    std::vector<Layer> layers;  ///< to render beside the beauty
    /// The camera where the moment that the picture shows begins and ends, for balls; none: it stands still.
    std::optional<std::array<Camera, 2>> span = {};
    std::optional<Camera> nextCamera;  ///< the camera one frame later, for the layer `motion`; none: it stands still
    std::size_t volumeCount = 0;       ///< number of volumes of the scene, culled ones included; 0: as many as are here
    std::optional<ViewDeep> deep;      ///< none: the flat picture alone
    std::optional<ViewShutter> shutter;  ///< none: the scene has no shutter
    std::optional<ViewLens> lens;        ///< none: everything is sharp
    /// Null: the picture shows one moment, which is this scene. Otherwise the picture is the mean
    /// over moments, and this scene is one of them.
    std::shared_ptr<const ViewMoments> moments;
    std::shared_ptr<const SceneLines> lines;  ///< the places of keys in the scene's text; may be null
    std::size_t memoryLimit = 0;              ///< bytes that buffers may take; 0: no limit
};

bool wants(const ViewScene& scene, Layer layer);

/// Whether any volume is classified, emits, or scatters light more than once.
bool anyClassified(const ViewScene& scene);
bool anyEmits(const ViewScene& scene);
bool anyScattersFully(const ViewScene& scene);

/// True if extinction is the same in all colours, and if what scatters more than once is, too.
bool greyExtinction(const ViewScene& scene);
bool greyScattering(const ViewScene& scene);

/// True if solids stop light.
bool solidsBlock(const ViewScene& scene);

/// True if solids block only lights without extent, and few of these: the edges of their shadows
/// are sharp, and few enough to be resolved by pixels.
bool sharpShadows(const ViewScene& scene);
/// True if solids that stop light send back all colours alike.
bool greySolids(const ViewScene& scene);

/// The light whose layer shows `light`: the first one of its group, or itself. Both are indices
/// into ViewScene::lights.
int lightOfLayer(const ViewScene& scene, int light);

/// The index into Scene::volumes of `volumes[i]` (its `place`, or `i` where that is -1), and the
/// number of all volumes of the scene, culled ones included.
int placeOf(const ViewScene& scene, std::size_t i);
std::size_t placesOf(const ViewScene& scene);

/// The field of a volume's density.
inline ViewField densityOf(const ViewVolume& volume) {
    return {volume.field, volume.wsFromIs, volume.kernel};
}

/// The non-empty fields of a volume, density and emission, each on its own lattice.
std::vector<ViewField> fieldsOf(const ViewVolume& volume);

/// Whether a light of the scene is among `lights`, which are as ViewVolume::lights and ViewVolume::shadows.
inline bool litBy(const std::vector<bool>& lights, std::size_t light) {
    return lights.empty() || lights[light];
}

/// World-space corners of the boxes around a volume's fields, the kernels' reach included: eight
/// for each field that is not empty. `kernel`: that of fields which have none of their own.
std::vector<Vec3> wsCorners(const ViewVolume& volume, Kernel kernel);

/// The largest radius of any field's kernel, voxels.
double kernelRadius(const ViewScene& scene);

/// World-space corners of the boxes around all volumes, the kernels' reach included.
std::vector<Vec3> wsCorners(const ViewScene& scene);

/// The box around these corners.
Bounds wsBounds(const ViewScene& scene);

/// The size of that box without what is empty: along each axis the world units in which there is a block of any field.
/// Where a quarter is empty at most, as between puffs of smoke, the size of the box.
Vec3 wsOccupiedSize(const ViewScene& scene);

/// True if alpha is not simply 1 - transmittance, because something hides without showing: a volume
/// is held out, or a deep holdout picture is partly transparent.
bool holdsOut(const ViewScene& scene);

/// The pixels of the whole picture, overscan included.
PixelWindow wholePicture(const ViewScene& scene);

/// The smallest voxel edge of all grids in world units, which is the unit of the dials; 1 where all volumes are empty.
double voxelUnit(const ViewScene& scene);
/// That of the grids of a volume; infinity if it is empty.
double voxelUnit(const ViewVolume& volume);

}  // namespace scrim
