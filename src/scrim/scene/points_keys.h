// SPDX-License-Identifier: Apache-2.0
// The part of the table of keys (scene_keys.h) that is about points.
#pragma once

#include <scrim/scene/scene_key.h>
#include <scrim/volume/point_cloud.h>

namespace scrim {

struct PointsKeys : SectionOf<PointLook> {
    PointsKeys()
        : SectionOf("points", "[volume.points]",
                    "How the points of a file become a density (dust, spray, embers): each is a ball, within which the "
                    "density is 1, or that of its attribute 'density'. Balls that overlap add up.") {}
    const Key& radius =
        number("radius", Range::aboveTo(0, 1e12, "world units of the file"), {}, "The radius of all points.")
            .unless("that of each: its attribute pscale, radius, or half of width");
    const Key& scale = number("scale", Range::aboveTo(0, 1e9), &PointLook::scale, "Factor on the radii.");
    const Key& voxel = number("voxel", Range::aboveTo(0, 1e12, "world units of the file"), {},
                              "The edge of voxels. Larger ones take less memory and show balls less sharp; what balls "
                              "add up to stays.")
                           .unless("half of the usual radius, or up to twice that radius where it takes much memory");
    const Key& weight =
        choice("weight", {"ball", "disc"}, &PointLook::discs,
               "A ball of density 1, or one that weighs as much as its disc: then points that are smaller than voxels "
               "take away the light that falls on their discs, at density.scale = 1.");
    const Key& sharp =
        boolean("sharp", false,
                "The picture shows the points themselves, each a ball of its own radius (or a disc) between the "
                "sheets, however large voxels are: those make shadows and scattered light alone.")
            .needed()
            .unless("true where points are far apart, or smaller than the voxels that are stated");
};

}  // namespace scrim
