// SPDX-License-Identifier: Apache-2.0
// An extended light as a sum of lights that the engine knows: points of a surface, directions of the sun's disk or of
// the sky. Everything behind the plan sees these sub-lights and nothing else; what they light belongs to their owner.
//
// A sum of N sub-lights converges to the whole light where a blurred single shadow buffer does not. Their pattern is
// fixed to the light, so that it stays what it is from frame to frame.
#pragma once

#include <scrim/scene/view_scene.h>

#include <vector>

namespace scrim {

struct SubLights {
    std::vector<Light> lights;  ///< none extended; empty where no light of the scene is: then the scene's own count
    std::vector<int> owners;    ///< of each: index into the lights of the scene, ascending

    /// The scene's light that light `i` of the plan belongs to.
    int ownerOf(int i) const { return owners.empty() ? i : owners[std::size_t(i)]; }
    /// How many lights stand for light `owner` of the scene.
    int countOf(int owner) const;
};

/// The most that the dial light_error takes for one light.
inline constexpr int kMostSubLights = 1024;

/// How many sub-lights the scene's `light` asks for: its `samples`, or what the dial light_error needs.
int subLightCount(const ViewScene& scene, const Light& light);

/// All lights of the scene, each extended one as its sub-lights. Slides must be loaded. A pure function of the lights,
/// the dial light_error and the volumes' bounds.
SubLights subLights(const ViewScene& scene);

/// The scene with every extended light as about `count` lights, for a rough look at it. Pictures need not be loaded.
ViewScene withFewSubLights(const ViewScene& scene, int count);

/// The scene with the lights of the plan in place of its own; `plain` holds the changed copy where there are any.
const ViewScene& withSubLights(const ViewScene& scene, const SubLights& lights, ViewScene& plain);

/// Do skies shine into all that they light through the border of the cells that scatter light more than once, so that
/// no sub-lights stand for them?
bool skiesFromBorder(const ViewScene& scene);

}  // namespace scrim
