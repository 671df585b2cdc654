// SPDX-License-Identifier: Apache-2.0
// How coloured extinction is kept: not as three numbers everywhere, but as one row of numbers for each tint that the
// scene has, so that sheets and shadow buffers are scalar whatever the colours are.
#pragma once

#include <scrim/scene/view_scene.h>

#include <vector>

namespace scrim {

/// Extinction in channel c = sum over rows of (row's value) * tints[row][c]. A scene without colours has one row of white.
/// One of up to three tints has a row a tint; one of more has the rows red, green and blue.
struct ExtinctionRows {
    bool coloured = false;
    std::vector<Rgb> tints{Rgb(1)};
    /// A volume's part in a row: its extinction in the channel that has most, times `weight`.
    struct Share {
        int row = 0;
        float weight = 1;
    };
    std::vector<std::vector<Share>> shares;  ///< for each volume of the scene

    int count() const { return static_cast<int>(tints.size()); }
};

ExtinctionRows extinctionRows(const ViewScene& scene);

}  // namespace scrim
