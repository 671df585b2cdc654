// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/scene_keys.h>

#include <scrim/base/error.h>
#include <scrim/image/exr.h>
#include <scrim/scene/layer_names.h>
#include <scrim/scene/quality.h>

#include <algorithm>

namespace scrim {

RenderKeys::RenderKeys()
    : SectionOf(
          "render", "[render]",
          "The accuracy of the picture, and its cost. A preset promises an error (relative RMSE against brute "
          "force) of 3, 1, 0.3 or 0.1 %, or of 5, 2, 1 or 0.5 % for classified volumes, and chooses 'texel' and "
          "'sheet_thickness' for it. There is no promise if the scene gives either of these. Where light scatters "
          "more than once it promises 5, 2, 1 or 0.5 % in means over 4 x 4 pixels, and chooses 'scatter_cell' and "
          "'scatter_directions' if the scene does not."),
      quality(choice("quality", presetNames(), "The preset of the dials.").startingWith(Scene().quality)) {
    for (const DialInfo& dial : dialTable()) {
        const std::string unit = dial.unit.empty() ? "" : " (" + dial.unit + ")";
        other(dial.name, dial.allowed + unit, R"({"type":["number","string"]})", {}, dial.meaning)
            .unless(dial.chosen ? "chosen by the preset" : dial.defaultText);
    }
}

const Key& RenderKeys::dial(const std::string& name) const {
    return *std::find_if(keys().begin(), keys().end(), [&](const Key& key) { return key.name == name; });
}

FileKeys::FileKeys()
    : SectionOf("files", "[[output.files]]", "A further EXR of the same render, with layers of its own."),
      layers(other("layers", "a list of layers: " + choices(layerNames()), kStrings, {}, "The layers that it holds.")
                 .unless("[]")),
      compression(choice("compression", exrCompressions(), "Compression of the EXR.").unless("that of [output]")) {}

OutputKeys::OutputKeys()
    : SectionOf("output", "[output]",
                "The EXR: premultiplied, scene-linear, with its data window cropped to the pixels that are not empty. "
                "Missing folders are made."),
      layers(
          other(
              "layers", "a list of layers: " + choices(layerNames()), kStrings, {},
              "Layers beside the beauty. light (one for each light), ambient and emission add up to the beauty. So do "
              "volume (one for each volume, with its part of alpha), and direct and indirect, which is light that "
              "has scattered more than once; motion is in pixels until the next "
              "frame; cryptomatte holds mattes of the volumes by name; backdrop is what the beauty has besides of "
              "skies and meshes that are seen.")
              .unless("[]")),
      compression(choice("compression", exrCompressions(), "Compression of the EXR.")) {}

const std::vector<const Section*>& sceneSections() {
    static const std::vector<const Section*> all{
        &keysOf<SceneKeys>(),    &keysOf<CameraKeys>(),   &keysOf<OrbitKeys>(),      &keysOf<VolumeKeys>(),
        &keysOf<FrameKeys>(),    &keysOf<CombineKeys>(),  &keysOf<TransformKeys>(),  &keysOf<DensityKeys>(),
        &keysOf<RemapKeys>(),    &keysOf<MaskKeys>(),     &keysOf<NoiseKeys>(),      &keysOf<VelocityKeys>(),
        &keysOf<PointsKeys>(),   &keysOf<MediumKeys>(),   &keysOf<AlbedoGridKeys>(), &keysOf<PhaseKeys>(),
        &keysOf<OctavesKeys>(),  &keysOf<EmissionKeys>(), &keysOf<BlackbodyKeys>(),  &keysOf<ClassifiedKeys>(),
        &keysOf<TransferKeys>(), &keysOf<MeshKeys>(),     &keysOf<LightKeys>(),      &keysOf<SlideKeys>(),
        &keysOf<TextureKeys>(),  &keysOf<SkyKeys>(),      &keysOf<AmbientKeys>(),    &keysOf<RenderKeys>(),
        &keysOf<OutputKeys>(),   &keysOf<FileKeys>(),     &keysOf<PreviewKeys>(),    &keysOf<HoldoutKeys>(),
        &keysOf<KeyedKeys>(),    &keysOf<ColourKeys>()};
    return all;
}

}  // namespace scrim
