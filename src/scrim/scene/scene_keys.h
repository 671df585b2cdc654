// SPDX-License-Identifier: Apache-2.0
// The one table of the keys of a scene, with a class for each section. The reader asks for keys by the members of these
// classes, so it reads nothing that is not listed here, and `scrim help` prints exactly what is read.
#pragma once

#include <scrim/scene/scene_key.h>
#include <scrim/scene/volume_keys.h>

#include <vector>

namespace scrim {

/// All sections in the order in which help explains them, starting with the scene itself.
const std::vector<const Section*>& sceneSections();

struct OrbitKeys : Section {
    OrbitKeys()
        : Section(
              "orbit", "orbit = { ... } of [camera] or a [[light]]",
              "A place on a sphere. Keyed angles make true circles; keyed positions cut across them. Of a distant "
              "light it is the direction that light comes from: 'center' is the middle of its slide, and there is no "
              "'radius'.") {}
    const Key& center = vector("center", "a point [x, y, z]", Range::coordinate(),
                               "The middle, which a camera looks at unless it has a 'target'.")
                            .unless("[0, 0, 0]")
                            .keyed();
    const Key& radius =
        number("radius", Range::positiveLength(), {}, "Distance from the middle; needed unless the light is distant.")
            .keyed();
    const Key& elevation =
        number("elevation", Range::fromTo(-90, 90, "degrees"), 0, "Above the plane through the middle.").keyed();
    const Key& azimuth = number("azimuth", Range::fromTo(-1e9, 1e9, "degrees"), 0,
                                "Around 'up', from the front to the right: 0 is +z and 90 is +x where y is up; 0 is -y "
                                "and 90 is +x where z is up.")
                             .keyed();
};

struct CameraKeys : Section {
    CameraKeys()
        : Section("camera", "[camera]",
                  "Where the picture is taken from. A camera looks along -z of its own frame, y up. It stands where "
                  "'position' and 'target' say, or 'matrix', or 'orbit', or the header of a picture ('exr').") {
        exclude({&matrix}, {&position, &target, &up, &orbit, &exr});
        exclude({&exr}, {&type, &position, &target, &up, &orbit, &fov, &fovAxis, &focalLength, &aperture, &fit, &height,
                         &shift, &pixelAspect});
        exclude({&orbit}, {&position});
        exclude({&fov, &fovAxis}, {&focalLength, &aperture, &fit});
    }
    const Key& type = choice("type", {"perspective", "orthographic"}, "How rays leave the camera.");
    const Key& position = vector("position", "a point [x, y, z]", Range::coordinate(), "Where the eye is.").keyed();
    const Key& target =
        vector("target", "a point [x, y, z]", Range::coordinate(), "A point in the middle of the picture.").keyed();
    const Key& up = vector("up", "a direction [x, y, z]", {}, "What is up in the picture.").unless("[0, 1, 0]").keyed();
    const Key& matrix =
        other("matrix", "four rows of four numbers", kMatrix, Range::fromTo(-1e15, 1e15),
              "Camera to world, row by row, for column vectors: the last column is the place of the eye, the last row "
              "0, 0, 0, 1. Scale is ignored, a mirrored or sheared frame refused. (Maya, Houdini and USD print the "
              "transpose.) Between keys the place is interpolated, and the turn along the shorter arc.")
            .keyed();
    const Key& orbit =
        table(keysOf<OrbitKeys>(), "orbit", "A place on a sphere around a point, in place of 'position'.");
    const Key& exr = path("exr", "the path of an EXR with worldToCamera and worldToNDC",
                          "Takes place, lens and resolution from the header of a picture, such as a plate.####.exr "
                          "that another renderer wrote. 'near', 'overscan' and 'resolution' may stand beside it.");
    const Key& ndc = choice("ndc", {"auto", "-1..1", "0..1"},
                            "What the picture's worldToNDC maps its width and height to; auto: told by its projection, "
                            "and an error where that cannot tell.");
    const Key& fov = number("fov", Range::between(0, 180, "degrees"), 35, "Field of view along 'fov_axis'.")
                         .onlyFor("perspective")
                         .keyed();
    const Key& fovAxis = choice("fov_axis", {"horizontal", "vertical", "diagonal"}, "Which field of view 'fov' is.")
                             .onlyFor("perspective");
    const Key& focalLength =
        number("focal_length", Range::aboveTo(0, 1e6, "mm"), {}, "In place of 'fov', beside 'aperture'.")
            .onlyFor("perspective")
            .keyed();
    const Key& aperture = other("aperture", "the film's width, or [width, height], in mm", kNumbers,
                                Range::aboveTo(0, 1e6, "mm"), "The film back that goes with 'focal_length'.")
                              .onlyFor("perspective")
                              .keyed();
    const Key& fit =
        choice("fit", {"horizontal", "vertical", "fill", "overscan"},
               "Which side of the film back the picture keeps where their shapes differ: its width, its height, as "
               "much as shows no more than the film, or all of the film. Needs 'aperture' = [width, height].")
            .onlyFor("perspective");
    const Key& height =
        number("height", Range::positiveLength(), {}, "Needed: the picture's height.").onlyFor("orthographic").keyed();
    const Key& shift =
        other("shift", "two numbers [x, y], in widths of the picture", kTwoNumbers, Range::fromTo(-100, 100),
              "Moves the picture's window right and up, in widths of the picture, as a shifting lens does. Blender's "
              "shift where the picture is wider than high; USD's aperture offset / aperture.")
            .unless("[0, 0]")
            .keyed();
    const Key& near =
        number("near", Range::length(), 0, "Nothing nearer than this along the viewing axis is seen.").keyed();
    const Key& shutter =
        other("shutter", "two times [opens, closes], in frames about the frame", kTwoNumbers,
              Range::fromTo(-1000, 1000, "frames"),
              "Motion blur: the picture is the mean over these times, of whatever has keys or a 'velocity'. "
              "[-0.25, 0.25] is a shutter of 180 degrees. Files of sequences are those of the frame.")
            .unless("no motion blur");
    const Key& resolution = other("resolution", "[width, height] in pixels", kTwoNumbers,
                                  Range::fromTo(1, kMostPixels, "pixels"), "Of the picture.")
                                .unless("[512, 512]");
    const Key& pixelAspect =
        number("pixel_aspect", Range::fromTo(0.01, 100), 1, "Width of a pixel over its height.").keyed();
    const Key& overscan =
        integer("overscan", 0, kMostPixels, "pixels", 0,
                "Rendered beyond each side of the picture: larger than the display window in the EXR.");
};

struct SlideKeys : Section {
    SlideKeys()
        : Section("slide", "slide = { ... } of a [[light]]",
                  "A picture that a light shines through (ZC02 section 5), upright for a viewer who stands at the "
                  "light. White lets all light through.") {}
    const Key& file =
        path("file", "the slide's picture", "Any format OpenImageIO reads; sequences by ####.").required();
    const Key& colorspace =
        text("colorspace", "the name of a colour space",
             "Of the file. Integers count as sRGB, floats as the working space, unless it is given.");
    const Key& fov = number("fov", Range::between(0, 180, "degrees"), 30,
                            "Horizontal field of view of the picture; a spot's fills its cone unless it is given.")
                         .onlyFor("point, spot and projector")
                         .keyed();
    const Key& width = number("width", Range::positiveLength(), {}, "Needed: of the picture, in the world.")
                           .onlyFor("distant")
                           .keyed();
    const Key& height =
        number("height", Range::positiveLength(), {}, "As 'width'; from the picture's shape unless given.")
            .onlyFor("distant")
            .keyed();
    const Key& roll = number("roll", Range::fromTo(-1e15, 1e15, "degrees"), 0,
                             "Turns the picture clockwise for a viewer who stands at the light.")
                          .keyed();
    const Key& outside = choice("outside", {"black", "clamp", "repeat"},
                                "What the light is like beyond the picture's border. A projector's is black.");
};

struct TextureKeys : Section {
    TextureKeys()
        : Section("texture", "texture = { ... } of a [[light]] of type \"dome\"",
                  "The picture of a sky, lat-long as UsdLux has it: its top is 'up', its middle +z, a quarter to the "
                  "right of the middle -x, both borders -z. Every pixel gives its radiance times the light's.") {}
    const Key& file =
        path("file", "a path such as \"sky.exr\"", "Any format OpenImageIO reads, HDR as a rule.").required();
    const Key& colorspace =
        text("colorspace", "the name of a colour space", "Of the file.").unless("sRGB of whole numbers, else linear");
};

struct LightKeys : Section {
    LightKeys()
        : Section("light", "[[light]]",
                  "As many as there are. What a light gives is color * intensity * 2^exposure. Of a distant light that "
                  "is irradiance, of points, spots and projectors radiant intensity: their irradiance is it / max(r^2, "
                  "radius^2) at r world units (with decay = \"none\" it is the irradiance at any r). Of areas and "
                  "domes it is radiance, the same from all sides. The picture holds radiance. "
                  "Under irradiance E, thin white smoke with an isotropic phase shows E / (4 pi) of it, so a light "
                  "that is to look as bright as on a white card wants an intensity of about 4 pi = 12.6 (Cycles: a sun "
                  "of strength E; vdb_render: a light of E / (4 pi)).") {
        exclude({&direction}, {&target});
        exclude({&orbit}, {&position});
    }
    const Key& name =
        text("name", "a name", "Of its layer, and for --set light.NAME.intensity=3.").unless("\"light1\", ...");
    const Key& type =
        choice("type", {"distant", "point", "spot", "projector", "area", "dome"},
               "Parallel (a sun with 'angle'); from a point to all sides; from a point within a cone; from a point "
               "through a slide; from a surface; from the whole sky.")
            .required();
    const Key& direction =
        vector("direction", "a direction [x, y, z]", {},
               "The way the light travels, the axis of its cone or slide, or what its surface faces.")
            .keyed();
    const Key& position = vector("position", "a point [x, y, z]", Range::coordinate(),
                                 "Where it stands; of a distant light: the centre of its slide.")
                              .keyed();
    const Key& target = vector("target", "a point [x, y, z]", Range::coordinate(),
                               "What a cone, slide or surface is aimed at, in place of 'direction'.")
                            .onlyFor("spot, projector and area")
                            .keyed();
    const Key& orbit = table(
        keysOf<OrbitKeys>(), "orbit",
        "Where it stands, in place of 'position'; of a distant light: where it comes from, in place of 'direction'.");
    const Key& up = vector("up", "a direction [x, y, z]", {}, "What is up on the slide, the rectangle or the sky.")
                        .unless("[0, 1, 0]")
                        .keyed();
    const Key& color = colour("color", "[1, 1, 1]", "Its colour.").keyed();
    const Key& intensity =
        number("intensity", Range::fromTo(0, 1e30), 1,
               "Irradiance (distant), radiance (area, dome) or radiant intensity (others); see above.")
            .keyed();
    const Key& exposure = number("exposure", Range::fromTo(-64, 64, "stops"), 0, "Times 2^exposure.").keyed();
    const Key& temperature =
        number("temperature", Range::fromTo(800, 40000, "Kelvin"), {},
               "The colour of a black body, times 'color': of luminance 1 (CIE Y), as UsdLux has it.")
            .keyed();
    const Key& angle = number("angle", Range::fromTo(0, 180, "degrees"), 0,
                              "How large the sun is seen; its irradiance stays the same. The real one: 0.53.")
                           .onlyFor("distant")
                           .keyed();
    const Key& shape =
        choice("shape", {"rectangle", "disk", "sphere"},
               "Of the surface that shines; rectangles and disks to one side. Cylinders, meshes and IES profiles are "
               "not there.")
            .onlyFor("area")
            .required();
    const Key& width =
        number("width", Range::positiveLength(), {}, "Of a rectangle, across 'up'.").onlyFor("area").keyed();
    const Key& height =
        number("height", Range::positiveLength(), {}, "Of a rectangle, along 'up'.").onlyFor("area").keyed();
    const Key& radius =
        number("radius", Range::length(), 0,
               "Of a disk or sphere. Of a point, spot or projector: nearer than this the light grows no "
               "brighter; shadows stay sharp.")
            .onlyFor("area, point, spot and projector")
            .keyed();
    const Key& normalize =
        boolean("normalize", false,
                "Divides by the area in world units (w h, pi r^2, 4 pi r^2), so that a larger light is as strong.")
            .onlyFor("area");
    const Key& texture = table(keysOf<TextureKeys>(), "texture", "The picture of the sky, times its colour.");
    const Key& rotation =
        number("rotation", Range::fromTo(-1e15, 1e15, "degrees"), 0, "Turns the sky about 'up', from +z towards +x.")
            .onlyFor("dome")
            .keyed();
    const Key& samples =
        other("samples", "\"auto\" or a whole number from 1 to 4096",
              R"({"oneOf":[{"const":"auto"},{"type":"integer","minimum":1,"maximum":4096}]})", Range::fromTo(1, 4096),
              "Lights without extent that stand for it. Each costs about what any other light does.")
            .onlyFor("area, dome and distant with an angle")
            .unless("\"auto\": as render.light_error needs");
    const Key& decay =
        choice("decay", {"inverse-square", "none"},
               "How it falls off; none: as the paper's lights, 'intensity' is the irradiance everywhere.")
            .onlyFor("point, spot and projector");
    const Key& cone = number("cone", Range::aboveTo(0, 180, "degrees"), 45, "The full angle.").onlyFor("spot").keyed();
    const Key& blend =
        number("blend", Range::fromTo(0, 1), 0.15, "Part of the cone, from its border inwards, over which it fades.")
            .onlyFor("spot")
            .keyed();
    const Key& slide = table(keysOf<SlideKeys>(), "slide",
                             "A picture that it shines through; a projector needs one. Of a rectangle: the "
                             "picture on it, as on a screen, of which only 'file' and "
                             "'colorspace' are said.");
    const Key& shadows = boolean("shadows", true, "Does the volume take light away on its way?");
};

struct AmbientKeys : Section {
    AmbientKeys()
        : Section("ambient", "[ambient]",
                  "Light from all sides alike. It has no shadows: every place gets all of it, however deep inside the "
                  "smoke, so it lifts the darkest parts as much as the brightest. Keep it low.") {}
    const Key& color = colour("color", "[1, 1, 1] beside 'intensity'", "Its radiance.").keyed();
    const Key& intensity = number("intensity", Range::fromTo(0, 1e30), {}, "Times this; 1 beside 'color'.").keyed();
};

struct RenderKeys : Section {
    RenderKeys();
    const Key& quality;
    const Key& tolerance =
        number("tolerance", Range{0, 1, false, false, "as relative RMSE; 0 for none"}, 0,
               "In place of 'quality': texels and sheets are chosen for this error, and it is measured.");
    const Key& dial(const std::string& name) const;  ///< one of dialTable()
};

struct PreviewKeys : Section {
    PreviewKeys()
        : Section("preview", "preview = { ... } of [output]", "A picture to look at, through a view transform.") {}
    const Key& file = path("file", "a path such as \"plume.####.png\"", "Any format OpenImageIO writes.").required();
    const Key& display = text("display", "the name of a display", "Of the colour config.").unless("the config's");
    const Key& view = text("view", "the name of a view", "Of the display.").unless("the display's");
};

struct HoldoutKeys : Section {
    HoldoutKeys()
        : Section("holdout", "holdout = { ... } of [output]",
                  "A depth or deep picture of another renderer, taken by the same camera: what is behind it is hidden, "
                  "and what is in front of it, to the part of a sheet, goes over that renderer's picture. A deep one "
                  "(Z, ZBack, A) hides by its alpha. All of it adds neither colour nor alpha.") {}
    const Key& depth =
        path("depth", "a path such as \"z.####.exr\"", "Of as many pixels as the picture; sequences by ####.")
            .required();
    const Key& channel = text("channel", "the name of a channel", "That holds depths; \"PART.NAME\" in files of parts.")
                             .unless("Z, else the one that is called so");
    const Key& kind = choice("kind", {"z", "distance"},
                             "Along the viewing axis, or from the camera along each pixel's ray; in world units.");
    const Key& background = number("background", Range::above(0), 1e9,
                                   "From this depth on nothing is there: Blender writes 1e10, Arnold 1e30, Karma "
                                   "infinity. Nor is there at 0, below it, and at what is no number.");
    const Key& window = choice("window", {"display", "data"},
                               "Which of its windows is the picture. The other may be larger or smaller.");
};

struct OutputKeys : Section {
    OutputKeys();
    const Key& file = path("file", "a path such as \"plume.####.exr\"", "The picture, an EXR; or -o.");
    const Key& colorspace =
        text("colorspace", "the name of a colour space", "Of the picture.").unless("the config's scene_linear: ACEScg");
    const Key& type = choice("type", {"half", "float"}, "Bits of a channel: 16 or 32. Depth is always 32.");
    const Key& layers;
    const Key& compression;
    const Key& fps =
        number("fps", Range::aboveTo(0, 1e6, "frames a second"), 24, "For the header, and for velocities per second.");
    const Key& preview =
        path("preview", "a path, or a table with 'file', 'display' and 'view'", "A picture to look at beside it.")
            .orTable(keysOf<PreviewKeys>());
    const Key& deep = path("deep", "a path such as \"plume.deep.####.exr\"",
                           "A deep picture beside it, an EXR of volume samples (Z, ZBack).");
    const Key& deepTolerance =
        number("deep_tolerance", Range::fromTo(0, 1, ""), 0.01,
               "What merging samples may change before any depth: of alpha, and of colours as a part of the pixel's. 0 "
               "keeps one a sheet.");
    const Key& deepType = choice("deep_type", {"half", "float"}, "Bits of the deep picture's colours.");
    const Key& holdout = table(keysOf<HoldoutKeys>(), "holdout", "A depth or deep picture that hides the volumes.");
};

struct KeyedKeys : Section {
    KeyedKeys()
        : Section("keys", "{ keys = [[frame, value], ...] } in place of a value marked *",
                  "A value that changes. Before the first key and after the last it stays as it is there.") {}
    const Key& keys = other("keys", "a list of [frame, value]",
                            R"({"type":"array","minItems":1,"items":{"type":"array","minItems":2,"maxItems":2}})",
                            Range::fromTo(-kLastFrame, kLastFrame, "frames"), "Ascending frames.")
                          .required();
    const Key& interpolation = choice("interpolation", {"linear", "smooth"},
                                      "Straight lines, or curves that come to rest at the first and last key and never "
                                      "go beyond the keys around them.");
};

struct ColourKeys : Section {
    ColourKeys()
        : Section("colour", "{ rgb = [r, g, b], colorspace = \"...\" } in place of a colour [r, g, b]",
                  "A colour of another space than the working space.") {}
    const Key& rgb = vector("rgb", "three numbers [r, g, b]", Range::atLeast(0), "In that space.").required();
    const Key& colorspace =
        text("colorspace", "the name of a colour space", "As the colour config calls it.").required();
};

/// The newest defaults: 2 since black bodies are not normalised unless they say so.
inline constexpr int kSceneVersion = 2;

struct SceneKeys : Section {
    SceneKeys()
        : Section("scene", "A scene (TOML)",
                  "Lengths are world units, angles degrees, times frames. Colours are scene-linear in the working "
                  "space (ACEScg unless an OpenColorIO config says otherwise). Paths are relative to the scene file; "
                  "####, %04d and $F4 stand for the frame, ${NAME} for a key of [variables] or else of the "
                  "environment, and $$, $# and $% for $, # and % themselves. Values marked * may be keyed. What is not "
                  "known here is an error that says where and "
                  "what is. --set camera.fov=20 puts any value in place, and takes away what would contradict it.") {}
    const Key& sceneVersion = integer("scene_version", 1, kSceneVersion, "", 1,
                                      "The defaults that its author knew: where one changed later a warning says so.");
    const Key& variables =
        other("variables", "a table of strings and numbers", kAnyTable, {}, "What ${NAME} stands for in paths.");
    const Key& camera = table(keysOf<CameraKeys>(), "camera", "Where the picture is taken from.").required();
    const Key& volume = tables(keysOf<VolumeKeys>(), "volume", "What is rendered: at least one.").required();
    const Key& mesh = tables(keysOf<MeshKeys>(), "mesh", "Solids that hide it, and shadow it.");
    const Key& light = tables(keysOf<LightKeys>(), "light", "What lights it.");
    const Key& ambient = table(keysOf<AmbientKeys>(), "ambient", "Unshadowed light from everywhere.");
    const Key& render = table(keysOf<RenderKeys>(), "render", "How accurate, and every dial behind it.");
    const Key& output = table(keysOf<OutputKeys>(), "output", "What is written.");
};

}  // namespace scrim
