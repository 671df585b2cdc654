// SPDX-License-Identifier: Apache-2.0
// What the camera sees besides volumes: solids that have a colour, as matte surfaces, and lights that are visible. It
// lies behind the volumes, or among them where solids hold these out, and is multiplied by what they let through.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/engine/light/marched_light.h>
#include <scrim/engine/light/volume_shine.h>
#include <scrim/geometry/camera.h>
#include <scrim/scene/view_scene.h>

#include <array>
#include <memory>
#include <vector>

namespace scrim {

/// True if the scene wants the layer `backdrop`, and has something to show in it.
bool hasBackdrop(const ViewScene& scene);

/// True if that is lit by volumes.
bool backdropIsLitByVolumes(const ViewScene& scene);

/// The backdrop along single rays. May be used from many threads at once.
class Backdrop {
  public:
    /// `scene` must outlive this object. `again`: see VolumeShine. Throws as that does.
    Backdrop(const ViewScene& scene, const TransportPlan& again, const Checkpoint& checkpoint);

    /// What a ray meets: a solid with a colour at a place, or what shines by itself, a light's
    /// surface or the sky, with its radiance and alpha.
    struct Met {
        const Solid* solid = nullptr;
        Vec3 ws{0}, normal{0};  ///< the normal is unit and on the eye's side
        std::array<double, 4> shines{};
    };
    /// The ray through raster position (x, y) of the picture without antialiasing.
    Met meets(double x, double y) const;

    /// Radiance over colour that a solid reflects there, evenly to all sides (Lambert): of lights
    /// and ambient light, and of what volumes send.
    Rgb lightOn(const Met& met) const;
    Rgb shineOn(const Met& met) const;

    /// Radiance of the ray through (x, y), as if there were no volumes before it, and alpha: 1
    /// where there is a backdrop, else 0.
    std::array<double, 4> at(double x, double y) const;

  private:
    const ViewScene& m_scene;
    RayFamily m_rays;
    double m_pixel;  // angle of a pixel, radians
    MarchedLight m_light;
    std::unique_ptr<const VolumeShine> m_shine;  // null: volumes send no light to solids
};

/// The backdrop of a picture's rays.
class BackdropRays {
  public:
    /// Traces the rays of the scene's region. On even parts of a solid light that hardly changes
    /// over up to 8 x 8 rays is interpolated. Calls `checkpoint` now and then.
    BackdropRays(const ViewScene& scene, const TransportPlan& again, const Checkpoint& checkpoint);

    /// The radiance and alpha of the ray (x, y) of the antialiasing raster.
    const std::array<float, 4>& ray(int x, int y) const { return m_rays[indexOf(x, y)]; }
    int antialias() const { return m_antialias; }  ///< n, of n x n rays a pixel
    static std::size_t bytes(const ViewScene& scene);

  private:
    std::size_t indexOf(int x, int y) const {
        return std::size_t(y - m_window.y0) * std::size_t(m_window.width()) + std::size_t(x - m_window.x0);
    }

    int m_antialias;
    PixelWindow m_window;  // in rays
    std::vector<std::array<float, 4>> m_rays;
};

}  // namespace scrim
