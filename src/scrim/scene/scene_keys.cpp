// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/scene_keys.h>

#include <scrim/base/error.h>
#include <scrim/image/exr.h>
#include <scrim/scene/layer_names.h>
#include <scrim/scene/quality.h>

#include <algorithm>

namespace scrim {

RenderKeys::RenderKeys()
    : Section("render", "[render]",
              "How accurate the picture is, and what that costs. A preset promises an error (relative RMSE against "
              "brute force) of 3, 1, 0.3 or 0.1 %, of classified volumes 5, 2, 1 or 0.5 %, and chooses 'texel' and "
              "'sheet_thickness' for it; whoever gives either is promised nothing."),
      quality(choice("quality", presetNames(), "The preset.").startingWith("standard")) {
    for (const DialInfo& dial : dialTable()) {
        const std::string unit = dial.unit.empty() ? "" : " (" + dial.unit + ")";
        other(dial.name, dial.allowed + unit, R"({"type":["number","string"]})", {}, dial.meaning)
            .unless(dial.chosen ? "chosen by the preset" : dial.defaultText);
    }
}

const Key& RenderKeys::dial(const std::string& name) const {
    return *std::find_if(keys().begin(), keys().end(), [&](const Key& key) { return key.name == name; });
}

OutputKeys::OutputKeys()
    : Section("output", "[output]",
              "The EXR: premultiplied, scene-linear, its data window cropped to what is not empty. Missing folders are "
              "made."),
      layers(other("layers", "a list of layers: " + choices(layerNames()), kStrings, {},
                   "Beside the beauty: light (one a light), ambient and emission add up to it, and so does volume "
                   "(one a volume); motion is in pixels until the next frame.")
                 .unless("[]")),
      compression(choice("compression", exrCompressions(), "Of the EXR.")) {}

const std::vector<const Section*>& sceneSections() {
    static const std::vector<const Section*> all{
        &keysOf<SceneKeys>(),    &keysOf<CameraKeys>(),     &keysOf<OrbitKeys>(),      &keysOf<VolumeKeys>(),
        &keysOf<FrameKeys>(),    &keysOf<TransformKeys>(),  &keysOf<DensityKeys>(),    &keysOf<VelocityKeys>(),
        &keysOf<MediumKeys>(),   &keysOf<AlbedoGridKeys>(), &keysOf<PhaseKeys>(),      &keysOf<OctavesKeys>(),
        &keysOf<EmissionKeys>(), &keysOf<BlackbodyKeys>(),  &keysOf<ClassifiedKeys>(), &keysOf<TransferKeys>(),
        &keysOf<MeshKeys>(),     &keysOf<LightKeys>(),      &keysOf<SlideKeys>(),      &keysOf<TextureKeys>(),
        &keysOf<AmbientKeys>(),  &keysOf<RenderKeys>(),     &keysOf<OutputKeys>(),     &keysOf<PreviewKeys>(),
        &keysOf<HoldoutKeys>(),  &keysOf<KeyedKeys>(),      &keysOf<ColourKeys>()};
    return all;
}

}  // namespace scrim
