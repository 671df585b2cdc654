// SPDX-License-Identifier: Apache-2.0
// The same scene in another way, or a part of it: what laws compare with.
#pragma once

#include <scrim/scene/view_scene.h>

#include <functional>
#include <vector>

namespace scrim::test {

/// The scene with only these of its lights, in this order; one may be there twice.
ViewScene withLights(const ViewScene& scene, const std::vector<std::size_t>& lights);
/// With volumes and lights from the last to the first.
ViewScene reversed(const ViewScene& scene);
/// Without ambient light and emission.
ViewScene withoutOtherLight(ViewScene scene);
/// With `factor` times the density and emission of volume `v`.
void scaleDensity(ViewVolume& volume, double factor);
/// In a picture twice as wide, with copies of the first volume on both sides of it: sheets of more tiles.
ViewScene inARow(ViewScene scene);
/// The whole scene under p -> scale * (axes p) + shift, with what makes it look the same: extinction and emission over
/// `scale`, intensities of lamps times its square. `axes` is orthonormal; if it is left-handed, the picture is mirrored
/// from left to right.
ViewScene movedScene(const ViewScene& scene, double scale, const Mat3& axes, const Vec3& shift);
/// Red in place of blue, and blue in place of red, in all that has a colour.
ViewScene exchanged(const ViewScene& scene);
/// Solids that send back most of red and least of blue; null if `solids` is.
std::shared_ptr<const Solids> coloured(const std::shared_ptr<const Solids>& solids);
/// With texels, sheets and cells of half the size, and with twice as many points and directions.
ViewScene refined(ViewScene scene);
/// The picture from right to left.
Image mirrored(const Image& image);
/// Blue in place of red.
Image exchanged(const Image& image);

}  // namespace scrim::test
