// SPDX-License-Identifier: Apache-2.0
// The light at points that need not lie in any sheet, as those on solids: by rays that are marched to all lights.
#pragma once

#include <scrim/engine/model/sub_lights.h>
#include <scrim/geometry/bounds.h>
#include <scrim/scene/light_at.h>
#include <scrim/scene/optics.h>
#include <scrim/scene/view_scene.h>

#include <array>
#include <cstddef>
#include <vector>

namespace scrim {

/// Light at a point, relative to all directions: the mean of its radiance, and for each colour the
/// mean of that times its direction of travel.
struct FromAllSides {
    Rgb mean{0};
    std::array<Vec3, 3> flow{Vec3(0), Vec3(0), Vec3(0)};
};

/// World units by which a ray from `ws` leaves the surface that it begins on.
double offSurface(const Vec3& ws);

/// May be used from many threads at once.
class MarchedLight {
  public:
    /// `scene` must outlive this object.
    explicit MarchedLight(const ViewScene& scene);
    MarchedLight(const MarchedLight&) = delete;
    MarchedLight& operator=(const MarchedLight&) = delete;

    /// The number of rays to light `light` of the scene: one, or one for each of its sub-lights.
    std::size_t rays(std::size_t light) const { return m_parts[light].size(); }

    /// The fraction of light `light` of the scene that arrives at `ws` through all volumes, by colour. Its sub-lights
    /// count by what they send to the point, without regard to a surface there. Solids do not count.
    Rgb transmittance(std::size_t light, const Vec3& ws) const;

    /// The irradiance of all lights on a surface at `ws` whose normal is `normal` (unit), through
    /// all volumes and past the solids that cast shadows.
    Rgb irradiance(const Vec3& ws, const Vec3& normal) const;

    /// What arrives likewise of the lights in `lights` (litBy) in a cell of `edge` around `ws`.
    FromAllSides fromAllSides(const Vec3& ws, const std::vector<bool>& lights, double edge) const;

  private:
    // A light without extent, which is a light of the scene or a part of one.
    struct Part {
        explicit Part(const Light& one) : light(&one), at(one) {}

        const Light* light;
        LightAt at;
    };
    Rgb transmittance(std::size_t light, const Part& part, const Vec3& ws) const;
    // What is left of a light that arrives, behind volumes and solids.
    Rgb left(std::size_t light, const Part& part, const Arriving& arriving, const Vec3& ws) const;

    const ViewScene& m_scene;
    double m_step;
    Bounds m_wsBounds;
    std::vector<VolumeOptics> m_volumes;
    SubLights m_subLights;
    std::vector<std::vector<Part>> m_parts;  // of each light
};

}  // namespace scrim
