// SPDX-License-Identifier: Apache-2.0
// A light on one sheet, and its slide filtered over a tile of samples there.
//
// A sample does not represent a point: it is as wide as the distance between samples, and as long as the path of the
// eye's ray through the sheet. A ray marcher would see the slide's average along that path, and so does this: the
// footprint on the slide is the flattened parallelepiped of the two spacings and the ray's segment. Its covariance (a
// box of edge e has e^2 / 12) gives a long and a short axis. Several taps along the long axis are averaged; the short
// axis selects the level of the mip pyramid (trilinear between levels). A footprint smaller than a pixel of the slide
// needs no filter, so magnified slides stay sharp. The picture's border is sharp whatever the size of its pixels: a tap
// counts in proportion to the part of its box that lies inside.
#pragma once

#include <scrim/base/real.h>
#include <scrim/base/simd.h>
#include <scrim/engine/model/eye_view.h>
#include <scrim/engine/model/sub_lights.h>
#include <scrim/image/light_profile.h>
#include <scrim/scene/slide_map.h>

#include <optional>
#include <span>
#include <variant>
#include <vector>

namespace scrim {

/// A slide on one sheet; without an image there is none.
struct SheetSlide {
    const Texture* image = nullptr;
    SlideOutside outside = SlideOutside::black;
    SlideMap::OnSheet map;
    Simd simd = {};
};

/// Writes 3 x 256 floats, all reds first: the factor on the light's intensity. Returns false, and writes nothing, if
/// that is 0 for all samples. `toTexels`: texels per sheet, which converts slopes du/dw to texels.
bool tintTile(const SheetSlide& slide, const SampleTile& samples, Real toTexels, Real* tint);

/// A distant light on a sheet.
struct DistantOnSheet {
    Real slopeA = 0, slopeB = 0;  ///< du/dw, dv/dw
};

/// A light on a sheet that shines from a point, and what limits it.
struct NearOnSheet {
    /// A spot fades between these cosines to its axis.
    struct Cone {
        Real cosOuter, cosInner;
    };
    /// An element of a surface: irradiance has the cosine to its axis as factor, and is 0 behind it.
    struct Face {
        Real spreadTangent, spreadScale;  ///< see Spread; scale 0: none
    };
    /// Of a luminaire.
    struct Profile {
        const LightProfile* table;
        Vec3 frame[3];  ///< its axes right, up and along the light
    };
    /// Windows divide a light close to the volume into overlapping parts. The share of this part in
    /// a direction is its window's value there over the sum of all windows.
    struct Window {
        const std::vector<Vec3>* axes;  ///< of all windows
        int number;                     ///< of this part's window among them
        Real cosEdge;                   ///< a window falls to 0 at this cosine to its axis
    };

    Real texelU = 0, texelV = 0;           ///< position of the source, in texels
    Real distanceW = 0;                    ///< to the middle, along w, of what it lights of the sheet, world units, > 0
    Real plane = 0;                        ///< from that middle to the middle of the sheet along w, world units
    Real radius2 = 0;                      ///< world units squared, > 0 if the light decays
    Real ownRadius2 = 0;                   ///< the same, however thick the sheet is
    bool decay = true;                     ///< with the square of the distance
    Real axisU = 0, axisV = 0, axisW = 1;  ///< for cones and faces
    Real slideAngle = 0;                   ///< half the angle between opposite corners of its slide, radians; 0: none
    bool slideEnds = false;                ///< it is black beyond its slide
    std::optional<Cone> cone = {};
    std::optional<Profile> profile = {};
    std::optional<Face> face = {};
    std::optional<Window> window = {};
};

/// A light on one sheet. Directions are in sweep space, along which the light travels with +w.
struct SheetLight {
    std::variant<DistantOnSheet, NearOnSheet> source;
    bool shadowed = true;
    bool withinSheet = true;  ///< includes attenuation by the sheet itself
    /// What a sub-light stands for: if it is distant the half angle of a cap, else the area of a
    /// surface, world units squared; 0: it is a light of its own.
    Real part = 0;
    Real intensity[3] = {1, 1, 1};
    int output = 0;  ///< output that receives its light: a part of the beauty, or the beauty
    PlanLight index{};
    std::span<const int> channels = {};  ///< the extinction channels that attenuate it, if shadowed
    SheetSlide slide;

    const DistantOnSheet* distant() const { return std::get_if<DistantOnSheet>(&source); }
    const NearOnSheet* near() const { return std::get_if<NearOnSheet>(&source); }

    /// The slopes (du/dw, dv/dw) of its ray that crosses the sheet's plane at (u, v), in texels of edge `texel`.
    Vec2 slopesAt(double u, double v, double texel) const {
        if (const DistantOnSheet* sun = distant()) return {sun->slopeA, sun->slopeB};
        const NearOnSheet& lamp = *near();
        return {(u - lamp.texelU) * texel / lamp.distanceW, (v - lamp.texelV) * texel / lamp.distanceW};
    }
};

}  // namespace scrim
