// SPDX-License-Identifier: Apache-2.0
// The brute-force reference: one pixel at a time, in double precision, with small adaptive steps,
// and a shadow ray marched from every sample to every light. It is slow and meant to be obviously
// right, because everything else is judged by it.
//
// It shares with the engine the meaning of a scene: how a kernel reconstructs a field (volume/field_sampler), what a
// volume does to light and what a light sends (scene/optics, scene/light_at), and what is seen behind the volumes
// (engine/light/backdrop). The transport of light through volumes is computed independently here.
#pragma once

#include <scrim/engine/light/backdrop.h>
#include <scrim/scene/light_at.h>
#include <scrim/scene/optics.h>
#include <scrim/scene/view_scene.h>
#include <scrim/verify/light_rays.h>

#include <array>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

namespace scrim {

struct ReferenceOptions {
    double step = 0.5;                 ///< largest step, voxels
    double mostTau = 0.1;              ///< largest optical depth of a step; denser places take smaller steps
    double leastTransmittance = 1e-7;  ///< an eye ray ends where its transmittance falls below this
    double classifiedStep = 0.0625;    ///< largest step where a volume is classified, voxels
    /// Eye rays end at this depth along the viewing axis, world units. Light still passes through all volumes.
    double far = std::numeric_limits<double>::infinity();
    /// n, where each sample sends n^2 rays to an extended light, with a random offset for each
    /// sample. 0: n follows from the scene's light_error.
    int lightRays = 0;
};

class PhasePeak;

class Reference {
  public:
    /// `scene` must outlive this object, and so must the fields of `samplers`, to which missing ones are added. null:
    /// it has its own samplers. In a scene of several moments it sees the one moment that `scene` is.
    explicit Reference(const ViewScene& scene, const ReferenceOptions& options = {}, FieldSamplers* samplers = nullptr);

    /// Premultiplied RGBA along the ray through raster position (x, y). Pixel centres are at + 1/2.
    /// Once `late` returns true, the ray ends, and the value is worth nothing.
    std::array<double, 4> ray(double x, double y, const std::function<bool()>& late = {}) const;

    /// Mean over the n x n rays of pixel (x, y), where n is the scene's antialias dial.
    std::array<double, 4> pixel(int x, int y, const std::function<bool()>& late = {}) const;

    /// Optical depth of each colour between two points in world space: of all volumes, or of those
    /// that cast shadows in light `light` of the scene.
    Rgb opticalDepth(const Vec3& wsA, const Vec3& wsB, std::optional<std::size_t> light = {}) const;

    /// The fraction of the light of light `light` of the scene that arrives at `ws` through all
    /// volumes. Solids do not count.
    Rgb arriving(std::size_t light, const Vec3& ws) const;

    /// Radiance per world unit of path at `ws`, scattered and emitted, for an eye ray of direction
    /// `wsDirection` (unit, away from the eye), and the extinction there.
    struct Sample {
        Rgb source{0};
        Rgb extinction{0};
        Rgb seen{0};  ///< extinction of volumes that are not held out
    };
    Sample sample(const Vec3& ws, const Vec3& wsDirection) const;

  private:
    Rgb extinction(const Vec3& ws) const;
    bool isAround(std::size_t index, const ViewVolume& volume, const Vec3& travel) const;
    double slideStep(const Vec3& ws, const Vec3& wsDirection, double step) const;
    double lampStep(const Vec3& ws, double step) const;
    std::uint64_t blockedLights(const Vec3& ws) const;
    double edgeStep(const Vec3& ws, const Vec3& wsDirection, double step) const;
    std::vector<LightRay> raysTo(std::size_t light, const Vec3& ws) const;
    Rgb depthTowards(std::size_t light, const Vec3& ws, const LightRay& ray) const;
    bool blocked(const Vec3& ws, const Vec3& toLight, double distance) const;
    Rgb scatter(std::size_t light, const Vec3& ws, const Vec3& wsDirection) const;
    Rgb scatterExtended(std::size_t light, const Vec3& ws, const Vec3& wsDirection) const;
    Rgb scatterInPeaks(std::size_t light, const Vec3& ws, const Vec3& wsDirection) const;
    double outsideOfPeak(std::size_t light, std::size_t volume, const LightRays& rays, const Vec3& toLight,
                         double cosine) const;
    Rgb towardsEye(std::size_t light, const Vec3& ws, const Vec3& travel, const Vec3& wsDirection, const Rgb& tau,
                   const LightRays* rays = nullptr) const;
    Vec3 farAway(const Vec3& ws, const Vec3& wsDirection) const;

    const ViewScene& m_scene;
    ReferenceOptions m_options;
    std::vector<VolumeOptics> m_volumes;
    // One of the two, depending on whether the light is extended.
    std::vector<LightSent> m_lights;
    std::vector<std::shared_ptr<const PhasePeak>> m_peaks;  // for each volume; null: its phase function has no peak
    Bounds m_wsBounds;
    double m_voxel, m_step;
    std::unique_ptr<const Backdrop> m_backdrop;  // null: nothing is seen behind the volumes
};

}  // namespace scrim
