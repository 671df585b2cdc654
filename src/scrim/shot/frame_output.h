// SPDX-License-Identifier: Apache-2.0
// The contents of a ShotFrame and how they are written to files.
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
    std::string sceneToml;  ///< for the metadata; "": the scene was built in code
    ColourConfig colour;
    Image image;                    ///< in the working space
    std::vector<Layer> kinds = {};  ///< the kind of each of `layers`
    std::vector<ShotLayer> layers = {};
    std::optional<DeepImage> deep = {};  ///< in the working space; only where the scene asks for one
    ShotReport report = {};
    bool skipped = false;
    double previewExposure = 0;  ///< stops
    Vec3 wsMiddle{0};            ///< of the volumes; only where previews are annotated
};

/// Takes the picture and the layers of `frame`. Throws Error(render) where any value is infinite or NaN.
void takeFrame(ShotFrame::Content& content, Frame frame);

/// Writes an OpenEXR file with what `file` asks for, but to `path`. Returns the number of values
/// that were clamped. Throws Error.
std::size_t writeFrame(const ShotFrame::Content& content, const OutputFile& file, const std::string& path);

/// Writes the deep picture, which must exist. Returns the number of values that were clamped. Throws Error.
std::size_t writeFrameDeep(const ShotFrame::Content& content, const std::string& path);

/// See ShotFrame::backplate.
Image backplateOf(const ShotFrame::Content& content);

/// Writes the picture as a display shows it. Throws Error.
void writeFramePreview(const ShotFrame::Content& content, const std::string& path);

/// Writes the preview of a picture that was written before, as writeFramePreview does that of a frame with this
/// content, which has no picture. Throws Error, of kind `input` where the picture could not be read.
void writePreviewOfPicture(const ShotFrame::Content& content, FilePicture picture);

}  // namespace scrim
