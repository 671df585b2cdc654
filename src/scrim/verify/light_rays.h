// SPDX-License-Identifier: Apache-2.0
// The rays that an extended light sends to one point: a map from the unit square onto all
// directions in which the light is seen from there, with the radiance that comes from each. An
// integral over the square is an integral over the light as it is, without any sub-lights.
#pragma once

#include <scrim/scene/light.h>
#include <scrim/scene/light_at.h>
#include <scrim/solid/shining_mesh.h>

#include <optional>
#include <span>
#include <variant>
#include <vector>

namespace scrim {

struct SkySun;

/// One ray towards a light.
struct LightRay {
    Vec3 toLight{0};      ///< unit
    double distance = 0;  ///< to the light, world units; infinite for suns and domes
    Rgb weight{0};        ///< radiance times solid angle per area of the square; for suns, the irradiance
};

class LightRays {
  public:
    /// `light` must be extended, must have its picture loaded, and must outlive this object.
    explicit LightRays(const Light& light);

    /// The ray for a point of the unit square [0, 1) x [0, 1). The mean of its weight over the
    /// square is the integral of radiance over the solid angle that the light fills at `ws`.
    LightRay ray(const Vec3& ws, const Vec2& square) const;
    /// Those of several points of the square, which takes less time than one by one. Rays without light are left out.
    std::vector<LightRay> rays(const Vec3& ws, std::span<const Vec2> squares) const;

    /// What comes from a direction (unit): the light's radiance there, or nothing. Not for meshes.
    LightRay from(const Vec3& ws, const Vec3& toLight) const;
    bool knowsRadiance() const { return !m_light.area() || !m_light.area()->surface; }
    /// The density, per steradian, with which `ray` chooses a direction of a dome with a picture; 0 for other lights.
    double density(const Vec3& toLight) const;

  private:
    LightRay fromRectangle(const Vec3& ws, const Vec2& square) const;
    LightRay fromDisk(const Vec3& ws, const Vec2& square) const;
    LightRay fromCylinder(const Vec3& ws, const Vec2& square) const;
    LightRay fromSphere(const Vec3& ws, const Vec2& square) const;
    LightRay fromMesh(const ShiningMesh::Seen& seen, const Vec3& ws, const Vec2& square) const;
    LightRay fromPicture(const Vec2& square) const;
    LightRay fromSun(const Vec2& square) const;
    Rgb sunAt(const Vec3& toLight) const;
    Rgb pictureAt(double u, double v) const;
    bool sendsIntoLess(const Vec3& ws) const;

    const Light& m_light;
    Mat3 m_frame;
    ShiningMesh m_mesh;  // small triangles
    // For a dome's picture: running sums of light over rows, and over the pixels of each row.
    std::vector<double> m_rows, m_pixels;
    // A dome's sun that is not in its picture, its direction, 1 - cos of its radius, and the part
    // of the square that is the sun's: that of its light.
    const SkySun* m_sun = nullptr;
    Vec3 m_toSun{0};
    double m_sunDepth = 0, m_sunPart = 0;
};

/// What a light sends to a point: one ray, or those of its extent.
using LightSent = std::variant<LightAt, LightRays>;

/// One for each of `lights`, which must outlive them.
std::vector<LightSent> lightsSent(const std::vector<Light>& lights);

}  // namespace scrim
