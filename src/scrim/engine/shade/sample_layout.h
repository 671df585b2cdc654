// SPDX-License-Identifier: Apache-2.0
// What a shaded sample holds: the floats that compositing carries along a ray.
#pragma once

namespace scrim {

/// Quads of floats, one for each picture, and how much the sample hides of what lies behind it. Where extinction is grey
/// every quad is (S.rgb, -alpha). Where it is `coloured` quads are (S.rgb, 0), and one quad of opacities that all share
/// follows: (-alpha.rgb, -the least of the three). Compositing comes in these two kinds, whatever pictures there are and
/// whatever later effects will make of them.
///
/// Picture 0 is the beauty, and the others are numbered from 1 on. Without `beauty` it has no quad of its own: all that it
/// consists of has one, and it is added up once the pixels are done.
struct SampleLayout {
    int pictures = 1;
    bool coloured = false;
    bool beauty = true;

    /// Which quad holds a picture.
    int quadOf(int picture) const { return beauty ? picture : picture - 1; }
    int pictureQuads() const { return quadOf(pictures); }
    int quads() const { return pictureQuads() + (coloured ? 1 : 0); }
    int floats() const { return 4 * quads(); }
    bool operator==(const SampleLayout&) const = default;
};

}  // namespace scrim
