// SPDX-License-Identifier: Apache-2.0
// What a scene needs and what it does not, each with its reason and the lines of the scene that brought it about. A
// pure function of the scene and its plan; what is off has cost nothing: no buffer, no splat, no loop.
//
// Where later effects go, and what they meet:
//   holdouts               are volumes whose opacity counts and whose radiance does not: extinction channels like any
//                          other (plan.h), without a medium in SheetShader's list. A depth picture to stop at
//                          is the rays' end, as the near plane is their start (cutSlab in compositor.cpp).
// Each is a pass, a channel or a layout of its own: none doubles the loops that there are.
#pragma once

#include <scrim/engine/plan/make_plan.h>

#include <string>
#include <vector>

namespace scrim {

struct Effect {
    std::string name;
    bool on = false;
    std::string reason;              ///< one line, without the places
    std::vector<std::string> where;  ///< of the scene's text that decided it: "scene.toml:12:3"; none: it is silent
};

std::vector<Effect> effectsOf(const ViewScene& scene, const Plan& plan);

}  // namespace scrim
