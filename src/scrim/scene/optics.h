// SPDX-License-Identifier: Apache-2.0
// What a volume does to light at a place: extinction, scattering and emission, computed from its fields and its medium.
// All code that follows single rays asks here (the reference, the path tracer, pilot rays, caught shadows). The
// engine's shading computes the same for many samples at once, from sheets (engine/shade).
#pragma once

#include <scrim/scene/view_scene.h>
#include <scrim/volume/field_sampler.h>

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <vector>

namespace scrim {

/// One sampler for each field, so that everything that looks at one scene shares them.
using FieldSamplers = std::map<const SparseField*, std::shared_ptr<const FieldSampler>>;

/// A field in world space. This type and those below may be used from many threads at once.
struct FieldInWorld {
    std::shared_ptr<const FieldSampler> field;
    Mat4 isFromWs{1.0};
    double isPerWs = 0;  ///< upper bound on the index-space length of a world unit

    /// Takes the field's sampler from `samplers` and adds it there if it is missing. `view.field`
    /// must outlive `samplers`. `kernel`: for a field that has none of its own.
    FieldInWorld(const ViewField& view, Kernel kernel, FieldSamplers& samplers);
    double value(const Vec3& ws) const { return field->value(transformPoint(isFromWs, ws)); }
};

/// True if the volume has a medium that scatters light, but not fully.
bool scattersOnce(const ViewVolume& volume);

/// The optics of one volume. Where velocities move its fields (ViewVelocity), all values are those of the moved fields.
class VolumeOptics {
  public:
    /// `volume` must outlive this.
    VolumeOptics(const ViewVolume& volume, Kernel kernel, FieldSamplers& samplers);

    const ViewVolume& volume() const { return *m_volume; }
    /// A volume without density has neither extinction nor scattering.
    bool hasDensity() const { return m_density.has_value(); }

    /// The density field's value, before any scale.
    double density(const Vec3& ws) const { return m_density ? m_density->value(origin(ws)) : 0; }
    /// Extinction coefficient, per world unit.
    Rgb extinction(const Vec3& ws) const;
    /// The extinction in the channel where it is largest.
    double mostExtinction(const Vec3& ws) const;
    /// What a classified volume with density shows at `ws`: by its transfer function and gradient, within its clip.
    ClassifiedValue classified(const Vec3& ws) const;
    /// Radiance per world unit that a classified volume reflects of a unit of irradiance (ZC02 eq.
    /// 3). `voxel`: as in shadingGradient.
    Rgb reflected(const Vec3& ws, double voxel, const Vec3& toLight, const Vec3& toEye) const;
    /// Scattering coefficient of a medium, or of a classified volume with Classified::scatters, per world unit.
    Rgb scattering(const Vec3& ws) const;
    /// Emitted radiance per world unit.
    Rgb emission(const Vec3& ws) const;
    /// Value of the field of ViewVolume::emission[i] at `ws`.
    double emissionField(std::size_t i, const Vec3& ws) const { return m_emission[i].value(origin(ws)); }
    /// Gradient of the density field, per world unit, by central differences over one voxel to either side.
    Vec3 gradient(const Vec3& ws) const;
    /// The same with that of the cut faces of a classified volume: they add cutGradient() at depths up to `voxel`.
    Vec3 shadingGradient(const Vec3& ws, double voxel) const;

    /// A radius, world units, around `ws` within which all fields are known to be 0; 0 where none is known.
    double emptyDistance(const Vec3& ws) const;
    /// How far a point can go from `ws` along `way`, in multiples of `way`, while extinction is known to be constant
    /// within `reach` world units of it; below 0 where it is not known to be constant at `ws`.
    double evenAlong(const Vec3& ws, const Vec3& way, double reach) const;

  private:
    // The place that the fields seen at `ws` were moved from.
    Vec3 origin(const Vec3& ws) const { return m_velocity.empty() ? ws : ws - wayTo(ws); }
    Vec3 wayTo(const Vec3& ws) const;

    const ViewVolume* m_volume;
    std::optional<FieldInWorld> m_density;
    std::vector<FieldInWorld> m_scatter, m_emission;  // in the order of ViewVolume
    // In the order of ViewVelocity::parts; always linear, whatever kernel the fields have.
    std::vector<FieldInWorld> m_velocity;
    Mat3 m_wsFromIs{1.0};  // of the density: its columns are the steps from voxel to voxel
    double m_mostWay = 0;  // longest displacement, world units
    double m_voxels = 0;   // the most voxels of the density grid that one world unit can span along an axis
};

/// Optical depth of each colour between two points in world space: of all volumes, or of those that cast shadows in
/// light `light` of the scene. By steps of at most `step`, world units, with two-point Gauss quadrature, which is exact
/// for the cubics that a trilinear field forms within a cell. `wsBounds`: a box that holds all volumes.
Rgb opticalDepth(const std::vector<VolumeOptics>& volumes, const Bounds& wsBounds, double step, const Vec3& wsA,
                 const Vec3& wsB, std::optional<std::size_t> light = {});

/// The optical depth of a volume's largest value over `distance` world units.
double mostDepth(const ViewVolume& volume, double distance);

/// A distance within which all fields of all volumes are known to be 0; 0 where none is known,
/// infinite without volumes.
double emptyDistance(const std::vector<VolumeOptics>& volumes, const Vec3& ws);

}  // namespace scrim
