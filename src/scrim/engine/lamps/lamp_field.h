// SPDX-License-Identifier: Apache-2.0
// The light of one lamp on cells. Near a lamp irradiance, transmittance and direction change fast,
// but the mean extinction on the way from it changes slowly. So that is what cells keep, and
// look-ups compute the three from it, with their mean over the eye's path through a sheet.
#pragma once

#include <scrim/engine/cells/cell_field.h>
#include <scrim/engine/cells/cell_walk.h>
#include <scrim/geometry/bounds.h>
#include <scrim/geometry/camera.h>
#include <scrim/scene/light.h>
#include <scrim/scene/medium.h>
#include <scrim/scene/phase_over_caps.h>

#include <functional>
#include <memory>
#include <numbers>
#include <optional>
#include <vector>

namespace scrim {

/// What a lamp lights.
struct LampView {
    Light lamp;                   ///< a point light, or a sphere
    std::vector<Octave> octaves;  ///< what the medium sends towards the camera, with descending extinctions
    Camera camera;
    bool attenuated = true;  ///< volumes hold its light back
    bool nearby = false;     ///< only near the lamp, because cells that many lamps share keep its light farther away
};

class LampField {
  public:
    LampField(const LampView& view, std::shared_ptr<const CellGrid> grid, int colours);

    const Light& lamp() const { return m_view.lamp; }
    /// What cells keep for some factors on extinction (see Octaves), between which octaves interpolate the mean
    /// extinction: of a sphere's light, which comes by many ways, it depends on that factor.
    struct Knot {
        double extinction;  ///< the factor
        CellField
            values;  ///< first the transmittance from the lamp, after makeMean the mean extinction, per world unit
    };
    std::vector<Knot>& knots() { return m_knots; }
    /// Replaces the transmittance t that is kept by the mean extinction on the way from the lamp, -log(t) / (length of
    /// the way). `media`: what dims the light near the surface of a sphere. There the light comes from so many sides
    /// that the lamp's points do not represent it, and the extinction is computed anew. `open`: the fraction of the
    /// light that passes solids; null: there are no solids.
    void makeMean(const MediaTogether& media, std::shared_ptr<const CellField> open);
    /// The lamp's light at a point, of the octaves that are nearest to a knot, with its
    /// transmittance of the way there; but for the part that is kept near the lamp.
    Rgb farLight(std::size_t knot, const Vec3& ws, double transmittance) const;
    /// What farLight gives beyond `reach` (world units) without attenuation, times the square of
    /// the distance, if it depends on no more than that; none: it does.
    std::optional<Rgb> evenFarLight(std::size_t knot, double& reach) const;

    /// True if the field has light in the box.
    bool reaches(const Bounds& ws) const;
    /// Adds the light at a point.
    void addTo(const Vec3& ws, Real (&rgb)[3]) const;
    /// Adds the light at a tile of samples, as CellField::lookUp.
    void addTo(const SamplePlane& plane, const SampleTile& samples, const Real* extinction, Real* const rgb[3]) const;

    std::size_t bytes() const;

  private:
    // An octave of the medium: its mean extinction is low * that of `knot` + high * that of the next one.
    struct Part {
        Octave octave;
        std::size_t knot = 0, nearest = 0;
        double low = 1, high = 0;
        std::shared_ptr<const PhaseOverCaps> caps;  // of a sphere, which fills a cone; null: of a point, or isotropic
    };
    static constexpr std::size_t kMostKnots = 3;
    using Means = Real[kMostKnots][3];
    // How the lamp shines at a place: the cosine towards the eye, the half angle that a sphere
    // fills there, a factor for its solid angle, the way of its light, and what solids let through.
    struct Arrival {
        double toEye, halfAngle, solidAngle, length, open;
    };

    const CellGrid& grid() const { return m_knots.front().values.grid(); }
    std::size_t colours() const { return m_knots.front().values.colours(); }
    double wayTo(const Int3& cell) const;
    void makeMean(Knot& knot, const MediaTogether& media) const;
    void keepNearSphere(const Knot& knot, const MediaTogether& media, const Vec3& ws, Real* values) const;
    double nearShare(double r) const;
    Arrival arrivalAt(const Vec3& ws) const;
    double scattered(const Part& part, const Arrival& arrival) const;
    double decay(double r2) const;
    void sampleAll(const Vec3& ws, CellField::LastBlock& last, Means& means) const;
    static void meanOf(const Part& part, const Means& means, Real (&mean)[3]);
    void lightOf(const Part& part, const Arrival& arrival, double profile, Real (&rgb)[3]) const;
    double leastRadius() const;
    double meanDecay(const Vec3& way, const Vec3& path) const;
    void addNear(const SamplePlane& plane, const SheetPath& path, double extinction, CellField::LastBlock& last,
                 Real (&rgb)[3]) const;

    LampView m_view;
    std::vector<Knot> m_knots;  // with descending factors
    std::vector<Part> m_parts;
    Mat3 m_frame{1.0};  // of its luminaire
    std::shared_ptr<const CellField> m_open;
    double m_near = 0;                 // `nearby`: how far its cells reach, world units; 0: everywhere
    bool m_hollow = false;             // the lamp is a sphere whose light begins at its surface
    bool m_even = true;                // all octaves scatter to all sides alike
    double m_lobe = std::numbers::pi;  // the width of their narrowest lobe, radians
};

/// Takes from the mean extinctions of a field, each on the way of `wayTo` to a cell, what linear interpolation and
/// cells add in the mean: a twelfth of the second differences each, the latter because extinction is the mean over a
/// cell, and again over cells beside a ray. Neighbours that are dark, or have no way, do not count.
void sharpenMeans(CellField& field, const std::function<double(const Int3& cell)>& wayTo);

}  // namespace scrim
