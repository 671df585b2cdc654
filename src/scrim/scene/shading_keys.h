// SPDX-License-Identifier: Apache-2.0
// The part of the table of keys (scene_keys.h) that is about shading.
#pragma once

#include <scrim/scene/scene_key.h>
#include <scrim/scene/scene.h>

namespace scrim {

struct RemapKeys : SectionOf<Remap> {
    RemapKeys()
        : SectionOf("remap", "remap = { ... } of density",
                    "Maps the grid's values from one range to another, before 'ramp'. Values outside of the range "
                    "count as its nearest limit.") {}
    const Key& from = other("from", "two numbers [low, high]", kTwoNumbers, Range::fromTo(-1e30, 1e30),
                            "The range of the grid's values; ascending.")
                          .unless("[0, 1]");
    const Key& to = other("to", "two numbers", kTwoNumbers, Range::fromTo(0, 1e30),
                          "What they become; the grid value 0 has to become 0.")
                        .unless("[0, 1]");
    const Key& gamma = number("gamma", Range::aboveTo(0, 100), &Remap::gamma,
                              "Above 1 lifts the middle of the range, below 1 lowers it: t becomes t^(1 / gamma).");
    const Key& contrast = number("contrast", Range::aboveTo(0, 100), &Remap::contrast,
                                 "Above 1 moves values away from the middle of the range, below 1 towards it.");
};

struct MaskKeys : Section {
    MaskKeys()
        : Section("mask", "mask = { ... } of density, emission or blackbody",
                  "A factor from another grid of the volume.") {}
    const Key& grid = text("grid", "the name of a grid", "The grid that masks.").required();
    const Key& from = other("from", "two numbers [low, high]", kTwoNumbers, Range::fromTo(-1e30, 1e30),
                            "The range of its values; ascending.")
                          .unless("[0, 1]");
    const Key& to = other("to", "two numbers", kTwoNumbers, Range::fromTo(0, 1e30),
                          "The factors at both ends; [1, 0] inverts the mask.")
                        .unless("[0, 1]");
};

struct NoiseKeys : SectionOf<Noise> {
    NoiseKeys()
        : SectionOf("noise", "noise = { ... } of density; displacement = { ... } of a [[volume]]",
                    "A sum of gradient noises, about -1 to 1. It depends on the place alone, so that it does not jump "
                    "from frame to frame.") {}
    const Key& amount = number("amount", Range::fromTo(-1e15, 1e15), &Noise::amount,
                               "Of a density: its strength, see 'noise_mode'. Of a displacement: world units of the "
                               "asset (or of the scene, see 'space').")
                            .keyed();
    const Key& frequency = number("frequency", Range::aboveTo(0, 1e9, "per world unit"), &Noise::frequency,
                                  "Features per world unit, in the first octave.");
    const Key& octaves = integer("octaves", 1, 16, "", &Noise::octaves,
                                 "Number of octaves, each finer and fainter than the one before.");
    const Key& roughness = number("roughness", Range::fromTo(0, 1), &Noise::roughness,
                                  "Amplitude of an octave, relative to the one before.");
    const Key& lacunarity = number("lacunarity", Range::fromTo(1, 16), &Noise::lacunarity,
                                   "Frequency of an octave, relative to the one before.");
    const Key& offset =
        vector("offset", "three numbers [x, y, z]", Range::coordinate(), "Displaces the pattern, in world units.")
            .unless("[0, 0, 0]")
            .keyed();
    const Key& evolution = number("evolution", Range::fromTo(-1e9, 1e9), &Noise::evolution,
                                  "Changes the pattern in place; at the next whole number it is another one.")
                               .keyed();
    const Key& seed = integer("seed", 0, 1 << 30, "", &Noise::seed, "Chooses another pattern.");
    const Key& space = choice("space", {"volume", "world"}, &Noise::inWorld,
                              "The pattern moves with the volume, or rests in the scene's world while the volume "
                              "moves through it.");
};

}  // namespace scrim
