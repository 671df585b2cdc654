// SPDX-License-Identifier: Apache-2.0
// What a ShotFrame holds, and how it becomes files.
#pragma once

#include <scrim/engine/model/frame.h>
#include <scrim/image/colour.h>
#include <scrim/image/picture_module.h>
#include <scrim/scene/scene.h>
#include <scrim/shot/shot_frame.h>

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

namespace scrim {

struct ShotFrame::Content {
    Scene scene;
    std::string sceneToml;  ///< for the metadata; "": built in code
    ColourConfig colour;
    Image image;                    ///< in the working space
    std::vector<Layer> kinds = {};  ///< of `layers`
    std::vector<ShotLayer> layers = {};
    std::optional<DeepImage> deep = {};  ///< where the scene asks for one; in the working space
    ShotReport report = {};
    bool skipped = false;
    double previewExposure = 0;  ///< stops
};

/// Takes the picture and the layers of `frame`. Throws Error(render) where any of it is infinite or no number.
void takeFrame(ShotFrame::Content& content, Frame frame);

/// Writes an OpenEXR file. Returns how many values were clamped. Throws Error.
std::size_t writeFrame(const ShotFrame::Content& content, const std::string& path);

/// Writes the deep picture, which there must be. Returns how many values were clamped. Throws Error.
std::size_t writeFrameDeep(const ShotFrame::Content& content, const std::string& path);

/// Writes the picture as a display shows it. Throws Error.
void writeFramePreview(const ShotFrame::Content& content, const std::string& path);

/// The same of a picture that was written before, brighter by `exposure` stops; `output` says how, and where its
/// preview goes. Throws Error, of kind `input` where it could not be read.
void writePreviewOfPicture(const SceneOutput& output, FilePicture picture, const ColourConfig& colour, double exposure);

}  // namespace scrim
