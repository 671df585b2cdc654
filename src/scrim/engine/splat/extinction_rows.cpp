// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/splat/extinction_rows.h>

#include <algorithm>

namespace scrim {
namespace {

constexpr std::size_t kChannels = 3;

// Surfaces are grey: a transfer function has one extinction.
Rgb tintOf(const ViewVolume& volume) {
    return volume.classified ? Rgb(1) : volume.medium.relativeTint();
}

}  // namespace

ExtinctionRows extinctionRows(const ViewScene& scene) {
    ExtinctionRows rows;
    rows.tints.clear();
    for (const ViewVolume& volume : scene.volumes) {
        const Rgb tint = tintOf(volume);
        const auto known = std::find(rows.tints.begin(), rows.tints.end(), tint);
        rows.shares.push_back({{static_cast<int>(known - rows.tints.begin()), 1.0f}});
        if (known == rows.tints.end()) rows.tints.push_back(tint);
        rows.coloured = rows.coloured || tint != Rgb(1);
    }
    if (rows.tints.empty()) rows.tints.emplace_back(1);
    if (rows.tints.size() <= kChannels) return rows;

    rows.tints = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    for (std::size_t v = 0; v < scene.volumes.size(); ++v) {
        const Rgb tint = tintOf(scene.volumes[v]);
        rows.shares[v].clear();
        for (int c = 0; c < static_cast<int>(kChannels); ++c)
            if (tint[c] > 0) rows.shares[v].push_back({c, static_cast<float>(tint[c])});
    }
    return rows;
}

}  // namespace scrim
