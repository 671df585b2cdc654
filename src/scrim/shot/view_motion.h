// SPDX-License-Identifier: Apache-2.0
// The data that the layer `motion` needs: the motion of everything in a view until the next frame.
#pragma once

#include <scrim/shot/assemble.h>
#include <scrim/shot/field_store.h>

namespace scrim {

/// True if the scene asks for the layer `motion`.
bool wantsMotion(const Scene& scene);

/// Fills in the motion of `view`, which shows `now`; `next` is the same scene one frame later by
/// its keyed values. Velocity grids come from `fields`. Fields derived from them count against the
/// view's memory limit. Does nothing where the layer is not wanted.
void addMotion(ViewScene& view, const Scene& now, const Scene& next, const Fields& fields);

}  // namespace scrim
