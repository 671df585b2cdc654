// SPDX-License-Identifier: Apache-2.0
// The outputs of a sweep (AOVs): the beauty, which is number 0, and the outputs that are composited beside it; and the
// layout of a shaded sample's floats.
#pragma once

#include <scrim/scene/view_scene.h>

#include <vector>

namespace scrim {

/// An output beside the beauty. There is one of Layer::light for every light, and one of Layer::volume for every
/// volume.
struct Output {
    Layer layer = Layer::light;
    int light = -1;  ///< for lights: index into ViewScene::lights
    int place = -1;  ///< for volumes: index into Scene::volumes

    bool operator==(const Output&) const = default;
};

/// A sample consists of quads of floats: one for each output, with the sample's opacity. With grey extinction, every
/// quad is (S.rgb, -alpha). With `coloured` extinction, quads are (S.rgb, 0), followed by one quad of opacities that
/// all share: (-alpha.rgb, -the least of the three). Compositing has only these two forms, whatever the outputs are.
///
/// Without `beauty`, output 0 has no quad of its own: all of its parts have one, and they are added up at the end.
struct OutputLayout {
    int outputs = 1;  ///< including the beauty
    bool coloured = false;
    bool beauty = true;
    // The outputs that receive light which belongs to no light. 0: the beauty; -1: none, since nobody asks for it.
    int ambient = 0, emission = 0;
    int albedo = -1, depth = -1, motion = -1;
    /// The output for the opacity of what is visible, in each channel. It is the picture's alpha if something hides
    /// without being visible; else -1. It is not a layer, and is the last output.
    int seen = -1;
    int beautyParts = 1;  ///< outputs [1, beautyParts) are parts of the beauty

    bool beautyAlone() const { return outputs == 1 && !coloured && beauty; }
    /// The index of an output's quad.
    int quadOf(int output) const { return beauty ? output : output - 1; }
    int outputQuads() const { return quadOf(outputs); }
    int quads() const { return outputQuads() + (coloured ? 1 : 0); }
    int floats() const { return 4 * quads(); }
};

/// The outputs that one sweep composites: only those that it contributes to.
struct SweepOutputs {
    std::vector<Output> list;  ///< element i is output i + 1
    OutputLayout layout;
    std::vector<int> ofLights;        ///< the output of each of the sweep's lights
    std::vector<int> ofVolumes = {};  ///< the output of each of ViewScene::volumes; 0: none
};

/// The outputs of a sweep with these lights (indices into ViewScene::lights, possibly repeated). `primary`: the sweep
/// owns alpha, ambient light, emission, and multiply scattered light from the lights `scattered`. Throws Error(usage)
/// if there are too many.
SweepOutputs chooseOutputs(const ViewScene& scene, bool coloured, bool primary, const std::vector<int>& lights,
                           const std::vector<int>& scattered = {});

/// The number of pictures beside the beauty in a frame of `scene`.
std::size_t layerCount(const ViewScene& scene);

}  // namespace scrim
