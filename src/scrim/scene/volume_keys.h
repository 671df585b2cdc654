// SPDX-License-Identifier: Apache-2.0
// The part of the table of keys (scene_keys.h) that is about volumes.
#pragma once

#include <scrim/scene/scene_key.h>

namespace scrim {

struct TransformKeys : Section {
    TransformKeys()
        : Section("transform", "transform = { ... } of a [[volume]] or [[mesh]]",
                  "From the asset's own world to the scene's: 'scale' first, then 'rotate', then 'translate'; or "
                  "'matrix'.") {
        exclude({&matrix}, {&translate, &rotate, &scale});
    }
    const Key& translate =
        vector("translate", "three numbers [x, y, z]", Range::coordinate(), "World units.").unless("[0, 0, 0]").keyed();
    const Key& rotate = vector("rotate", "three angles [x, y, z]", Range::fromTo(-1e9, 1e9, "degrees"),
                               "About x, then y, then z of the world; right-handed.")
                            .unless("[0, 0, 0]")
                            .keyed();
    const Key& scale = other("scale", "a number or three numbers, none of them 0", kNumbers, Range::fromTo(-1e12, 1e12),
                             "Factor, or one along each axis.")
                           .unless("1")
                           .keyed();
    const Key& matrix = other("matrix", "four rows of four numbers", kMatrix, Range::fromTo(-1e15, 1e15),
                              "In place of the three: row by row, for column vectors, so that the last column is the "
                              "translation and the last row 0, 0, 0, 1.");
};

struct FrameKeys : Section {
    FrameKeys()
        : Section("frame", "frame = { ... } of a [[volume]] with a file",
                  "Which file of its sequence a volume shows: number = (what 'keys' say, or else frame * 'speed') + "
                  "'offset', to the nearest whole number.") {
        exclude({&keys}, {&speed});
    }
    const Key& offset = number("offset", Range::fromTo(-kLastFrame, kLastFrame, "frames"), 0, "Added to the number.");
    const Key& speed = number("speed", Range::fromTo(-1e6, 1e6), 1, "Files a frame; 0.5 shows each file twice.");
    const Key& keys =
        other("keys", "a list of [frame, file number]", kPoints, Range::fromTo(-kLastFrame, kLastFrame, "frames"),
              "Retimes freely, in place of 'speed': linear between, constant outside.");
    const Key& outside = choice("outside", {"error", "hold", "black"},
                                "Before the first and after the last file: an error, that file, or no volume.");
};

struct DensityKeys : Section {
    DensityKeys()
        : Section("density", "density = { ... } of a [[volume]]",
                  "Extinction per world unit = ramp(grid value) * scale. An optical depth of 1 takes away 63 % of the "
                  "light.") {}
    const Key& grid =
        text("grid", "the name of a grid",
             "\"density[1]\" picks the second of that name. Unless given: density, or the only scalar grid.");
    const Key& scale = number("scale", Range::fromTo(0, 1e30, "per world unit"), 1, "Extinction of grid value 1.");
    const Key& ramp = other("ramp", "a list of at least two [grid value, value]", kPoints, Range::atLeast(0),
                            "Remaps the field: ascending, linear between, constant outside, 0 at 0.");
};

struct VelocityKeys : Section {
    VelocityKeys()
        : Section("velocity", "velocity = { ... } of a [[volume]] with a file",
                  "What the volume moves by while the shutter of [camera] is open, in world units of the file: at time "
                  "t its grids are taken at x - v(x) t. Where the grid has no voxels nothing moves, so it should reach "
                  "beyond the smoke as far as that moves.") {}
    const Key& grid =
        other("grid", "the name of a vec3 grid, or a list of the names of three scalar grids [x, y, z]",
              R"({"type":["string","array"],"items":{"type":"string"},"minItems":3,"maxItems":3})", {},
              "NAME is also three floats NAME.x, NAME.y, NAME.z. Components of a staggered grid stand on faces.")
            .required();
    const Key& scale = number("scale", Range::fromTo(-1e12, 1e12), 1, "Times this.").keyed();
    const Key& unit = choice("unit", {"second", "frame"}, "What the velocity is per; seconds by 'fps' of [output].");
};

struct AlbedoGridKeys : Section {
    AlbedoGridKeys() : Section("albedo", "albedo = { grid = ... } of [volume.medium]", "Colours from a grid.") {}
    const Key& grid =
        text("grid", "the name of a grid of colours", "A vec3 grid, or NAME for three floats NAME.r, NAME.g, NAME.b.")
            .required();
    const Key& scale = number("scale", Range::fromTo(0, 1e30), 1, "Times this.").keyed();
    const Key& colorspace =
        text("colorspace", "the name of a colour space", "Of the grid; the working space unless given.");
};

struct PhaseKeys : Section {
    PhaseKeys()
        : Section("phase", "phase = { ... } of [volume.medium]", "How much of the scattered light goes which way.") {}
    const Key& type = choice("type", {"isotropic", "hg", "two-lobe", "rayleigh"},
                             "To all sides; Henyey-Greenstein; two such lobes; air.")
                          .required();
    const Key& g = number("g", Range::between(-1, 1), {},
                          "Needed: the mean cosine. 0 is isotropic, above 0 forward: smoke about 0.3, clouds 0.8.")
                       .onlyFor("hg");
    const Key& g1 = number("g1", Range::between(-1, 1), {}, "Needed: of the first lobe.").onlyFor("two-lobe");
    const Key& g2 = number("g2", Range::between(-1, 1), {}, "Needed: of the second lobe.").onlyFor("two-lobe");
    const Key& blend = number("blend", Range::fromTo(0, 1), 0.5, "Weight of the second lobe.").onlyFor("two-lobe");
};

struct OctavesKeys : Section {
    OctavesKeys()
        : Section("octaves", "octaves = { ... } of [volume.medium]",
                  "The look of multiple scattering: octave n adds single scattering with thinner shadows. With "
                  "contribution <= extinction no octave makes light.") {}
    const Key& count = integer("count", 1, 16, "", 8, "1 is single scattering.");
    const Key& extinction =
        number("extinction", Range::fromTo(0, 1), 0.5, "Extinction towards the light, times this each octave.");
    const Key& contribution = number("contribution", Range::fromTo(0, 1), 0.5, "Light, times this each octave.");
    const Key& phase = number("phase", Range::fromTo(0, 1), 0.5, "Mean cosines, times this each octave.");
};

struct EmissionKeys : Section {
    EmissionKeys()
        : Section("emission", "emission = { ... } of [volume.medium]",
                  "Radiance per world unit = ramp(grid value) * scale, whatever the density. It lights volumes whose "
                  "scattering = \"full\".") {}
    const Key& grid = text("grid", "the name of a grid", "What glows.").required();
    const Key& scale = number("scale", Range::fromTo(0, 1e30), 1, "Times this.").keyed();
    const Key& ramp =
        other("ramp", "a list of at least two [grid value, colour]", R"({"type":"array","minItems":2})", {},
              "From grid value to colour: ascending, linear between, constant outside, black at 0. The value itself, "
              "in white, unless given.");
};

struct BlackbodyKeys : Section {
    BlackbodyKeys()
        : Section("blackbody", "blackbody = { ... } of [volume.medium]",
                  "Fire: light of a black body of the grid's temperature (Planck's law through the CIE's observer). It "
                  "lights volumes whose scattering = \"full\". Nothing glows below about 700 K. Caches of Houdini, "
                  "Blender and EmberGen hold about 0 to 1 and not Kelvin: say with 'kelvin' what that is.") {
        exclude({&kelvin}, {&scale, &offset});
    }
    const Key& grid = text("grid", "the name of a grid", "The temperature.").required();
    const Key& kelvin =
        other("kelvin", "two temperatures [of grid value 0, of grid value 1] in Kelvin", kTwoNumbers,
              Range::fromTo(-1e6, 1e6, "Kelvin"), "Fire: [500, 1900]. In place of 'scale' and 'offset'.");
    const Key& scale =
        number("scale", Range::fromTo(1e-9, 1e9, "Kelvin"), 1, "Kelvin = grid value * scale + offset.").keyed();
    const Key& offset = number("offset", Range::fromTo(-1e6, 1e6, "Kelvin"), 0, "See 'scale'.").keyed();
    const Key& intensity =
        number("intensity", Range::fromTo(0, 1e30), 1,
               "Radiance per world unit = this * sigma T^4 / pi in MW/(m^2 sr), which is 0.09 at 1500 K.")
            .keyed();
    const Key& normalize = boolean("normalize", false,
                                   "All temperatures equally bright, so that only colour changes. False: the fourth "
                                   "power of temperature, as it is.");
};

/// The most that a part of an extinction tint may be, and of the colours of a ramp.
inline constexpr double kMostTint = 1e6, kMostLight = 1e30;

struct MediumKeys : Section {
    MediumKeys()
        : Section("medium", "[volume.medium]", "What the volume above it does to light: smoke, clouds, fire.") {}
    const Key& albedo =
        colour("albedo", "[0.9, 0.9, 0.9]", "Scattered part of extinction, 0 to 1; or a grid of colours.")
            .orTable(keysOf<AlbedoGridKeys>());
    const Key& extinctionTint = colour("extinction_tint", "[1, 1, 1]", "Multiplies extinction in each channel.");
    const Key& phase = table(keysOf<PhaseKeys>(), "phase", "Which way it scatters.").unless("isotropic");
    const Key& scattering =
        choice("scattering", {"single", "octaves", "full"},
               "How often light scatters on its way: once; with the look of more, by 'octaves'; as often as it does, "
               "which also lets what glows, [ambient] and domes light the volume, with shadows.")
            .unless("\"single\", or \"octaves\" where these are given");
    const Key& octaves =
        table(keysOf<OctavesKeys>(), "octaves", "The look of multiple scattering.").unless("single scattering");
    const Key& emission = table(keysOf<EmissionKeys>(), "emission", "Light of its own, from a grid by a ramp.");
    const Key& blackbody = table(keysOf<BlackbodyKeys>(), "blackbody", "Light of its own, from temperature.");
};

struct TransferKeys : Section {
    TransferKeys()
        : Section("transfer", "transfer = [ { ... }, ... ] of [volume.classified]",
                  "Points of a transfer function: linear between, constant outside; two of one value are a step.") {}
    const Key& value = number("value", {}, {}, "Of the grid.").required();
    const Key& color = colour("color", "[1, 1, 1]", "What it looks like.");
    const Key& extinction =
        number("extinction", Range::fromTo(0, 1e30, "per world unit"), {}, "Times the density's 'scale'.").required();
};

struct ClassifiedKeys : Section {
    ClassifiedKeys()
        : Section("classified", "[volume.classified]",
                  "Scans and surfaces, in place of a medium: a transfer function, and Phong shading by gradients (ZC02 "
                  "section 3.1).") {}
    const Key& transfer = other("transfer", "a list of { value, color, extinction }",
                                R"({"type":"array","minItems":2,"items":{"$ref":"#/$defs/transfer"}})", {},
                                "At least two points, ascending, without extinction at 0.")
                              .required()
                              .orTable(keysOf<TransferKeys>());
    const Key& ambient = number("ambient", Range::fromTo(0, 1e6), 0.2, "Share of ambient light.");
    const Key& diffuse = number("diffuse", Range::fromTo(0, 1e6), 0.7, "Share of light that a surface scatters.");
    const Key& specular = number("specular", Range::fromTo(0, 1e6), 0.3, "Share of the highlight.");
    const Key& exponent = number("exponent", Range::fromTo(0, 1e4), 20, "How small the highlight is.");
    const Key& twoSided = boolean("two_sided", false, "Does light from behind a surface count?");
};

struct MeshKeys : Section {
    MeshKeys()
        : Section("mesh", "[[mesh]]",
                  "A solid of triangles, which another renderer draws: here it hides the volumes, takes light from "
                  "them, and shows their shadows. An open surface acts from both sides.") {}
    const Key& name =
        text("name", "a name", "For messages, and --set mesh.NAME.shadows=false.").unless("\"mesh1\", ...");
    const Key& file = path("file", "an .obj or .ply file", "\"actor.####.obj\" is a sequence.").required();
    const Key& transform = table(keysOf<TransformKeys>(), "transform", "Where it stands.");
    const Key& holdout = boolean("holdout", true, "Does it hide what is behind it? It adds neither colour nor alpha.");
    const Key& shadows = boolean("shadows", true, "Does it throw shadows into volumes?");
    const Key& catches =
        boolean("catch", false,
                "Does it show the shadows of volumes? The picture then has layers 'shadow.LIGHT': what "
                "part of each light reaches the first such surface; 1 where there is none.");
};

struct VolumeKeys : Section {
    VolumeKeys()
        : Section("volume", "[[volume]]",
                  "At least one: a .vdb file or sequence, or a source that makes or reads something else (`scrim make "
                  "--list`).") {
        exclude({&source, &parameters}, {&file, &frame, &velocity});
        exclude({&medium}, {&classified});
    }
    const Key& name = text("name", "a name", "For messages, layers and --set volume.NAME.density.scale=3.")
                          .unless("\"volume1\", ...");
    const Key& file =
        path("file", "a .vdb file, or 'source', the name of a volume source", "\"smoke.####.vdb\" is a sequence.");
    const Key& frame = table(keysOf<FrameKeys>(), "frame", "Which file of a sequence is shown.").onlyFor("'file'");
    const Key& source = text("source", "the name of a volume source", "\"noise\", \"scan\", ...; in place of 'file'.");
    const Key& parameters =
        other("parameters", "a table", kAnyTable, {},
              "Of the source: `scrim make SOURCE --help-source` lists them. 'file' is a path like all others.")
            .onlyFor("'source'");
    const Key& transform = table(keysOf<TransformKeys>(), "transform", "Where it stands.");
    const Key& density = table(keysOf<DensityKeys>(), "density", "Which grid, and how dense.");
    const Key& velocity =
        table(keysOf<VelocityKeys>(), "velocity", "How it moves while the shutter is open.").onlyFor("'file'");
    const Key& lights = other("lights", "a list of names of lights", kStrings, {},
                              "Those that light it. What does not light it is still shadowed by it.")
                            .unless("all");
    const Key& holdout =
        boolean("holdout", false,
                "Does it hide and shadow, and add neither colour nor alpha? So it is where another picture shows it.");
    const Key& medium = table(keysOf<MediumKeys>(), "medium", "Smoke, clouds, fire.");
    const Key& classified = table(keysOf<ClassifiedKeys>(), "classified", "Scans and surfaces, in place of 'medium'.");
};

}  // namespace scrim
