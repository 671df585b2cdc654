// SPDX-License-Identifier: Apache-2.0
// Whether a scene is one that a file could have said. Files are checked as they are read, and say where what is wrong
// stands; what was built in code, or changed, comes here, and is held against the same table of keys.
#pragma once

#include <scrim/scene/scene.h>

namespace scrim {

/// Throws Error(input) "`scene.file`: light 'key': 'cone' is nan; expected a number ..." where a value lies outside of
/// its key's range or is no number, a ramp or transfer function could not be one of a file, a frame of axes is none, or
/// two things stand in the scene that do not go together.
void checkScene(const Scene& scene);

}  // namespace scrim
