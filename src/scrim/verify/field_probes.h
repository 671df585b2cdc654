// SPDX-License-Identifier: Apache-2.0
// Fields made ready to be sampled, which all that judges one scene shares.
#pragma once

#include <scrim/engine/splat/kernel.h>

#include <map>
#include <memory>

namespace scrim {

using FieldProbes = std::map<const SparseField*, std::shared_ptr<const FieldProbe>>;

/// That of `field`, which must outlive it; made where it is not there yet.
inline std::shared_ptr<const FieldProbe> probeOf(const SparseField& field, Kernel kernel, FieldProbes& probes) {
    std::shared_ptr<const FieldProbe>& probe = probes[&field];
    if (!probe || probe->kernel() != kernel) probe = std::make_shared<const FieldProbe>(field, kernel);
    return probe;
}

}  // namespace scrim
