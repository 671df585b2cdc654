// SPDX-License-Identifier: Apache-2.0
// The part of the table of keys (scene_keys.h) that is about files that are written.
#pragma once

#include <scrim/scene/scene.h>
#include <scrim/scene/scene_key.h>

namespace scrim {

struct PreviewKeys : Section {
    PreviewKeys()
        : Section("preview", "preview = { ... } of [output]", "A picture for viewing, made through a view transform.") {
    }
    const Key& file =
        path("file", "a path such as \"plume.####.png\"", "A file in any format that OpenImageIO writes.").required();
    const Key& display =
        text("display", "the name of a display", "A display of the colour config.").unless("the config's");
    const Key& view = text("view", "the name of a view", "A view of the display.").unless("the display's");
    const Key& backplate =
        path("backplate", "a path such as \"plate.####.exr\"",
             "A picture that the preview is laid over, stretched to the display window. The EXR holds nothing of it.");
    const Key& backplateColorspace = text("backplate_colorspace", "the name of a colour space", "Its colour space.")
                                         .unless("sRGB of whole numbers, else the working space");
    const Key& annotate =
        boolean("annotate", false,
                "Draws a bar of a round length, in world units, and the directions of x, y and z into the lower "
                "corners. The bar is true at the middle of the volumes.");
};

struct HoldoutKeys : SectionOf<SceneHoldout> {
    HoldoutKeys()
        : SectionOf(
              "holdout", "holdout = { ... } of [output]",
              "A depth or deep picture of another renderer, taken by the same camera. It hides what is behind it, "
              "to a fraction of a sheet, so that the picture can be composited over that renderer's picture. A "
              "deep one (Z, ZBack, A) hides by its alpha. It adds neither colour nor alpha.") {}
    const Key& depth = path("depth", "a path such as \"z.####.exr\"",
                            "It must have as many pixels as the picture; #### makes it a sequence.")
                           .required();
    const Key& channel =
        text("channel", "the name of a channel", "The channel of depths; \"PART.NAME\" in files with several parts.")
            .unless("Z, or else the only one named Z or depth");
    const Key& kind =
        choice("kind", {"z", "distance"}, &SceneHoldout::alongRay,
               "How depths are measured, in world units: along the viewing axis, or along each pixel's ray.");
    const Key& background = number("background", Range::above(0), &SceneHoldout::background,
                                   "Depths from this one on mean that nothing is there: Blender writes 1e10, Arnold "
                                   "1e30, Karma infinity. So do depths of 0 and below, and NaN.");
    const Key& window =
        choice("window", {"display", "data"}, &SceneHoldout::dataWindow,
               "The window of the file that has the picture's resolution. The other one may be larger or smaller.");
};

/// The keys of a file that are those of [output] unless it states them.
struct FileKeys : SectionOf<OutputFile> {
    FileKeys();
    const Key& file = path("file", "a path such as \"plume.z.####.exr\"", "An EXR beside the picture.").required();
    const Key& layers;
    const Key& picture = boolean("picture", false, "It holds the picture (R, G, B, A), too.");
    const Key& colorspace =
        text("colorspace", "the name of a colour space", "Colour space of the file.").unless("that of [output]");
    const Key& type = choice("type", {"half", "float"}, "16 or 32 bits per channel.").unless("that of [output]");
    const Key& compression;
};

struct OutputKeys : SectionOf<SceneOutput> {
    OutputKeys();
    const Key& file = path("file", "a path such as \"plume.####.exr\"", "The picture, an EXR; -o replaces it.");
    const Key& colorspace = text("colorspace", "the name of a colour space", "Colour space of the picture.")
                                .unless("the config's scene_linear: ACEScg");
    const Key& chromaticities =
        boolean("chromaticities", &SceneOutput::chromaticities,
                "EXR files of linear spaces state their primaries and their white, too, for readers that do not know "
                "colorInteropID and would take them for Rec.709. false leaves them out; ACES2065-1 keeps them.");
    const Key& type =
        choice("type", {"half", "float"}, &SceneOutput::half, "16 or 32 bits per channel. Depth always has 32.", 0);
    const Key& layers;
    const Key& compression;
    const Key& files = tables(keysOf<FileKeys>(), "files",
                              "Further EXR files with layers of their own, as [[output.files]] or as the second and "
                              "later [[output]].");
    const Key& fps = number("fps", Range::aboveTo(0, 1e6, "frames a second"), &SceneOutput::fps,
                            "Frames per second, for the header and for velocities per second.");
    const Key& preview =
        path("preview", "a path, or a table with 'file', 'display', 'view', 'backplate' and 'annotate'",
             "A picture for viewing, written beside the picture.")
            .orTable(keysOf<PreviewKeys>());
    const Key& deep = path("deep", "a path such as \"plume.deep.####.exr\"",
                           "A deep picture, written beside the picture: an EXR of volume samples (Z, ZBack).");
    const Key& deepTolerance = number(
        "deep_tolerance", Range::fromTo(0, 1, ""), within(&SceneOutput::deep, &SceneDeep::tolerance),
        "Largest change that merging samples may cause in front of any depth: of alpha, "
        "and of colours relative to the pixel's. 0 keeps one sample per sheet. 0.03 takes about two thirds of the "
        "space of 0.01, 0.1 two fifths.");
    const Key& deepType = choice("deep_type", {"half", "float"}, within(&SceneOutput::deep, &SceneDeep::half),
                                 "16 or 32 bits for the deep picture's colours.", 0);
    const Key& holdout = table(keysOf<HoldoutKeys>(), "holdout", "A depth or deep picture that hides the volumes.");
};

}  // namespace scrim
