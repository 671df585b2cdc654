// SPDX-License-Identifier: Apache-2.0
// The effects that a scene needs and does not need, each with its reason and the lines of the scene that caused it.
// They depend only on the scene and its plan. An effect that is off costs nothing: no buffer, no splat, no loop.
// Each is a pass, a channel or a layout of its own, so that none doubles the loops of others. For example, volumes that
// are held out are extinction channels like any other (plan.h), whose media have no albedo (SheetShader); solids that
// hide end rays in the compositor (cutSlab in compositor.cpp), as the near plane begins them.
#pragma once

#include <scrim/engine/plan/make_plan.h>

#include <string>
#include <vector>

namespace scrim {

struct Effect {
    std::string name;
    bool on = false;
    std::string reason;  ///< one line, without the places in the scene
    /// The places in the scene's text that decided it: "scene.toml:12:3"; empty: the text does not mention it.
    std::vector<std::string> where;
};

std::vector<Effect> effectsOf(const ViewScene& scene, const Plan& plan);

/// The lights whose shadow rasters are coarser than the dial `shadow_texel` says, because these
/// have a largest size: "'sun' 1.6 times, 'key' 2 times"; empty: none.
std::string coarserRasters(const ViewScene& scene, const Plan& plan);

}  // namespace scrim
