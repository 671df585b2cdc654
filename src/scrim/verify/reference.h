// SPDX-License-Identifier: Apache-2.0
// The brute-force reference: one pixel at a time, double precision, small adaptive steps, a shadow ray marched
// from every sample to every light. Slow, and meant to be obviously right: everything else is judged by it.
//
// It shares with the engine what a scene means: how a kernel reconstructs a field (volume/field_sampler), what a volume
// does to light and what a light sends (scene/optics, scene/light_at). How light is carried is computed here alone.
#pragma once

#include <scrim/scene/light_at.h>
#include <scrim/scene/optics.h>
#include <scrim/scene/view_scene.h>
#include <scrim/verify/light_rays.h>

#include <array>
#include <limits>
#include <variant>
#include <vector>

namespace scrim {

struct ReferenceOptions {
    double step = 0.5;                 ///< voxels, at most
    double mostTau = 0.1;              ///< optical depth of a step, at most: denser places take smaller steps
    double leastTransmittance = 1e-7;  ///< an eye ray ends where less is left
    double classifiedStep = 0.0625;    ///< voxels, at most, where a volume is classified
    /// Eye rays end at this depth along the viewing axis, world units. Light comes through all of the volumes.
    double far = std::numeric_limits<double>::infinity();
    /// n, where n^2 rays go to an extended light from every sample, moved by lot from sample to sample. 0: what the
    /// scene's light_error calls for.
    int lightRays = 0;
};

class Reference {
  public:
    /// `scene` must outlive this, and so must the fields of `samplers`, which get what is not among them yet; null: it
    /// has its own. Of a scene of moments it sees the one that the scene is.
    explicit Reference(const ViewScene& scene, const ReferenceOptions& options = {}, FieldSamplers* samplers = nullptr);

    /// Premultiplied RGBA along the ray through raster position (x, y). A pixel's centre is at + 1/2.
    std::array<double, 4> ray(double x, double y) const;

    /// Mean over the n x n rays of pixel (x, y), n = the scene's antialias dial.
    std::array<double, 4> pixel(int x, int y) const;

    /// Optical depth from `a` to `b`, world space, of each channel.
    Rgb opticalDepth(const Vec3& wsA, const Vec3& wsB) const;

    /// Radiance per world unit of path at `ws`, scattered and emitted, for an eye ray of direction `wsDirection` (unit,
    /// away from the eye), and the extinction there.
    struct Sample {
        Rgb source{0};
        Rgb extinction{0};
        Rgb seen{0};  ///< extinction of what is not held out
    };
    Sample sample(const Vec3& ws, const Vec3& wsDirection) const;

  private:
    Rgb extinction(const Vec3& ws) const;
    double emptyDistance(const Vec3& ws) const;
    Rgb reflect(const VolumeOptics& volume, const Vec3& ws, const Vec3& toLight, const Vec3& toEye) const;
    double slideStep(const Vec3& ws, const Vec3& wsDirection, double step) const;
    bool blocked(const Vec3& ws, const Vec3& toLight, double distance) const;
    Rgb scatter(std::size_t light, const Vec3& ws, const Vec3& wsDirection) const;
    Rgb scatterExtended(std::size_t light, const Vec3& ws, const Vec3& wsDirection) const;
    Rgb towardsEye(std::size_t light, const Vec3& ws, const Vec3& travel, const Vec3& wsDirection,
                   const Rgb& tau) const;
    Vec3 farAway(const Vec3& ws, const Vec3& wsDirection) const;

    const ViewScene& m_scene;
    ReferenceOptions m_options;
    std::vector<VolumeOptics> m_volumes;
    std::vector<std::variant<LightAt, LightRays>> m_lights;  // as they are extended or not
    Bounds m_wsBounds;
    double m_voxel, m_step;
};

}  // namespace scrim
