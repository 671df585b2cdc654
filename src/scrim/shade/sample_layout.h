// SPDX-License-Identifier: Apache-2.0
// What a shaded sample holds: the floats that compositing carries along a ray.
#pragma once

namespace scrim {

/// One picture, the beauty, or several, and how much a sample hides of what lies behind it.
///
/// Narrow: 4 floats, (S.rgb, -alpha), one picture under one opacity. Wide: a quad (S.rgb, 0) for each picture, then the
/// quad of opacities (-alpha.rgb, -the least of the three), which all pictures share. Loops are instantiated on the
/// two, not on what the pictures are of: however many effects there will be, compositing comes in two kinds.
struct SampleLayout {
    int pictures = 1;
    bool wide = false;

    int quads() const { return wide ? pictures + 1 : 1; }
    int floats() const { return 4 * quads(); }
    bool operator==(const SampleLayout&) const = default;
};

}  // namespace scrim
