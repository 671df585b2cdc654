// SPDX-License-Identifier: Apache-2.0
// What the rays of a pilot meet: volumes as the brightest lights show them.
#pragma once

#include <scrim/geometry/bounds.h>
#include <scrim/scene/optics.h>
#include <scrim/scene/view_scene.h>

#include <algorithm>
#include <array>
#include <cstddef>
#include <vector>

namespace scrim {

/// A light as a pilot sees it.
struct PilotLight {
    const Light* light;
    std::size_t number;  ///< in the scene
    double power;        ///< irradiance, or radiant intensity
};

inline constexpr std::size_t kMostPilotLights = 3;

/// About the irradiance by a light, of one colour, at volumes in a box.
double irradianceAt(const Light& light, const Bounds& ws);

/// The lights, points and directions, that are brightest at the volumes: at most kMostPilotLights,
/// brightest first. The scene must outlive them.
std::vector<PilotLight> brightestLights(const ViewScene& scene);

/// True if a light shines from a point or a sphere, all around or into a cone.
bool isLamp(const Light& light);

/// Unit vector to the light; 0, 0, 0 at the place of the light itself.
Vec3 toLight(const Light& light, const Vec3& from);

class PilotVolume;

/// Coefficients at a point, per world unit, of one colour.
struct PilotStuff {
    double extinction = 0;
    double opacity = 0;  ///< extinction in the channel where it is largest
    double shown = 0;    ///< the part of that which adds to alpha
    /// Emission, as the irradiance that would be scattered evenly to the same effect.
    double glow = 0;
    /// Scattering towards the eye of each of the pilot's lights, relative to even scattering, and of ambient light.
    std::array<double, kMostPilotLights + 1> scattering = {};

    void add(const PilotStuff& o, double weight) {
        extinction += weight * o.extinction;
        opacity += weight * o.opacity;
        shown += weight * o.shown;
        glow += weight * o.glow;
        for (std::size_t i = 0; i < scattering.size(); ++i) scattering[i] += weight * o.scattering[i];
    }
    void cutBelowZero() {
        for (double* value : {&extinction, &opacity, &shown, &glow}) *value = std::max(*value, 0.0);
        for (double& value : scattering) value = std::max(value, 0.0);
    }
    static PilotStuff at(const PilotVolume& volume, const Vec3& ws);
};

/// What light that is not scattered meets of these.
struct PilotShade {
    double extinction = 0;

    void add(const PilotShade& o, double weight) { extinction += weight * o.extinction; }
    void cutBelowZero() { extinction = std::max(extinction, 0.0); }
    static PilotShade at(const PilotVolume& volume, const Vec3& ws);
};

class PilotVolume {
  public:
    /// `volume` must outlive this. `lights`: of the pilot.
    PilotVolume(const ViewVolume& volume, FieldSamplers& samplers, const ViewScene& scene,
                const std::vector<PilotLight>& lights);

    PilotStuff at(const Vec3& ws) const;
    double extinction(const Vec3& ws) const { return m_extinction * m_optics.mostExtinction(ws); }
    /// VolumeOptics::evenAlong of extinction and scattering.
    double evenAlong(const Vec3& ws, const Vec3& way, double reach) const {
        return m_grid ? -1 : m_optics.evenAlong(ws, way, reach);
    }
    /// Whether it casts shadows in light `i` of the pilot.
    bool castsShadow(std::size_t i) const { return m_shadows[i]; }
    /// The largest of its scattering coefficients relative to extinction.
    double brightest() const;
    /// Divides scattering and glow, so that rays see the same picture with other units.
    void divide(double by);
    /// Dims, scatters and emits as much as another volume of the same density.
    void takeWeights(const PilotVolume& other);
    /// Scatters all light evenly, as alpha shows it.
    void showOpacity();

    Bounds bounds;     ///< world space
    double step = 1;   ///< world units
    double texel = 1;  ///< of the sheets that the volume has (plan/levels.h), world units

  private:
    VolumeOptics m_optics;
    bool m_hidden = false;    // the eye does not see it
    double m_extinction = 1;  // of the pilot's colour, relative to the channel where it is largest
    std::vector<double> m_glow;
    // For each light, and ambient light: scattering relative to extinction in each colour, or to
    // scattering where the albedo is a grid.
    std::array<Rgb, kMostPilotLights + 1> m_weights = {};
    std::array<double, kMostPilotLights + 1> m_scattering = {};  // relative to the largest extinction
    std::array<bool, kMostPilotLights> m_shadows = {};
    bool m_grid = false;  // the albedo is one
};

inline PilotStuff PilotStuff::at(const PilotVolume& volume, const Vec3& ws) {
    return volume.at(ws);
}

inline PilotShade PilotShade::at(const PilotVolume& volume, const Vec3& ws) {
    return {volume.extinction(ws)};
}

}  // namespace scrim
