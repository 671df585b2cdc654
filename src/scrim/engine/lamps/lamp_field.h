// SPDX-License-Identifier: Apache-2.0
// The light of one lamp on cells. Near a lamp irradiance, transmittance and direction change fast, but the mean
// extinction on the way from it changes slowly. So that is what cells keep, and look-ups compute the three from it,
// with the mean of 1/r^2 over the eye's path through a sheet.
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
#include <optional>

namespace scrim {

/// What a lamp lights.
struct LampView {
    Light lamp;   ///< a point light, or a sphere
    Phase phase;  ///< towards the camera
    Camera camera;
    double extinction = 1;   ///< factor on the extinction that the light passes (see Octaves)
    bool attenuated = true;  ///< volumes hold its light back
    bool nearby = false;     ///< only near the lamp, because cells that many lamps share keep its light farther away
};

class LampField {
  public:
    LampField(const LampView& view, std::shared_ptr<const CellGrid> grid, int colours);

    const Light& lamp() const { return m_view.lamp; }
    /// What cells keep: first the transmittance from the lamp, after makeMean the mean extinction, per world unit.
    CellField& values() { return m_values; }
    const CellField& values() const { return m_values; }
    /// Replaces the transmittance t that is kept by the mean extinction on the way from the lamp, -log(t) / (length of
    /// the way). `media`: what dims the light near the surface of a sphere. There the light comes from so many sides
    /// that the lamp's points do not represent it, and the extinction is computed anew. `open`: the fraction of the
    /// light that passes solids; null: there are no solids.
    void makeMean(const MediaTogether& media, std::shared_ptr<const CellField> open);
    /// The lamp's light at a point, with a transmittance of the way there, but for the part that is kept near the lamp.
    Rgb farLight(const Vec3& ws, double transmittance) const;
    /// What farLight gives beyond `reach` (world units) without attenuation, times the square of the distance, if it
    /// depends on no more than that; none: it does.
    std::optional<Rgb> evenFarLight(double& reach) const;

    /// True if the field has light in the box.
    bool reaches(const Bounds& ws) const;
    /// Adds the light at a point.
    void addTo(const Vec3& ws, Real (&rgb)[3]) const;
    /// Adds the light at a tile of samples, as CellField::lookUp.
    void addTo(const SamplePlane& plane, const SampleTile& samples, const Real* extinction, Real* const rgb[3]) const;

    std::size_t bytes() const { return m_values.bytes(); }

  private:
    double wayTo(const Int3& cell) const;
    void keepNearSphere(const MediaTogether& media, const Vec3& ws, Real* values) const;
    double nearShare(double r) const;
    double factor(const Vec3& ws) const;
    double decay(double r2) const;
    void lightAt(const Vec3& ws, double part, Real (&rgb)[3]) const;
    double meanProfile(const Vec3& way, const Vec3& path) const;
    double meanDecay(const Vec3& way, const Vec3& path) const;
    double meanNearSphere(const Vec3& way, const Vec3& path, double extinction) const;
    double meanOnPath(const Vec3& way, const Vec3& path, double extinction) const;

    LampView m_view;
    CellField m_values;
    Mat3 m_frame{1.0};  // of its luminaire
    std::shared_ptr<const CellField> m_open;
    double m_near = 0;                            // `nearby`: how far its cells reach, world units; 0: everywhere
    bool m_hollow = false;                        // the lamp is a sphere whose light begins at its surface
    std::shared_ptr<const PhaseOverCaps> m_caps;  // of a sphere, which fills a cone; null: of a point, or isotropic
};

/// Takes from the mean extinctions of a field, each on the way of `wayTo` to a cell, what linear interpolation and
/// cells add in the mean: a twelfth of the second differences each, the latter because extinction is the mean over a
/// cell, and again over cells beside a ray. Neighbours that are dark, or have no way, do not count.
void sharpenMeans(CellField& field, const std::function<double(const Int3& cell)>& wayTo);

}  // namespace scrim
