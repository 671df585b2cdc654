// SPDX-License-Identifier: Apache-2.0
// Light that scatters more than once, by Monte Carlo: what is added to the reference where a medium asks for it. Paths
// go from the eye, collisions are found by delta tracking, lights are asked for at each (E. Woodcock and others, 1965;
// J. Novak and others, Monte Carlo Methods for Volumetric Light Transport Simulation, 2018). It knows nothing of cells,
// ordinates or shadow buffers. Its noise is known, and is told.
#pragma once

#include <scrim/scene/light_at.h>
#include <scrim/scene/optics.h>
#include <scrim/scene/view_scene.h>
#include <scrim/verify/light_rays.h>

#include <cstdint>
#include <variant>
#include <vector>

namespace scrim {

class HeldRay;

/// Of a mean of random numbers: the mean, and the variance of it.
struct Estimate {
    Rgb mean{0}, variance{0};
};

class PathTracer {
  public:
    /// `scene` must outlive this. `samplers`: as for a Reference.
    explicit PathTracer(const ViewScene& scene, FieldSamplers* samplers = nullptr);

    /// Does anything scatter light more than once?
    bool any() const { return m_any; }

    /// Premultiplied radiance, in the mean over pixel (x, y), of light of lights that has scattered twice or more, and
    /// of ambient light and of what glows that has scattered at all. `paths` paths, of which every `seed` has others.
    Estimate pixel(int x, int y, int paths, std::uint64_t seed = 1) const;

  private:
    struct Random;
    // What is at a point.
    struct Matter {
        Rgb extinction{0}, emission{0};
    };
    // Where a ray that was followed ends, and the weight that it has there.
    struct Flight {
        bool collided = false;
        Vec3 ws{0};
        Rgb weight{1}, glow{0};
    };
    Matter matterAt(const Vec3& ws) const;
    void measure();
    template <class Visit>
    void forCells(const Vec3& ws, const Vec3& direction, double from, double length, const Visit& visit) const;
    Flight fly(const Vec3& ws, const Vec3& direction, double from, double length, Random& random) const;
    Rgb transmittance(const Vec3& ws, const Vec3& direction, double length, Random& random) const;
    Arriving arriving(std::size_t light, const Vec3& ws, Random& random) const;
    Rgb lit(const VolumeOptics& volume, const Vec3& ws, const Vec3& direction, Random& random) const;
    Rgb path(Vec3 ws, Vec3 direction, double begin, double length, const HeldRay& held, Random& random) const;
    double solidAhead(SolidRole role, const Vec3& ws, const Vec3& direction, double begin) const;

    const ViewScene& m_scene;
    bool m_any = false;
    std::vector<VolumeOptics> m_volumes;
    std::vector<std::variant<LightAt, LightRays>> m_lights;  // as they are extended or not
    // The most extinction that there is in each box of a grid around everything.
    Bounds m_wsBounds;
    Int3 m_size{0};
    double m_edge = 1;
    std::vector<double> m_majorants;
};

}  // namespace scrim
