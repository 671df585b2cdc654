// SPDX-License-Identifier: Apache-2.0
// The result of a render: the picture, and counts of the work it took.
#pragma once

#include <scrim/image/deep_image.h>
#include <scrim/image/image.h>
#include <scrim/scene/scene.h>

#include <cstdint>
#include <optional>
#include <vector>

namespace scrim {

/// Counts of the work of shading. Each pass over a tile counts itself once per tile. Thus a pass
/// that is not run shows as 0, and loops over samples do not count.
struct ShadeWork {
    std::uint64_t samples = 0;       ///< shaded samples: texels, or points where pixels' rays meet sheets
    std::uint64_t lightLookups = 0;  ///< light and sample pairs
    std::uint64_t slideLookups = 0;
    std::uint64_t phases = 0;        ///< evaluations of a phase function that is not isotropic
    std::uint64_t octaves = 0;       ///< light and sample pairs for octaves beyond the first
    std::uint64_t gradients = 0;     ///< normals of classified volumes
    std::uint64_t emissions = 0;     ///< samples of emission
    std::uint64_t ambients = 0;      ///< samples of ambient light
    std::uint64_t scattered = 0;     ///< samples of multiply scattered light
    std::uint64_t exponentials = 0;  ///< exponentials of optical depths

    ShadeWork& operator+=(const ShadeWork& o) {
        samples += o.samples;
        lightLookups += o.lightLookups;
        slideLookups += o.slideLookups;
        phases += o.phases;
        octaves += o.octaves;
        gradients += o.gradients;
        emissions += o.emissions;
        ambients += o.ambients;
        scattered += o.scattered;
        exponentials += o.exponentials;
        return *this;
    }
    bool operator==(const ShadeWork&) const = default;
};

/// Counts of work done, not of time: equal scenes give equal numbers on every machine.
struct RenderWork {
    std::uint64_t voxelsFed = 0;   ///< voxels of value > 0, counted once for each sweep and field
    std::uint64_t footprints = 0;  ///< voxel and sheet pairs splatted
    /// Samples of `shade` that are texels, as opposed to points where pixels' rays meet sheets.
    std::uint64_t texelsShaded = 0;
    std::uint64_t lightSamples = 0;  ///< cells of shadow buffers walked
    std::uint64_t pixelSheets = 0;   ///< pixel and sheet pairs composited
    /// Pixel and sheet pairs for quads beyond the first: further pictures, coloured opacities.
    std::uint64_t layerSamples = 0;
    std::uint64_t deepSamples = 0;  ///< ray and sheet pairs kept for a deep picture
    std::uint64_t sheets = 0;
    std::uint64_t solidRays = 0;          ///< rays traced to solids, for the eye and for lights
    std::uint64_t caughtRays = 0;         ///< rays marched from solids to lights
    std::uint64_t cellDirections = 0;     ///< pairs of cells and points or directions of lights that are kept on them
    std::uint64_t scatterSweeps = 0;      ///< sweeps of all ordinates through the finest cells
    std::uint64_t scatterDirections = 0;  ///< pairs of cells and ordinates passed, over all sizes of cells
    ShadeWork shade;

    /// Address space of buffers, bytes, in the sweep that takes most.
    struct Bytes {
        std::uint64_t fields = 0;     ///< sheets of fields, with the footprint tables
        std::uint64_t shadows = 0;    ///< shadow buffers, with the sheets that lights splat for themselves
        std::uint64_t shaded = 0;     ///< sheets of shaded texels
        std::uint64_t picture = 0;    ///< pixels during the sweep
        std::uint64_t deep = 0;       ///< samples of a deep picture
        std::uint64_t scattered = 0;  ///< multiply scattered light

        std::uint64_t total() const { return fields + shadows + shaded + picture + deep + scattered; }
        bool operator==(const Bytes&) const = default;
    } bytes;

    /// Adds counts; of bytes, the larger numbers are kept.
    RenderWork& operator+=(const RenderWork& o);
    bool operator==(const RenderWork&) const = default;
};

/// Seconds of wall clock time spent in each stage.
struct StageTimes {
    double prepare = 0, scatter = 0, splat = 0, attenuate = 0, shade = 0, composite = 0;

    StageTimes& operator+=(const StageTimes& o);
};

/// A picture beside the beauty, with the same window.
struct FrameLayer {
    Layer layer = Layer::light;
    int light = -1;  ///< for layers of lights and shadows: index into ViewScene::lights, of the first of a group
    /// The values by layer. light, ambient, emission, volume: that part of the beauty, RGB. shadow: see catchShadows,
    /// RGB. albedo: multiplied by opacity, RGB. transmittance: RGB. depth: along the viewing axis, world units; where
    /// the first visible thing begins, and the mean over everything visible; 0, 0 in empty pixels. motion: the mean, by
    /// opacity, of the displacement until the next frame, in pixels to the right and up; 0, 0 in empty pixels.
    /// cryptomatte: the part of alpha that is a volume's.
    std::vector<float> data;
    int volume = -1;  ///< for layers of volumes and their opacities: index into Scene::volumes

    std::size_t channels() const {
        return layer == Layer::cryptomatte ? 1 : layer == Layer::depth || layer == Layer::motion ? 2 : 3;
    }
};

struct Frame {
    Image image;  ///< premultiplied, scene-linear, working space
    /// In the order of ViewScene::layers; one for each light, group, shadow or volume, in the scene's order.
    std::vector<FrameLayer> layers;
    std::optional<DeepImage> deep;  ///< where requested; over the image's window, in the working space
    /// Estimated relative error of the iteration for multiply scattered light; 0: there is no such light.
    double scatterError = 0;
    bool scatterConverged = true;  ///< `scatterError` is at most scatter_error
    RenderWork work;
    StageTimes times;
};

}  // namespace scrim
