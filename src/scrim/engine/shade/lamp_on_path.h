// SPDX-License-Identifier: Apache-2.0
// A light that shines from a point, over the path of the eye's ray through a sheet. The border of a cone and a profile
// are directions that the light sees, and close to it a sheet fills many of them: a beam thinner than a sheet would be
// missed, or as thick as the sheet, by its value in the middle. So the mean over the path is taken by the angle under
// which the light sees it, in which its 1/r^2 is even and a cone has known borders. Close to any such light the angle
// by which it is scattered turns, too, in no more than a sheet.
#pragma once

#include <scrim/engine/light/sheet_light.h>
#include <scrim/engine/model/eye_view.h>
#include <scrim/scene/medium.h>

#include <cmath>
#include <functional>

namespace scrim {

class LampOnPath {
  public:
    /// `texel`: world units, as the sheet's thickness. `light` must outlive this object.
    LampOnPath(const NearOnSheet& light, Real texel, Real thickness);

    /// True if anything limits the light.
    bool limited() const { return m_limited; }
    /// False if the light is even on all paths.
    bool changes(const SampleTile& samples) const;
    /// How the light differs along a sample's path: so little that its value in the middle tells all, so much that the
    /// mean over the path is to be asked, or it does not arrive anywhere on it.
    enum class Course { even, changing, dark };
    Course courseOf(const SampleTile& samples, int k) const;

    /// What the sheet leaves of the light until the eye sees it.
    struct Passage {
        double extinction = 0;   ///< per world unit
        bool attenuated = true;  ///< it dims the light before it is scattered, and not only after
        bool sameSide = true;    ///< eye and light meet the same side of the sheet first
        double entry = 0;        ///< the optical depth before the sheet of light that comes to the middle of the path
    };
    struct Mean {
        /// Relative to the intensity on a sheet, which is as much smaller as the part of the sheet in front of the
        /// light is. Of what is seen of it, relative to what is seen of even light that comes along the slopes below.
        double irradiance = 0;
        double a = 0, b = 0;  ///< the slopes of the light's ray that meets the middle of what is lit
    };
    Mean over(const SampleTile& samples, int k, const Passage& passage) const;
    /// The mean of a phase function over the path of sample k, weighted by what is seen of the light.
    double phaseOver(const SampleTile& samples, int k, const Passage& passage, const Phase& phase) const;

    /// The means, weighted by the light, of what else the light meets on the paths of those samples that are `wanted`:
    /// of what `meets` writes to kTileSize values for each of `rows`, at most kMostRows. It is asked for parts of these
    /// paths, which lie within a cone, spread or slide. `means` has the same rows; other samples' are 0. False, and
    /// nothing is asked, if the light sees only little of all these paths.
    static constexpr int kMostRows = 3;
    bool average(const SampleTile& samples, const bool (&wanted)[kTileSize], int rows,
                 const std::function<void(const SampleTile& part, Real* values)>& meets, Real* means) const;

  private:
    // The part of the eye's ray that lies in a sheet, by where it crosses the plane of the sample and how steeply.
    struct Path {
        double u, v;        // texels
        double eyeA, eyeB;  // slopes du/dw, dv/dw
        double plane;       // of the sample, from the sheet's middle along w, world units
        double half;        // half of the part's thickness along w, world units
    };
    // A path in the plane of the light: at the angle t from its nearest point it is nearest / cos(t) away.
    struct Ray {
        Vec3 at, along, across;
        double slant, low, high;  // along w, from the sample
        double half;              // of Path
        double entry;             // where the light enters the sheet, along w, from the sample
        double before, nearest;
        double borders[4];  // angles between which light is cut off, whole, and cut off again
        bool lit = false;
        double place(double t) const { return (nearest * std::tan(t) - before) / slant; }
    };
    // A part of the samples' paths.
    struct Part {
        SampleTile samples;
        Real parts[kTileSize], places[kTileSize];  // SampleTile::part and ::at
        Real light[kTileSize];                     // what arrives there, relative to other parts
    };
    void takePart(const SampleTile& samples, const Ray* rays, int i, int count, Part& out) const;
    Path pathOf(const SampleTile& samples, int k) const;
    Vec3 fromLight(const Path& path) const;
    Ray rayOf(const Path& path) const;
    double sent(const Ray& ray, double t) const;
    int piecesOf(const Ray& ray, double width, double lobe) const;
    template <class Visit>
    void forPoints(const Ray& ray, const Passage& passage, double lobe, const Visit& visit) const;

    const NearOnSheet& m_light;
    Vec3 m_axis;
    double m_texel, m_thickness, m_plane, m_least;
    double m_inFront;                   // the part of the sheet that is in front of the light
    double m_outer = -1, m_inner = -1;  // cosines of the border of what is lit, and of that of what is fully lit
    double m_even;                      // the angle, radians, within which what the light sends changes little
    bool m_limited;
    double m_step = 0;  // the angle within which a profile is nearly linear; 0: the light has none
};

}  // namespace scrim
