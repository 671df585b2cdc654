// SPDX-License-Identifier: Apache-2.0
// The effects that a scene needs and does not need, each with its reason and the lines of the scene that caused it.
// They depend only on the scene and its plan. An effect that is off costs nothing: no buffer, no splat, no loop.
//
// Notes for later effects:
//   holdouts               are volumes whose opacity counts and whose radiance does not: extinction channels like any
//                          other (plan.h), without a medium in SheetShader's list. A depth picture ends rays in the
//                          same way as the near plane starts them (cutSlab in compositor.cpp).
// Each is a pass, a channel or a layout of its own, so that none doubles the existing loops.
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

/// The lights whose shadow rasters are coarser than the dial `shadow_texel` says, because these have a largest size:
/// "'sun' 1.6 times, 'key' 2 times"; empty: none.
std::string coarserRasters(const ViewScene& scene, const Plan& plan);

}  // namespace scrim
