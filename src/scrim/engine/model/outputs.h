// SPDX-License-Identifier: Apache-2.0
// The outputs of a sweep (AOVs): the beauty, which is number 0, and what is composited beside it; and how the floats of
// a shaded sample are laid out for them.
#pragma once

#include <scrim/scene/view_scene.h>

#include <vector>

namespace scrim {

/// An output beside the beauty. Of Layer::light one each for every light, of Layer::volume for every volume.
struct Output {
    Layer layer = Layer::light;
    int light = -1;  ///< of a light's: index into ViewScene::lights
    int place = -1;  ///< of a volume's: index into Scene::volumes

    bool operator==(const Output&) const = default;
};

/// Quads of floats, one for each output, and how much the sample hides of what lies behind it. Where extinction is grey
/// every quad is (S.rgb, -alpha). Where it is `coloured` quads are (S.rgb, 0), and one quad of opacities that all share
/// follows: (-alpha.rgb, -the least of the three). Compositing comes in these two kinds, whatever outputs there are.
///
/// Without `beauty` output 0 has no quad of its own: all that it consists of has one, and it is added up once the
/// pixels are done.
struct OutputLayout {
    int outputs = 1;  ///< with the beauty
    bool coloured = false;
    bool beauty = true;
    // Outputs that receive what is not a light's. 0: it goes into the beauty; -1: nowhere, nobody asks for it.
    int ambient = 0, emission = 0;
    int albedo = -1, depth = -1, motion = -1;
    /// Opacity of what is seen, in each channel: the picture's alpha where that is not all that hides; else -1. It is
    /// no layer, and the last of the outputs.
    int seen = -1;
    int beautyParts = 1;  ///< outputs [1, beautyParts) are parts of the beauty

    bool beautyAlone() const { return outputs == 1 && !coloured && beauty; }
    /// Which quad holds an output.
    int quadOf(int output) const { return beauty ? output : output - 1; }
    int outputQuads() const { return quadOf(outputs); }
    int quads() const { return outputQuads() + (coloured ? 1 : 0); }
    int floats() const { return 4 * quads(); }
};

/// What one sweep composites: only what it contributes to.
struct SweepOutputs {
    std::vector<Output> list;  ///< output i + 1
    OutputLayout layout;
    std::vector<int> ofLights;        ///< the output of each of the sweep's lights
    std::vector<int> ofVolumes = {};  ///< of each of ViewScene::volumes; 0: none
};

/// Of a sweep with these lights (indices into ViewScene::lights, one may occur more than once). `primary`: it owns
/// alpha, ambient light, emission, and what has scattered before of the lights `scattered`. Throws Error(usage) where
/// there are too many.
SweepOutputs chooseOutputs(const ViewScene& scene, bool coloured, bool primary, const std::vector<int>& lights,
                           const std::vector<int>& scattered = {});

/// Pictures beside the beauty that a frame of `scene` has.
std::size_t layerCount(const ViewScene& scene);

}  // namespace scrim
