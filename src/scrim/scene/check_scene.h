// SPDX-License-Identifier: Apache-2.0
// Checks whether a scene could have come from a file. Files are checked while they are read, so that messages name the
// place of an error. Scenes that were built or changed in code are checked here, against the same table of keys.
#pragma once

#include <scrim/scene/scene.h>

namespace scrim {

/// Throws Error(input) "`scene.file`: light 'key': 'cone' is nan; expected a number ..." where a
/// value is out of its key's range or not a number, a ramp or transfer function is not one that a
/// file could hold, the camera's axes are not orthonormal, or two settings contradict each other.
void checkScene(const Scene& scene);

}  // namespace scrim
