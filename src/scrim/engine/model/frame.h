// SPDX-License-Identifier: Apache-2.0
// What a render yields: the picture, and counts of the work it took.
#pragma once

#include <scrim/image/deep_image.h>
#include <scrim/image/image.h>
#include <scrim/scene/scene.h>

#include <cstdint>
#include <optional>
#include <vector>

namespace scrim {

/// Counts of what shading did. Passes over a tile count themselves, once a tile, so that a pass that is not run is seen
/// to be absent, and loops over samples know nothing of it.
struct ShadeWork {
    std::uint64_t samples = 0;       ///< shaded: texels, or points where pixels' rays meet sheets
    std::uint64_t lightLookups = 0;  ///< light and sample pairs
    std::uint64_t slideLookups = 0;
    std::uint64_t phases = 0;        ///< evaluations of a phase function that is not isotropic
    std::uint64_t octaves = 0;       ///< light and sample pairs of octaves beyond the first
    std::uint64_t gradients = 0;     ///< normals of classified volumes
    std::uint64_t emissions = 0;     ///< samples of emission
    std::uint64_t ambients = 0;      ///< samples of ambient light
    std::uint64_t scattered = 0;     ///< samples of light that scattered before
    std::uint64_t exponentials = 0;  ///< of optical depths

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
    std::uint64_t voxelsFed = 0;     ///< voxels of value > 0, once a sweep and field
    std::uint64_t footprints = 0;    ///< voxel and sheet pairs splatted
    std::uint64_t texelsShaded = 0;  ///< samples of `shade` that are texels, and not where pixels' rays meet sheets
    std::uint64_t lightSamples = 0;  ///< cells of shadow buffers walked
    std::uint64_t pixelSheets = 0;   ///< pixel and sheet pairs composited
    std::uint64_t layerSamples = 0;  ///< the same of quads beyond the first: more pictures, coloured opacities
    std::uint64_t deepSamples = 0;   ///< ray and sheet pairs kept for a deep picture
    std::uint64_t sheets = 0;
    std::uint64_t solidRays = 0;   ///< traced to solids, for the eye and for lights
    std::uint64_t caughtRays = 0;  ///< marched from solids to lights
    std::uint64_t scatterSweeps = 0;      ///< of all ordinates through the finest cells
    std::uint64_t scatterDirections = 0;  ///< cells and ordinates passed, of all sizes of cells
    ShadeWork shade;

    /// Address space of buffers, of the sweep that takes most.
    struct Bytes {
        std::uint64_t fields = 0;   ///< sheets of fields, with the tables of footprints
        std::uint64_t shadows = 0;  ///< shadow buffers, with what lights splat for themselves
        std::uint64_t shaded = 0;   ///< sheets of shaded texels
        std::uint64_t picture = 0;  ///< pixels on the way
        std::uint64_t deep = 0;     ///< samples of a deep picture
        std::uint64_t scattered = 0;  ///< light that scatters more than once

        std::uint64_t total() const { return fields + shadows + shaded + picture + deep + scattered; }
        bool operator==(const Bytes&) const = default;
    } bytes;

    /// Counts add up; bytes are those of whichever takes more.
    RenderWork& operator+=(const RenderWork& o);
    bool operator==(const RenderWork&) const = default;
};

/// Seconds spent in each stage, wall clock.
struct StageTimes {
    double prepare = 0, scatter = 0, splat = 0, attenuate = 0, shade = 0, composite = 0;

    StageTimes& operator+=(const StageTimes& o);
};

/// A picture beside the beauty, of the same window.
struct FrameLayer {
    Layer layer = Layer::light;
    int light = -1;  ///< of a light's or shadow's: index into ViewScene::lights
    /// light, ambient, emission, volume: the part of the beauty, RGB. shadow: see catchShadows, RGB. albedo: times what
    /// it hides, RGB. transmittance: RGB. depth: along the viewing axis, world units, of where the first thing visible
    /// begins and of the mean over what is seen; 0, 0 where nothing is. motion: the mean over what is seen, by opacity,
    /// of the way until the next frame, in pixels to the right and up; 0, 0 where nothing is.
    std::vector<float> data;
    int volume = -1;  ///< of a volume's: index into Scene::volumes

    std::size_t channels() const { return layer == Layer::depth || layer == Layer::motion ? 2 : 3; }
};

struct Frame {
    Image image;  ///< premultiplied, scene-linear, working space
    /// As ViewScene::layers has them; of lights and shadows one each, in the scene's order.
    std::vector<FrameLayer> layers;
    std::optional<DeepImage> deep;  ///< where it is asked for: over the image's window, in the working space
    /// What a further sweep would have changed of light that scatters more than once, relative; 0: there is none.
    double scatterChange = 0;
    bool scatterConverged = true;  ///< is that as little as scatter_error asks for?
    RenderWork work;
    StageTimes times;
};

}  // namespace scrim
