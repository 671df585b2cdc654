// SPDX-License-Identifier: Apache-2.0
// The part of the table of keys (scene_keys.h) that is about volumes.
#pragma once

#include <scrim/scene/points_keys.h>
#include <scrim/scene/scene.h>
#include <scrim/scene/scene_key.h>
#include <scrim/scene/shading_keys.h>

namespace scrim {

struct TransformKeys : Section {
    TransformKeys()
        : Section("transform", "transform = { ... } of a [[volume]] or [[mesh]]",
                  "Maps the asset's own world to the scene's: 'scale' is applied first, then 'rotate', then "
                  "'translate'; or 'matrix' replaces them.") {
        exclude({&matrix}, {&translate, &rotate, &scale});
    }
    const Key& translate =
        vector("translate", "three numbers [x, y, z]", Range::coordinate(), "Displacement in world units.")
            .unless("[0, 0, 0]")
            .keyed();
    const Key& rotate = vector("rotate", "three angles [x, y, z]", Range::fromTo(-1e9, 1e9, "degrees"),
                               "Rotation about x, then y, then z of the world; right-handed.")
                            .unless("[0, 0, 0]")
                            .keyed();
    const Key& scale = other("scale", "a number or three numbers, none of them 0", kNumbers, Range::fromTo(-1e12, 1e12),
                             "One factor, or one for each axis.")
                           .unless("1")
                           .keyed();
    const Key& matrix = other("matrix", "four rows of four numbers", kMatrix, Range::fromTo(-1e15, 1e15),
                              "Replaces the three: row by row, for column vectors, so that the last column is the "
                              "translation and the last row 0, 0, 0, 1.");
};

struct FrameKeys : SectionOf<SceneVolume> {
    FrameKeys()
        : SectionOf("frame", "frame = { ... } of a [[volume]] with a file",
                    "The file of the sequence that a volume shows: number = (the value of 'keys', or else frame * "
                    "'speed') + 'offset', rounded to the nearest whole number unless 'between' says otherwise.") {
        exclude({&keys}, {&speed});
    }
    const Key& offset = number("offset", Range::fromTo(-kLastFrame, kLastFrame, "frames"),
                               within(&SceneVolume::frameMap, &FrameMap::offset), "Offset of the number.");
    const Key& speed = number("speed", Range::fromTo(-1e6, 1e6), within(&SceneVolume::frameMap, &FrameMap::speed),
                              "Files per frame; 0.5 shows each file twice, or what is between them.");
    const Key& keys =
        other("keys", "a list of [frame, file number]", kPoints, Range::fromTo(-kLastFrame, kLastFrame, "frames"),
              "Retimes freely, in place of 'speed': linear between keys, constant outside of them.");
    const Key& between =
        choice("between", {"nearest", "blend", "advect"}, within(&SceneVolume::frameMap, &FrameMap::between),
               "What a number between two files shows: the nearest of them; a mixture of both; or a mixture after each "
               "was carried there by its 'velocity'.");
    const Key& outside =
        choice("outside", {"error", "hold", "black", "repeat", "ping-pong"}, &SceneVolume::outside,
               "What happens before the first and after the last file: an error, that file is shown, no volume, the "
               "sequence from its other end, or the sequence backwards and forwards in turn (its ends once).");
};

struct DensityKeys : SectionOf<SceneVolume> {
    DensityKeys()
        : SectionOf(
              "density", "density = { ... } of a [[volume]]",
              "Extinction per world unit = ramp(grid value) * scale. An optical depth of 1 takes away 63 % of the "
              "light. 'remap', 'edge', 'mask' and 'noise' change the grid's values before that, in this order.") {}
    const Key& grid = text(
        "grid", "the name of a grid",
        "\"density[1]\" selects the second of that name. Without it, the grid is 'density', or the only scalar grid.");
    const Key& scale = number("scale", Range::fromTo(0, 1e30, "per world unit"), &SceneVolume::densityScale,
                              "Extinction for a grid value of 1.");
    const Key& ramp =
        other("ramp", "a list of at least two [grid value, value]", kPoints, Range::atLeast(0),
              "Maps the grid's values, which ascend: linear between points, constant outside of them, 0 at 0.");
    const Key& remap = table(keysOf<RemapKeys>(), "remap", "Range, gamma and contrast.").unless("as it is");
    const Key& edge = other("edge", "two numbers [low, high]", kTwoNumbers, Range::atLeast(0),
                            "Densities fade in from the first to the second; thinner ones vanish. Ascending.")
                          .unless("as it is");
    const Key& mask = table(keysOf<MaskKeys>(), "mask", "A factor from another grid.").unless("none");
    const Key& noise = table(keysOf<NoiseKeys>(), "noise", "A random pattern.").unless("none");
    const Key& noiseMode =
        choice("noise_mode", {"multiply", "erode"}, within(&SceneVolume::shading, &DensityShading::noiseMode),
               "The density times 1 + amount * noise; or minus amount * (1 + noise) / 2, which eats "
               "thin places first.");
};

struct VelocityKeys : SectionOf<Velocity> {
    VelocityKeys()
        : SectionOf("velocity", "velocity = { ... } of a [[volume]] with a file",
                    "Moves the volume while the shutter of [camera] is open, in world units of the file: at time t its "
                    "grids are taken at x - v(x) t. Nothing moves where the velocity grid has no voxels, so it should "
                    "extend beyond the smoke as far as that moves.") {}
    const Key& grid = other("grid", "the name of a vec3 grid, or a list of the names of three scalar grids [x, y, z]",
                            R"({"type":["string","array"],"items":{"type":"string"},"minItems":3,"maxItems":3})", {},
                            "NAME may also mean three float grids NAME.x, NAME.y, NAME.z. The components of a "
                            "staggered grid lie on faces of voxels.")
                          .required();
    const Key& scale =
        number("scale", Range::fromTo(-1e12, 1e12), &Velocity::scale, "Factor on the grid's values.").keyed();
    const Key& unit = choice("unit", {"second", "frame"}, &Velocity::perSecond,
                             "The time that the velocity refers to; 'fps' of [output] converts seconds to frames.", 0);
};

struct AlbedoGridKeys : SectionOf<ColourGrid> {
    AlbedoGridKeys() : SectionOf("albedo", "albedo = { grid = ... } of [volume.medium]", "An albedo from a grid.") {}
    const Key& grid =
        text("grid", "the name of a grid of colours", "A vec3 grid, or NAME for three floats NAME.r, NAME.g, NAME.b.")
            .required();
    const Key& scale =
        number("scale", Range::fromTo(0, 1e30), &ColourGrid::scale, "Factor on the grid's values.").keyed();
    const Key& colorspace =
        text("colorspace", "the name of a colour space", "Colour space of the grid; without it, the working space.");
    const Key& ramp = other("ramp", "a list of at least two [grid value, colour]", R"({"type":"array","minItems":2})",
                            {}, "The grid is a scalar one, and this maps its values, which ascend, to colours.");
};

struct PhaseKeys : SectionOf<Phase> {
    PhaseKeys()
        : SectionOf("phase", "phase = { ... } of [volume.medium]",
                    "The distribution of scattered light over directions.") {}
    const Key& type = choice("type", {"isotropic", "hg", "two-lobe", "rayleigh", "draine", "droplets"},
                             "Isotropic; Henyey-Greenstein; two such lobes; Rayleigh, as in air; Draine, with a lobe "
                             "to both sides; droplets of water, as in clouds and fog.")
                          .required();
    const Key& g =
        number("g", Range::between(-1, 1), &Phase::g,
               "The mean cosine; needed. 0 is isotropic, above 0 is forward: smoke has about 0.3, clouds 0.8.")
            .needed()
            .onlyFor("hg and draine");
    const Key& alpha = number("alpha", Range::fromTo(0, 1e6), 1,
                              "How much of the lobe is to both sides: 0 is Henyey-Greenstein, 1 Cornette-Shanks.")
                           .onlyFor("draine")
                           .keyed();
    const Key& dropletSize = number("size", Range::aboveTo(0, 50, "micrometres"), {},
                                    "The diameter of droplets; needed. Fog has about 1 to 10, clouds 5 to 50.")
                                 .needed()
                                 .onlyFor("droplets")
                                 .keyed();
    const Key& g1 = number("g1", Range::between(-1, 1), &Phase::g, "Mean cosine of the first lobe; needed.")
                        .needed()
                        .onlyFor("two-lobe");
    const Key& g2 = number("g2", Range::between(-1, 1), &Phase::g2, "Mean cosine of the second lobe; needed.")
                        .needed()
                        .onlyFor("two-lobe");
    const Key& blend =
        number("blend", Range::fromTo(0, 1), &Phase::blend, "Weight of the second lobe.").onlyFor("two-lobe");
};

struct OctavesKeys : SectionOf<Octaves> {
    OctavesKeys()
        : SectionOf(
              "octaves", "octaves = { ... } of [volume.medium]",
              "An approximation of multiple scattering: octave n adds single scattering with thinner shadows. With "
              "contribution <= extinction no octave creates light.") {}
    const Key& count =
        integer("count", 1, 16, "", &Octaves::count, "Number of octaves; 1 is single scattering.").otherwise(8);
    const Key& extinction = number("extinction", Range::fromTo(0, 1), &Octaves::extinction,
                                   "Factor on the extinction towards the light, for each octave.");
    const Key& contribution =
        number("contribution", Range::fromTo(0, 1), &Octaves::contribution, "Factor on the light, for each octave.");
    const Key& phase =
        number("phase", Range::fromTo(0, 1), &Octaves::phase, "Factor on mean cosines, for each octave.");
};

struct EmissionKeys : SectionOf<Emission> {
    EmissionKeys()
        : SectionOf(
              "emission", "emission = { ... } of [volume.medium]",
              "Radiance per world unit = ramp(grid value) * scale * mask, whatever the density. It lights volumes "
              "whose scattering = \"full\".") {}
    const Key& grid = text("grid", "the name of a grid", "The grid that glows.").required();
    const Key& colors = boolean("colors", false,
                                "The grid holds colours in the working space: a vec3 grid, or three grids NAME.r, "
                                "NAME.g and NAME.b. They are emitted as they are, in place of 'ramp'.");
    const Key& scale = number("scale", Range::fromTo(0, 1e30), &Emission::scale,
                              "The strength of all that is emitted: a factor on what the ramp gives.")
                           .keyed();
    const Key& ramp =
        other("ramp", "a list of at least two [grid value, colour or Kelvin, strength]",
              R"({"type":"array","minItems":2})", {},
              "Maps grid values, which ascend, to light: linear between points, constant outside of them, black at 0. "
              "A temperature from 800 to 40000 Kelvin stands for its colour, of luminance 1. The strength is a factor, "
              "1 if it is left out. Without a ramp, the value itself is emitted, in white.");
    const Key& range = other("range", "two numbers [low, high]", kTwoNumbers, Range::fromTo(-1e30, 1e30),
                             "The grid's values that 0 and 1 of the ramp stand for; ascending. A higher low end makes "
                             "a fire smaller.")
                           .unless("[0, 1]");
    const Key& mask = table(keysOf<MaskKeys>(), "mask", "A factor from another grid.").unless("none");
};

struct BlackbodyKeys : SectionOf<Emission> {
    BlackbodyKeys()
        : SectionOf(
              "blackbody", "blackbody = { ... } of [volume.medium]",
              "Fire: the light of a blackbody at the grid's temperature (Planck's law as seen by the CIE's observer). "
              "It lights volumes whose scattering = \"full\". Nothing glows below about 700 K. Caches of Houdini, "
              "Blender and EmberGen hold about 0 to 1 instead of Kelvin; 'kelvin' converts these values.") {
        exclude({&kelvin}, {&scale, &offset});
        exclude({&normalize}, {&physicalIntensity});
    }
    const Key& grid = text("grid", "the name of a grid", "The grid of temperatures.").required();
    const Key& kelvin =
        other("kelvin", "two temperatures [of grid value 0, of grid value 1] in Kelvin", kTwoNumbers,
              Range::fromTo(-1e6, 1e6, "Kelvin"), "For fire: [500, 1900]. Replaces 'scale' and 'offset'.");
    const Key& scale = number("scale", Range::fromTo(1e-9, 1e9, "Kelvin"), &Emission::kelvinScale,
                              "Kelvin = grid value * scale + offset.")
                           .keyed();
    const Key& offset =
        number("offset", Range::fromTo(-1e6, 1e6, "Kelvin"), &Emission::kelvinOffset, "See 'scale'.").keyed();
    const Key& intensity =
        number("intensity", Range::fromTo(0, 1e30), &Emission::scale,
               "Radiance per world unit = this * sigma T^4 / pi in MW/(m^2 sr), which is 0.09 at 1500 K.")
            .keyed();
    const Key& normalize = boolean("normalize", false,
                                   "Makes all temperatures equally bright, so that only colour changes. If false, "
                                   "radiance is proportional to the fourth power of temperature.");
    const Key& physicalIntensity =
        number("physical_intensity", Range::fromTo(0, 1), &Emission::physicalIntensity,
               "Between both: radiance = intensity * (sigma T^4 / pi)^this, so that 0 is as normalize = true, and 0.5 "
               "makes it proportional to the square of temperature.")
            .keyed();
    const Key& tint = colour("tint", "[1, 1, 1]", "Factor on the light in each channel.");
    const Key& mask = table(keysOf<MaskKeys>(), "mask", "A factor from another grid.").unless("none");
};

/// The most that a part of an extinction tint may be, and of the colours of a ramp.
inline constexpr double kMostTint = 1e6, kMostLight = 1e30;

struct MediumKeys : Section {
    MediumKeys()
        : Section("medium", "[volume.medium]",
                  "How the volume above it scatters, absorbs and emits light: smoke, clouds, fire.") {
        exclude({&extinctionTint}, {&transparency, &transparencyDepth});
    }
    const Key& albedo =
        colour("albedo", "[0.9, 0.9, 0.9]", "Scattered fraction of extinction, 0 to 1; or a grid of colours.")
            .orTable(keysOf<AlbedoGridKeys>());
    const Key& extinctionTint = colour("extinction_tint", "[1, 1, 1]", "Factor on extinction in each channel.");
    const Key& transparency =
        colour("transparency", "none",
               "In place of 'extinction_tint': the colour that white light has after 'transparency_depth' of a medium "
               "whose density times 'scale' is 1; above 0 and at most 1. Extinction is then -ln(transparency) / "
               "transparency_depth times that density.");
    const Key& transparencyDepth = number("transparency_depth", Range::positiveLength(), 1, "See 'transparency'.");
    const Key& phase =
        table(keysOf<PhaseKeys>(), "phase", "The distribution of scattered light over directions.").unless("isotropic");
    const Key& scattering =
        choice("scattering", {"single", "octaves", "full"},
               "How often light scatters: once; once, with more approximated by 'octaves'; or any number of times, "
               "which also lets emission, [ambient] and domes light the volume, with shadows.")
            .unless("\"single\", or \"octaves\" where these are given");
    const Key& octaves =
        table(keysOf<OctavesKeys>(), "octaves", "An approximation of multiple scattering.").unless("single scattering");
    const Key& emission = table(keysOf<EmissionKeys>(), "emission", "Emission, from a grid by a ramp.");
    const Key& blackbody = table(keysOf<BlackbodyKeys>(), "blackbody", "Emission, from temperature.");
};

struct TransferKeys : SectionOf<TransferPoint> {
    TransferKeys()
        : SectionOf("transfer", "transfer = [ { ... }, ... ] of [volume.classified]",
                    "Points of a transfer function: linear between points, constant outside of them; two points of one "
                    "value make a step.") {}
    const Key& value = number("value", {}, &TransferPoint::value, "A value of the grid.").needed().required();
    const Key& color = colour("color", "[1, 1, 1]", "Colour at this value.");
    const Key& extinction = number("extinction", Range::fromTo(0, 1e30, "per world unit"), &TransferPoint::extinction,
                                   "Extinction at this value, which the density's 'scale' multiplies.")
                                .needed()
                                .required();
};

/// The most that the albedo times a colour of a transfer function may be: 1, but for the rounding
/// of colours that come from another space.
inline constexpr double kMostScattered = 1 + 1e-5;

struct ClassifiedKeys : SectionOf<Classified> {
    ClassifiedKeys()
        : SectionOf(
              "classified", "[volume.classified]",
              "Scans and surfaces, in place of a medium: a transfer function ('transfer' or 'window', one of which is "
              "needed), and Phong shading by gradients (ZC02 section 3.1).") {
        exclude({&transfer}, {&window});
    }
    const Key& transfer = other("transfer", "a list of { value, color, extinction }",
                                R"({"type":"array","minItems":2,"items":{"$ref":"#/$defs/transfer"}})", {},
                                "At least two points, ascending, with no extinction at 0.")
                              .orTable(keysOf<TransferKeys>());
    const Key& window = other(
        "window", R"("bone", "soft tissue", "lung", "vessels" or two numbers [centre, width])", kTwoNumbersOrWord,
        Range::fromTo(-1e9, 1e9),
        "A transfer function by name, or from black and clear to white and opaque, in Hounsfield units. The grid "
        "must hold these, as the source \"scan\" makes it with units = \"hounsfield\". Extinctions are per voxel.");
    const Key& windowZero =
        number("window_zero", Range::fromTo(-1e9, 1e9), kHounsfieldZero,
               "The value of the grid at 0 of the window. 0 for a window in the grid's own values.");
    const Key& gradient =
        other("gradient", "a list of at least two [length, factor]", kPoints, Range::atLeast(0),
              "Factors from 0 to 1 on the extinction, by the length of the grid's gradient (change of value per world "
              "unit), ascending: linear between points, constant outside of them. [[5, 0], [20, 1]] shows boundaries, "
              "and not what is alike all through.")
            .unless("1 everywhere");
    const Key& ambient = number("ambient", Range::fromTo(0, 1e6), &Classified::ambient,
                                "Factor on ambient light. It does not count with scattering = \"full\".");
    const Key& diffuse =
        number("diffuse", Range::fromTo(0, 1e6), &Classified::diffuse, "Factor on diffusely reflected light.");
    const Key& specular = number("specular", Range::fromTo(0, 1e6), &Classified::specular, "Factor on the highlight.");
    const Key& exponent = number("exponent", Range::fromTo(0, 1e4), &Classified::exponent,
                                 "Phong's exponent: the larger, the smaller the highlight.");
    const Key& twoSided = boolean("two_sided", &Classified::twoSided, "Surfaces are also lit from behind.");
    const Key& scattering = choice(
        "scattering", {"single", "full"}, &Classified::scatters,
        "How often light scatters. \"full\": light that comes straight from a light is shown as ever, and scatters "
        "evenly to all sides any number of times, as do emission, [ambient] and domes, with shadows.");
    const Key& albedo =
        colour("albedo", "[0.9, 0.9, 0.9]",
               "Scattered fraction of extinction, 0 to 1, which multiplies the colours of the transfer function.")
            .onlyFor("scattering = \"full\"");
};

struct MeshKeys : SectionOf<SceneMesh> {
    MeshKeys()
        : SectionOf("mesh", "[[mesh]]",
                    "A solid made of triangles, which another renderer draws. Here it hides the volumes, casts shadows "
                    "into them, and shows their shadows. An open surface acts from both sides.") {}
    const Key& name = text("name", "a name", "Names the mesh in messages, and in --set mesh.NAME.shadows=false.")
                          .unless("\"mesh1\", ...");
    const Key& file = path("file", "an .obj or .ply file", "\"actor.####.obj\" is a sequence.").required();
    const Key& transform = table(keysOf<TransformKeys>(), "transform", "Its transform in the scene.");
    const Key& holdout =
        boolean("holdout", &SceneMesh::holdout, "The mesh hides what is behind it, and adds neither colour nor alpha.");
    const Key& shadows = boolean("shadows", &SceneMesh::shadows,
                                 "Casts shadows into volumes, and stops light that has scattered in them.");
    const Key& catches = boolean("catch", &SceneMesh::catches,
                                 "Shows the shadows of volumes. The picture then has layers 'shadow.LIGHT': the "
                                 "fraction of each light that reaches the first such surface; 1 where there is none.");
    const Key& albedo = colour("albedo", "[0, 0, 0]",
                               "The part of the light that the mesh sends back, evenly to all sides, into volumes that "
                               "scatter fully. It does not show the mesh: see 'color'.");
    const Key& color =
        colour("color", "none",
               "Shows the mesh, with alpha, as a matte surface of this colour, 0 to 1: lit by all lights, through the "
               "volumes, in the shadows of meshes, and by what volumes scatter and emit. It is for judging a shot. The "
               "picture then has the layer 'backdrop'. Needs holdout = true.");
};

struct CombineKeys : Section {
    CombineKeys()
        : Section(
              "grids", "grids = { NAME = { ... } } of a [[volume]]",
              "A grid that is computed from several: density = { max = [\"a.vdb\", \"b.vdb:smoke\"] }. Where one of "
              "them has no voxel, it counts as 0. Grids of other voxels than the first one's are interpolated "
              "linearly at its voxels.") {
        exclude({&max}, {&add, &multiply});
        exclude({&add}, {&multiply});
    }
    const Key& max = other("max", kFiles, kStrings, {}, "The largest value; of numbers only.");
    const Key& add = other("add", kFiles, kStrings, {}, "The sum.");
    const Key& multiply = other("multiply", kFiles, kStrings, {}, "The product.");

  private:
    static constexpr const char* kFiles = "a list of at least two \"FILE:GRID\"";
};

struct VolumeKeys : SectionOf<SceneVolume> {
    VolumeKeys()
        : SectionOf("volume", "[[volume]]",
                    "A volume, of which a scene needs at least one: a .vdb file or sequence, or a source that makes or "
                    "reads something else (`scrim make --list`).") {
        exclude({&source}, {&file, &grids, &frame, &velocity, &points});
        exclude({&file}, {&grids});
        exclude({&ax}, {&axFile});
        exclude({&medium}, {&classified});
    }
    const Key& name =
        text("name", "a name", "Names the volume in messages, in layers and in --set volume.NAME.density.scale=3.")
            .unless("\"volume1\", ...");
    const Key& file =
        path("file", "a .vdb file, or 'source', the name of a volume source", "\"smoke.####.vdb\" is a sequence.");
    const Key& grids =
        other(
            "grids", "a table of { NAME = \"FILE:GRID\" }",
            R"({"type":"object","minProperties":1,"additionalProperties":)"
            R"({"anyOf":[{"type":"string"},{"$ref":"#/$defs/grids"}]}})",
            {},
            "In place of 'file': grids from several .vdb files, or sequences. Without ':GRID', the file's grid of the "
            "same name, or its only one. The volume has these grids alone.")
            .orTable(keysOf<CombineKeys>());
    const Key& frame =
        table(keysOf<FrameKeys>(), "frame", "The file of a sequence that is shown.").onlyFor("'file' or 'grids'");
    const Key& source = text("source", "the name of a volume source", "\"noise\", \"scan\", ...; in place of 'file'.");
    const Key& parameters =
        other(
            "parameters", "a table", kAnyTable, {},
            "Parameters of the source; `scrim make SOURCE --help-source` lists them. 'file' is a path like all others. "
            "A number or vector that 'ax' mentions as $NAME or v$NAME belongs to the expression, and may be keyed.")
            .onlyFor("'source' or 'ax'");
    const Key& clip = other("clip", "two points [[x, y, z], [x, y, z]]",
                            R"({"type":"array","minItems":2,"maxItems":2})", Range::coordinate(),
                            "Cuts away what lies outside of this box, in world units of the file. Voxels are cut, too; "
                            "'ax' still sees some of them beyond.");
    const Key& clipPlane =
        other("clip_plane", "four numbers [nx, ny, nz, d]",
              R"({"type":"array","items":{"type":"number"},"minItems":4,"maxItems":4})", Range::coordinate(),
              "Cuts away what lies beyond this plane, in world units of the file: where nx x + ny y + nz z > d.");
    const Key& resample =
        number("resample", Range::fromTo(0.125, 16), 1,
               "Divides voxels by this factor along each axis, so that 'ax' can add detail finer than the file's "
               "voxels. 2 takes 8 times the memory.");
    const Key& detail =
        other("detail", "1, 2, 4, 8 or \"auto\"", R"({"enum":[1,2,4,8,"auto"]})", {},
              "Evaluates the shading of the density on voxels divided by this factor along each axis, but only where "
              "that shows: at silhouettes and where noise changes much within a voxel. \"auto\": as the finest octave "
              "of its noise needs, at most 4.")
            .unless("1");
    const Key& ax = text("ax", "code in OpenVDB AX",
                         "Changes grids, and makes new ones, at each active voxel: \"f@density *= 2;\". $frame, $time "
                         "(in seconds) and $seed are known, and numbers of 'parameters'.");
    const Key& axFile = path("ax_file", "a file of such code", "In place of 'ax'.");
    const Key& transform = table(keysOf<TransformKeys>(), "transform", "Its transform in the scene.");
    const Key& density = table(keysOf<DensityKeys>(), "density", "The grid of densities, and their scale.");
    const Key& interpolation =
        choice("interpolation", {"auto", "linear", "smooth"}, &SceneVolume::interpolation,
               "Between voxels: 'linear', or 'smooth' (cubic B-splines), which shows no stripes along rows of voxels "
               "where these are larger than a few pixels. 'auto' is as 'kernel' of [render].");
    const Key& displacement =
        table(keysOf<NoiseKeys>(), "displacement", "Displaces all grids of the volume by noise.").unless("none");
    const Key& velocity =
        table(keysOf<VelocityKeys>(), "velocity", "The motion of the volume while the shutter is open.")
            .onlyFor("'file' or 'grids'");
    const Key& points =
        table(keysOf<PointsKeys>(), "points", "How the file's points become a density.").onlyFor("'file' or 'grids'");
    const Key& lights =
        other("lights", "a list of names of lights", kStrings, {},
              "The lights that light it. It casts shadows in all lights, unless 'shadows' says otherwise.")
            .unless("all");
    const Key& shadows =
        other("shadows", "true, false or a list of names of lights",
              R"({"anyOf":[{"type":"boolean"},{"type":"array","items":{"type":"string"}}]})", {},
              "The lights in which it casts shadows, on itself and on other volumes. Not beside media with "
              "scattering = \"full\".")
            .unless("true");
    const Key& holdout = boolean(
        "holdout", &SceneVolume::holdout,
        "The volume hides and shadows others, but adds neither colour nor alpha, because another picture shows it.");
    const Key& medium = table(keysOf<MediumKeys>(), "medium", "Smoke, clouds, fire.");
    const Key& classified = table(keysOf<ClassifiedKeys>(), "classified", "Scans and surfaces, in place of 'medium'.");
};

}  // namespace scrim
