// SPDX-License-Identifier: Apache-2.0
// What a volume does to light at a place: extinction, scattering and emission, from its fields and its look. All that
// follows single rays asks here (the reference, the path tracer, pilots, caught shadows). The engine's shading computes
// the same for many samples at once, from sheets (engine/shade).
#pragma once

#include <scrim/scene/view_scene.h>
#include <scrim/volume/field_sampler.h>

#include <array>
#include <map>
#include <memory>
#include <optional>
#include <vector>

namespace scrim {

/// Samplers by their fields, so that all that look at one scene share them.
using FieldSamplers = std::map<const SparseField*, std::shared_ptr<const FieldSampler>>;

/// A field in the world. Safe to use from many threads, as all below.
struct FieldInWorld {
    std::shared_ptr<const FieldSampler> field;
    Mat4 isFromWs{1.0};

    /// Takes the sampler of `samplers`, which gets it where it is not there yet. `view.field` must outlive that.
    FieldInWorld(const ViewField& view, Kernel kernel, FieldSamplers& samplers);
    double value(const Vec3& ws) const { return field->value(transformPoint(isFromWs, ws)); }
};

/// Extinction per world unit of a volume whose field has `value`.
Rgb extinctionOf(const ViewVolume& volume, double value);
/// The same in the channel that has most.
double mostExtinctionOf(const ViewVolume& volume, double value);

/// One volume. Where velocities move its fields (ViewVelocity), it is seen as they have moved it.
class VolumeOptics {
  public:
    /// `volume` must outlive this.
    VolumeOptics(const ViewVolume& volume, Kernel kernel, FieldSamplers& samplers);

    const ViewVolume& volume() const { return *m_volume; }
    /// Has it a density? Without one it has neither extinction nor scattering.
    bool hasDensity() const { return m_density.has_value(); }

    /// The density field's value, before any scale.
    double density(const Vec3& ws) const { return m_density ? m_density->value(origin(ws)) : 0; }
    /// Extinction coefficient, per world unit.
    Rgb extinction(const Vec3& ws) const { return m_density ? extinctionOf(*m_volume, density(ws)) : Rgb(0); }
    /// Scattering coefficient of a medium, per world unit.
    Rgb scattering(const Vec3& ws) const;
    /// Emitted radiance per world unit.
    Rgb emission(const Vec3& ws) const;
    /// Value of the field of ViewVolume::emission[i].
    double emissionField(std::size_t i, const Vec3& ws) const { return m_emission[i].value(origin(ws)); }
    /// Gradient of the density field, per world unit: central differences over a voxel on either side.
    Vec3 gradient(const Vec3& ws) const;

    /// A distance, world units, within which all fields are known to be 0; 0 where none is known.
    double emptyDistance(const Vec3& ws) const;
    /// How far `ws` can go along `way`, in multiples of it, while extinction is known to be constant within `reach`
    /// world units; below 0 where it is not known to be constant at `ws`.
    double evenAlong(const Vec3& ws, const Vec3& way, double reach) const;

  private:
    // Where the fields were that are seen at `ws`.
    Vec3 origin(const Vec3& ws) const { return m_velocity.empty() ? ws : ws - wayTo(ws); }
    Vec3 wayTo(const Vec3& ws) const;

    const ViewVolume* m_volume;
    std::optional<FieldInWorld> m_density;
    std::vector<FieldInWorld> m_scatter, m_emission;  // as ViewVolume has them
    std::vector<FieldInWorld> m_velocity;             // as ViewVelocity::parts; linear, whatever kernel fields have
    double m_mostWay = 0;                             // world units
    double m_voxels = 0;                              // of the density, along any axis that a world unit may span
};

}  // namespace scrim
