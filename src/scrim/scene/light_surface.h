// SPDX-License-Identifier: Apache-2.0
// The surfaces of area lights as triangles.
#pragma once

#include <scrim/scene/light.h>
#include <scrim/solid/triangle_mesh.h>

namespace scrim {

/// The surface of an area light in world space. Seen from where it shines, the corners of its
/// triangles are counterclockwise. Round shapes lie within 0.1 % of their radius.
TriangleMesh surfaceOf(const Light& light);

}  // namespace scrim
