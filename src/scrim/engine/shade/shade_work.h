// SPDX-License-Identifier: Apache-2.0
// Counts of what shading did. Passes over a tile count themselves, once a tile, so that a pass that is not run is
// seen to be absent, and loops over samples know nothing of it.
#pragma once

#include <cstdint>

namespace scrim {

struct ShadeWork {
    std::uint64_t samples = 0;       ///< shaded: texels, or points where pixels' rays meet sheets
    std::uint64_t lightLookups = 0;  ///< light and sample pairs
    std::uint64_t slideLookups = 0;
    std::uint64_t phases = 0;        ///< evaluations of a phase function that is not isotropic
    std::uint64_t octaves = 0;       ///< light and sample pairs of octaves beyond the first
    std::uint64_t gradients = 0;     ///< normals of classified volumes
    std::uint64_t emissions = 0;     ///< samples of emission
    std::uint64_t ambients = 0;      ///< samples of ambient light
    std::uint64_t exponentials = 0;  ///< of optical depths

    ShadeWork& operator+=(const ShadeWork& o) {
        samples += o.samples;
        lightLookups += o.lightLookups;
        slideLookups += o.slideLookups;
        phases += o.phases;
        octaves += o.octaves;
        gradients += o.gradients;
        emissions += o.emissions;
        ambients += o.ambients;
        exponentials += o.exponentials;
        return *this;
    }
    bool operator==(const ShadeWork&) const = default;
};

}  // namespace scrim
