// SPDX-License-Identifier: Apache-2.0
// The cubes of a lattice that solids pass.
#pragma once

#include <scrim/solid/solids.h>

#include <functional>
#include <utility>

namespace scrim {

/// Calls visit(cube) for those cubes of a lattice, `edge` world units wide and with a corner at
/// `wsCorner`, that a solid which casts shadows passes within `reach`, at least once for each.
/// `range`: the box of cubes that count, first and last, for each solid.
void forCubesAt(const Solids& solids, double edge, const Vec3& wsCorner, double reach,
                const std::function<std::pair<Int3, Int3>(const Solid&)>& range,
                const std::function<void(const Int3&)>& visit);

}  // namespace scrim
