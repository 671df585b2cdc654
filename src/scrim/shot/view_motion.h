// SPDX-License-Identifier: Apache-2.0
// What the layer `motion` has to know: where all of a view goes until the next frame.
#pragma once

#include <scrim/shot/assemble.h>
#include <scrim/shot/field_store.h>

namespace scrim {

/// Does the scene ask for the layer?
bool wantsMotion(const Scene& scene);

/// Fills in the motion of `view`, which is of `now`: `next` is the same scene a frame later, by its keys. A velocity
/// grid is that of `fields`. What is made of grids comes out of the view's memory limit. Does nothing where the layer
/// is not wanted.
void addMotion(ViewScene& view, const Scene& now, const Scene& next, const Fields& fields);

}  // namespace scrim
