// SPDX-License-Identifier: Apache-2.0
// The one table of the keys of a scene, with a class for each section. The reader asks for keys by the members of these
// classes, so it reads nothing that is not listed here, and `scrim help` prints exactly what is read.
#pragma once

#include <scrim/scene/output_keys.h>
#include <scrim/scene/scene_key.h>
#include <scrim/scene/volume_keys.h>
#include <scrim/image/clear_sky.h>

#include <vector>

namespace scrim {

/// All sections in the order in which help explains them, starting with the scene itself.
const std::vector<const Section*>& sceneSections();

struct OrbitKeys : Section {
    OrbitKeys()
        : Section("orbit", "orbit = { ... } of [camera] or a [[light]]",
                  "A place on a sphere. Keyed angles move along true circles, whereas keyed positions cut across them. "
                  "For a distant light it is the direction that the light comes from: 'center' is the middle of its "
                  "slide, and there is no 'radius'.") {}
    const Key& center = vector("center", "a point [x, y, z]", Range::coordinate(),
                               "The centre, which a camera looks at unless it has a 'target'.")
                            .unless("[0, 0, 0]")
                            .keyed();
    const Key& radius =
        number("radius", Range::positiveLength(), {}, "Distance from the centre; needed unless the light is distant.")
            .keyed();
    const Key& elevation =
        number("elevation", Range::fromTo(-90, 90, "degrees"), 0, "Angle above the plane through the centre.").keyed();
    const Key& azimuth = number("azimuth", Range::fromTo(-1e9, 1e9, "degrees"), 0,
                                "Angle around 'up', from the front to the right. If y is up, 0 is +z and 90 is +x; if "
                                "z is up, 0 is -y and 90 is +x.")
                             .keyed();
};

struct CameraKeys : SectionOf<Scene> {
    CameraKeys()
        : SectionOf(
              "camera", "[camera]",
              "The position and lens of the camera. A camera looks along -z of its own frame, with y up. 'position' "
              "and 'target' give its place, or 'matrix', or 'orbit', or the header of a picture ('exr').") {
        exclude({&matrix}, {&position, &target, &up, &orbit, &exr});
        exclude({&exr}, {&type, &position, &target, &up, &orbit, &fov, &fovAxis, &focalLength, &aperture, &fit, &height,
                         &shift, &pixelAspect});
        exclude({&orbit}, {&position});
        exclude({&fov, &fovAxis}, {&focalLength, &aperture, &fit});
        exclude({&lensRadius}, {&fstop, &worldUnit});
        exclude({&exr}, {&fstop, &worldUnit});
    }
    const Key& type = choice("type", {"perspective", "orthographic"}, within(&Scene::camera, &Camera::type),
                             "The projection of the camera.");
    const Key& position =
        vector("position", "a point [x, y, z]", Range::coordinate(), "The position of the eye.").keyed();
    const Key& target =
        vector("target", "a point [x, y, z]", Range::coordinate(), "A point in the middle of the picture.").keyed();
    const Key& up =
        vector("up", "a direction [x, y, z]", {}, "The up direction of the picture.").unless("[0, 1, 0]").keyed();
    const Key& matrix =
        other("matrix", "four rows of four numbers", kMatrix, Range::fromTo(-1e15, 1e15),
              "Camera to world, row by row, for column vectors: the last column is the place of the eye, the last row "
              "0, 0, 0, 1. Scale is ignored; a mirrored or sheared frame is refused. (Maya, Houdini and USD print the "
              "transpose.) Between keys the place is interpolated, and the rotation follows the shorter arc.")
            .keyed();
    const Key& orbit =
        table(keysOf<OrbitKeys>(), "orbit", "A place on a sphere around a point, in place of 'position'.");
    const Key& exr = path("exr", "the path of an EXR with worldToCamera and worldToNDC",
                          "Takes place, lens and resolution from the header of a picture, such as a plate.####.exr "
                          "that another renderer wrote. 'near', 'overscan' and 'resolution' may stand beside it.");
    const Key& ndc = choice("ndc", {"auto", "-1..1", "0..1"},
                            "The range that the picture's worldToNDC maps its width and height to. auto: decided by "
                            "its projection; it is an error if that leaves it open.");
    const Key& fov = number("fov", Range::between(0, 180, "degrees"), within(&Scene::camera, &Camera::fov),
                            "Angle of view along 'fov_axis'.")
                         .onlyFor("perspective")
                         .keyed();
    const Key& fovAxis =
        choice("fov_axis", {"horizontal", "vertical", "diagonal"}, "The axis along which 'fov' is measured.")
            .onlyFor("perspective");
    const Key& focalLength =
        number("focal_length", Range::aboveTo(0, 1e6, "mm"), {}, "Replaces 'fov'; needs 'aperture'.")
            .onlyFor("perspective")
            .keyed();
    const Key& aperture = other("aperture", "the film's width, or [width, height], in mm", kNumbers,
                                Range::aboveTo(0, 1e6, "mm"), "The film back that goes with 'focal_length'.")
                              .onlyFor("perspective")
                              .keyed();
    const Key& fit = choice("fit", {"horizontal", "vertical", "fill", "overscan"},
                            "How the picture fits the film back if their aspect ratios differ: it keeps the film's "
                            "width, keeps its height, shows no more than the film ('fill'), or shows all of the film "
                            "('overscan'). Needs 'aperture' = [width, height].")
                         .onlyFor("perspective");
    const Key& fstop =
        number("fstop", Range::aboveTo(0, 1e6), {},
               "Depth of field: the focal length over the diameter of the lens; needs 'focus_distance'. Where only "
               "'fov' gives the lens, the film is 36 mm wide.")
            .onlyFor("perspective")
            .unless("everything is sharp")
            .keyed();
    const Key& worldUnit = number("world_unit", Range::aboveTo(0, 1e12, "mm"), 1000,
                                  "What a world unit is for 'fstop': 1000 if it is a metre, 10 if a centimetre.")
                               .onlyFor("perspective");
    const Key& lensRadius = number("lens_radius", Range::length(), {},
                                   "Depth of field: the radius of the lens in the world, in place of 'fstop'; needs "
                                   "'focus_distance'. 0: everything is sharp.")
                                .onlyFor("perspective")
                                .unless("that of 'fstop'")
                                .keyed();
    const Key& focusDistance =
        number("focus_distance", Range::positiveLength(), {}, "Depth along the viewing axis at which things are sharp.")
            .onlyFor("perspective")
            .keyed();
    const Key& height = number("height", Range::positiveLength(), within(&Scene::camera, &Camera::height),
                               "Height of the picture in the world; needed.")
                            .needed()
                            .onlyFor("orthographic")
                            .keyed();
    const Key& shift =
        other("shift", "two numbers [x, y], in widths of the picture", kTwoNumbers, Range::fromTo(-100, 100),
              "Lens shift to the right and up, in widths of the picture. It equals Blender's shift if the picture is "
              "wider than high, and USD's aperture offset / aperture.")
            .unless("[0, 0]")
            .keyed();
    const Key& near = number("near", Range::length(), within(&Scene::camera, &Camera::near),
                             "The near clipping distance along the viewing axis.")
                          .keyed();
    const Key& shutter =
        other("shutter", "two times [opens, closes], in frames about the frame, or \"off\"", kTwoNumbersOrWord,
              Range::fromTo(-1000, 1000, "frames"),
              "Motion blur: the picture is the mean over this time. Keyed values and volumes with a 'velocity' move "
              "during it; files of sequences stay those of the frame. [-0.25, 0.25] is a shutter of 180 degrees.")
            .unless("no motion blur");
    const Key& resolution = other("resolution", "[width, height] in pixels", kTwoNumbers,
                                  Range::fromTo(1, kMostPixels, "pixels"), "Size of the picture.")
                                .unless("[512, 512]");
    const Key& pixelAspect = number("pixel_aspect", Range::fromTo(0.01, 100),
                                    within(&Scene::camera, &Camera::pixelAspect), "Width of a pixel over its height.")
                                 .keyed();
    const Key& overscan = integer(
        "overscan", 0, kMostPixels, "pixels", &Scene::overscan,
        "Pixels that are rendered beyond each side of the picture. In the EXR they lie outside of the display window.");
};

struct SlideKeys : Section {
    SlideKeys()
        : Section("slide", "slide = { ... } of a [[light]]",
                  "A picture that a light shines through (ZC02 section 5), upright for a viewer who stands at the "
                  "light. White lets all light through.") {}
    const Key& file =
        path("file", "the slide's picture", "A picture in any format that OpenImageIO reads; #### makes it a sequence.")
            .required();
    const Key& colorspace =
        text("colorspace", "the name of a colour space",
             "Colour space of the file. Without it, integers count as sRGB and floats as the working space.");
    const Key& fov = number("fov", Range::between(0, 180, "degrees"), 30,
                            "Horizontal field of view of the picture. Without it, a spot's picture fills its cone.")
                         .onlyFor("point, spot and projector")
                         .keyed();
    const Key& width = number("width", Range::positiveLength(), {}, "Width of the picture in the world; needed.")
                           .onlyFor("distant")
                           .keyed();
    const Key& height = number("height", Range::positiveLength(), {},
                               "Height of the picture in the world. Without it, it follows from the picture's shape.")
                            .onlyFor("distant")
                            .keyed();
    const Key& roll = number("roll", Range::fromTo(-1e15, 1e15, "degrees"), 0,
                             "Turns the picture clockwise for a viewer who stands at the light.")
                          .keyed();
    const Key& outside =
        choice("outside", {"black", "clamp", "repeat"},
               "What the slide transmits beyond the picture's border; a projector's slide transmits nothing.");
};

struct TextureKeys : Section {
    TextureKeys()
        : Section(
              "texture", "texture = { ... } of a [[light]] of type \"dome\"",
              "The picture of a sky in UsdLux' lat-long mapping: its top is 'up', its middle is +z, a quarter to the "
              "right of the middle is -x, and both borders are -z. Every pixel gives its radiance times the light's.") {
    }
    const Key& file =
        path("file", "a path such as \"sky.exr\"", "A picture in any format that OpenImageIO reads, usually HDR.")
            .required();
    const Key& colorspace = text("colorspace", "the name of a colour space", "Colour space of the file.")
                                .unless("sRGB of whole numbers, else linear");
    const Key& split = boolean("split", true,
                               "Suns in the picture (bright spots at most 5 degrees across) become lights with sharp "
                               "shadows of their own. Their light stays in the layer of the dome.");
};

struct SkyKeys : SectionOf<ClearSky> {
    SkyKeys()
        : SectionOf(
              "sky", "sky = { ... } of a [[light]] of type \"dome\"",
              "A clear sky and its sun, computed from the air that sunlight passes; every key may be left out. The "
              "sun stands over the middle of the picture: with rotation = 0 over +z, with 90 over +x. In its "
              "light, 100000 lux are an irradiance of pi, so a white card in full sun has a radiance of about 1, "
              "and a blue sky 0.03 to 0.3. The light's color, intensity and exposure are factors on that.") {}
    const Key& sunElevation = number("sun_elevation", Range::fromTo(-90, 90, "degrees"), &ClearSky::sunElevation,
                                     "The sun's height above the horizon; below 0 it has set, and the sky glows until "
                                     "about -6.")
                                  .keyed();
    const Key& altitude = number("altitude", Range::fromTo(0, 60000, "metres"), &ClearSky::altitude,
                                 "The height above the sea of the camera and of all that the sky lights.")
                              .keyed();
    const Key& airDensity = number("air_density", Range::fromTo(0, 10), &ClearSky::airDensity,
                                   "The density of the air, relative to that on the Earth: it makes the sky blue, and "
                                   "low suns red.")
                                .keyed();
    const Key& dustDensity =
        number("dust_density", Range::fromTo(0, 10), &ClearSky::dustDensity,
               "The density of dust and mist, relative to a clear day: it makes the sky around the "
               "sun and at the horizon white.")
            .keyed();
    const Key& ozoneDensity = number("ozone_density", Range::fromTo(0, 10), &ClearSky::ozoneDensity,
                                     "The density of ozone, relative to 300 Dobson units: it keeps the sky blue while "
                                     "the sun sets.")
                                  .keyed();
    const Key& groundAlbedo = number("ground_albedo", Range::fromTo(0, 1), &ClearSky::groundAlbedo,
                                     "The part of its light that the Earth below the horizon sends back.")
                                  .keyed();
    const Key& sunDisc = boolean("sun_disc", &ClearSky::sunDisc, "The sun itself is in the sky, and casts shadows.");
    const Key& sunSize = number("sun_size", Range::fromTo(0.05, 5, "degrees"), &ClearSky::sunSize,
                                "The sun's angular diameter; its irradiance stays the same.")
                             .keyed();
    const Key& sunIntensity = number("sun_intensity", Range::fromTo(0, 1e6), &ClearSky::sunIntensity,
                                     "Factor on the light of the sun itself, not on that of the sky around it.")
                                  .keyed();
};

struct LightKeys : Section {
    LightKeys()
        : Section("light", "[[light]]",
                  "There may be any number of lights. A light's strength is color * intensity * 2^exposure. For a "
                  "distant light this is irradiance. For points, spots and projectors it is radiant intensity: their "
                  "irradiance is that / max(r^2, radius^2) at r world units (with decay = \"none\" it is the "
                  "irradiance at any r). For areas and domes it is radiance, the same from all sides. The picture "
                  "holds radiance. Under irradiance E, thin white smoke with an isotropic phase shows E / (4 pi) of "
                  "it, so a light that is to look as bright as on a white card needs an intensity of about 4 pi = 12.6 "
                  "(Cycles: a sun of strength E; vdb_render: a light of E / (4 pi)).") {
        exclude({&direction}, {&target});
        exclude({&orbit}, {&position});
        exclude({&texture}, {&sky});
    }
    const Key& name = text("name", "a name", "Names its layer, and the light in --set light.NAME.intensity=3.")
                          .unless("\"light1\", ...");
    const Key& group =
        text("group", "a name", "Lights of one group share one layer, light.GROUP, in place of one for each light.");
    const Key& type = choice("type", {"distant", "point", "spot", "projector", "area", "dome"},
                             "The emitter: parallel rays (a sun with 'angle'); a point; a point with a cone; a point "
                             "with a slide; a surface; the whole sky.")
                          .required();
    const Key& direction =
        vector("direction", "a direction [x, y, z]", {},
               "The direction in which the light travels, the axis of its cone, slide or luminaire, or the "
               "direction that its surface faces.")
            .keyed();
    const Key& position = vector("position", "a point [x, y, z]", Range::coordinate(),
                                 "The place of the light; for a distant light, the centre of its slide.")
                              .keyed();
    const Key& target =
        vector("target", "a point [x, y, z]", Range::coordinate(),
               "The point that a cone, slide, luminaire or surface is aimed at, in place of 'direction'.")
            .onlyFor("spot, projector, area and point with ies")
            .keyed();
    const Key& orbit = table(keysOf<OrbitKeys>(), "orbit",
                             "The place of the light, in place of 'position'; for a distant light, where it comes "
                             "from, in place of 'direction'.");
    const Key& up = vector("up", "a direction [x, y, z]", {},
                           "The up direction of the slide, the luminaire, the rectangle or the sky.")
                        .unless("[0, 1, 0]")
                        .keyed();
    const Key& color = colour("color", "[1, 1, 1]", "The light's colour.").keyed();
    const Key& intensity =
        number("intensity", Range::fromTo(0, 1e30), 1,
               "Irradiance (distant), radiance (area, dome) or radiant intensity (others); see above.")
            .keyed();
    const Key& exposure =
        number("exposure", Range::fromTo(-64, 64, "stops"), 0, "Multiplies the intensity by 2^exposure.").keyed();
    const Key& temperature =
        number("temperature", Range::fromTo(800, 40000, "Kelvin"), {},
               "Multiplies 'color' by the colour of a blackbody with luminance 1 (CIE Y), as in UsdLux.")
            .keyed();
    const Key& angle = number("angle", Range::fromTo(0, 180, "degrees"), 0,
                              "Angular diameter of the sun; its irradiance stays the same. The real sun has 0.53.")
                           .onlyFor("distant")
                           .keyed();
    const Key& shape = choice("shape", {"rectangle", "disk", "sphere", "cylinder", "mesh"},
                              "Shape of the surface that emits; rectangles and disks emit to one side. A cylinder has "
                              "no ends and lies across 'up', as a rectangle's width does.")
                           .onlyFor("area")
                           .required();
    const Key& mesh = text("mesh", "the name of a [[mesh]]",
                           "Shape 'mesh': what shines, outwards if it is closed, else to "
                           "the side from which the corners of its triangles are counterclockwise.")
                          .unless("none")
                          .onlyFor("area");
    const Key& width =
        number("width", Range::positiveLength(), {}, "Width of a rectangle, or length of a cylinder, across 'up'.")
            .onlyFor("area")
            .keyed();
    const Key& height =
        number("height", Range::positiveLength(), {}, "Height of a rectangle, along 'up'.").onlyFor("area").keyed();
    const Key& radius =
        number("radius", Range::length(), 0,
               "Radius of a disk, sphere or cylinder. For a point, spot or projector: the light grows no "
               "brighter within this radius, and shadows stay sharp.")
            .onlyFor("area, point, spot and projector")
            .keyed();
    const Key& normalize = boolean("normalize", false,
                                   "Divides the radiance by the area in world units (w h, pi r^2, 4 pi r^2, 2 pi r w), "
                                   "so that the light's power does not depend on its size.")
                               .onlyFor("area");
    const Key& spread =
        number("spread", Range::fromTo(1, 180, "degrees"), 180,
               "The full angle that a rectangle or disk shines into, as through a honeycomb grid: its light falls "
               "towards the border of that angle, and its power stays the same (Blender's Spread). 180: evenly.")
            .onlyFor("area")
            .keyed();
    const Key& texture =
        table(keysOf<TextureKeys>(), "texture", "The picture of the sky, which is multiplied by the colour.");
    const Key& sky =
        table(keysOf<SkyKeys>(), "sky", "A clear sky with its sun in place of a picture, multiplied by the colour.")
            .onlyFor("dome");
    const Key& rotation =
        number("rotation", Range::fromTo(-1e15, 1e15, "degrees"), 0, "Turns the sky about 'up', from +z towards +x.")
            .onlyFor("dome")
            .keyed();
    const Key& visible =
        boolean(
            "visible", false,
            "The camera sees the light: the sky behind the volumes, suns and all, or the surface of an area light, "
            "which hides what is behind it and is dark from the side that it does not shine to. The picture then is "
            "opaque there, and has the layer 'backdrop'.")
            .onlyFor("dome and area");
    const Key& samples =
        other("samples", "\"auto\" or a whole number from 1 to 4096",
              R"({"oneOf":[{"const":"auto"},{"type":"integer","minimum":1,"maximum":4096}]})", Range::fromTo(1, 4096),
              "Number of point-like lights that represent it. With shadow buffers each costs as much as a sun.")
            .onlyFor("area, dome and distant with an angle")
            .unless("\"auto\": as render.light_error needs");
    const Key& decay = choice("decay", {"inverse-square", "none"},
                              "How irradiance falls off with distance; none: 'intensity' is the irradiance everywhere, "
                              "as for the paper's lights.")
                           .onlyFor("point, spot and projector");
    const Key& cone =
        number("cone", Range::aboveTo(0, 180, "degrees"), 45, "The full angle of the cone.").onlyFor("spot").keyed();
    const Key& blend = number("blend", Range::fromTo(0, 1), 0.15,
                              "Fraction of the cone, from its border inwards, over which the light fades.")
                           .onlyFor("spot")
                           .keyed();
    const Key& ies =
        path("ies", "a path such as \"lamp.ies\"",
             "A photometric file (IES LM-63, type C): how the intensity depends on the direction, relative to its "
             "largest value, which 'intensity' stands for. The luminaire hangs upright, or its vertical angle 0 lies "
             "along 'direction' or towards 'target', and horizontal angle 0 opposite to 'up', as in Cycles.")
            .onlyFor("point and spot");
    const Key& slide = table(keysOf<SlideKeys>(), "slide",
                             "A picture that the light shines through; a projector needs one. For a rectangle it is "
                             "the picture on it, as on a screen, and has only 'file' and 'colorspace'.");
    const Key& shadows = boolean("shadows", true, "Volumes and meshes cast shadows in this light.");
    const Key& shadow =
        choice("shadow", {"auto", "buffers", "cells"},
               "Where attenuation is kept. buffers: a shadow buffer for each point or direction, for sharp shadows; "
               "cells: cells of about a voxel, for light from many directions or from within the volume; auto: the "
               "cheaper one that is exact enough.");
};

struct AmbientKeys : Section {
    AmbientKeys()
        : Section("ambient", "[ambient]",
                  "Uniform light from all sides. It has no shadows: every place gets all of it, however deep inside of "
                  "the smoke, so it lifts the darkest parts as much as the brightest. Keep it low.") {}
    const Key& color = colour("color", "[1, 1, 1] beside 'intensity'", "The light's radiance.").keyed();
    const Key& intensity =
        number("intensity", Range::fromTo(0, 1e30), {}, "Factor on 'color'; 1 if only 'color' is given.").keyed();
};

struct RenderKeys : SectionOf<Scene> {
    RenderKeys();
    const Key& quality;
    const Key& tolerance =
        number("tolerance", Range{0, 1, false, false, "as relative RMSE; 0 for none"}, &Scene::tolerance,
               "Replaces 'quality': texels and sheets are chosen for this error, and the error is measured.");
    const Key& dial(const std::string& name) const;  ///< one of dialTable()
};

struct KeyedKeys : Section {
    KeyedKeys()
        : Section("keys", "{ keys = [[frame, value], ...] } in place of a value marked *",
                  "A value that changes over frames. It is constant before the first key and after the last.") {}
    const Key& keys = other("keys", "a list of [frame, value]",
                            R"({"type":"array","minItems":1,"items":{"type":"array","minItems":2,"maxItems":2}})",
                            Range::fromTo(-kLastFrame, kLastFrame, "frames"), "The keys, in ascending order of frames.")
                          .required();
    const Key& interpolation = choice("interpolation", {"linear", "smooth"},
                                      "Interpolation between keys: linear, or smooth curves that come to rest at the "
                                      "first and last key and never overshoot the keys around them.");
};

struct ColourKeys : Section {
    ColourKeys()
        : Section("colour", "{ rgb = [r, g, b], colorspace = \"...\" } in place of a colour [r, g, b]",
                  "A colour in another space than the working space.") {}
    const Key& rgb =
        vector("rgb", "three numbers [r, g, b]", Range::atLeast(0), "The colour in that space.").required();
    const Key& colorspace =
        text("colorspace", "the name of a colour space", "The space's name in the colour config.").required();
};

/// The newest defaults: 2 since black bodies are not normalised unless they say so.
inline constexpr int kSceneVersion = 2;

struct SceneKeys : Section {
    SceneKeys()
        : Section(
              "scene", "A scene (TOML)",
              "Lengths are in world units, angles in degrees, times in frames. Colours are scene-linear in the working "
              "space (ACEScg unless an OpenColorIO config says otherwise). Paths are relative to the scene file; "
              "####, %04d and $F4 stand for the frame, ${NAME} for a key of [variables] or else of the "
              "environment, and $$, $# and $% for $, # and % themselves. Values marked * may be keyed. An unknown key "
              "is an error that says where it is and which keys are known. --set camera.fov=20 sets any value, and "
              "removes keys that would contradict it.") {}
    const Key& sceneVersion = integer("scene_version", 1, kSceneVersion, "", 1,
                                      "The version of the defaults that the scene was written for. A warning names "
                                      "every default that has changed since.");
    const Key& variables =
        other("variables", "a table of strings and numbers", kAnyTable, {}, "Values of ${NAME} in paths.");
    const Key& camera = table(keysOf<CameraKeys>(), "camera", "The position and lens of the camera.").required();
    const Key& volume = tables(keysOf<VolumeKeys>(), "volume", "The volumes to render; at least one.").required();
    const Key& mesh = tables(keysOf<MeshKeys>(), "mesh", "Solids that hide and shadow the volumes.");
    const Key& light = tables(keysOf<LightKeys>(), "light", "The lights of the scene.");
    const Key& ambient = table(keysOf<AmbientKeys>(), "ambient", "Unshadowed light from all sides.");
    const Key& render = table(keysOf<RenderKeys>(), "render", "The accuracy of the picture, and all dials.");
    const Key& output = table(keysOf<OutputKeys>(), "output", "The files that are written.");
};

}  // namespace scrim
