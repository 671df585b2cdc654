// SPDX-License-Identifier: Apache-2.0
// Multiply scattered light by Monte Carlo integration, which is added to the reference where a medium asks for it.
// Paths start at the eye, collisions are found by delta tracking, and light from the lights is added at each collision
// (E. Woodcock and others, 1965; J. Novak and others, Monte Carlo Methods for Volumetric Light Transport Simulation,
// 2018). The code shares nothing with cells, ordinates or shadow buffers. It returns the variance of its estimates.
#pragma once

#include <scrim/scene/light_at.h>
#include <scrim/scene/optics.h>
#include <scrim/scene/view_scene.h>
#include <scrim/verify/light_rays.h>

#include <cstdint>
#include <vector>

namespace scrim {

class HeldRay;

/// The mean of random numbers and the variance of that mean.
struct Estimate {
    Rgb mean{0}, variance{0};
};

class PathTracer {
  public:
    /// `scene` must outlive this object. `samplers`: as for Reference.
    explicit PathTracer(const ViewScene& scene, FieldSamplers* samplers = nullptr);

    /// True if any volume scatters light more than once.
    bool any() const { return m_any; }

    /// Premultiplied radiance, averaged over pixel (x, y), of light from lights that has scattered at least twice, and
    /// of ambient light and emission that has scattered at least once. Classified volumes scatter it where they are
    /// Classified::scatters. Solids that stop light send their albedo's part of it back, which counts as scattering;
    /// what the eye sees last is a volume. A path scatters any number of times in volumes whose media scatter fully,
    /// and at most once in all other volumes together. Averages `paths` paths; each `seed` gives a different set.
    Estimate pixel(int x, int y, int paths, std::uint64_t seed = 1) const;

  private:
    struct Random;
    // The extinction and emission at a point.
    struct Matter {
        Rgb extinction{0}, emission{0};
    };
    // The end of a ray's flight and the weight that it carries there.
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
    template <class Factor>
    Rgb lit(const std::vector<bool>& lights, const Vec3& ws, const Factor& factor, Random& random) const;
    Rgb path(Vec3 ws, Vec3 direction, double begin, double length, const HeldRay& held, Random& random) const;
    SolidHit solidAhead(SolidRole role, const Vec3& ws, const Vec3& direction, double begin) const;
    static bool goesOn(Rgb& weight, Random& random);
    bool scatter(const Vec3& ws, Vec3& direction, bool first, bool& once, Rgb& weight, Rgb& sum, Random& random) const;
    bool sendBack(const SolidHit& hit, Vec3& ws, Vec3& direction, Rgb& weight, Rgb& sum, Random& random) const;

    const ViewScene& m_scene;
    bool m_any = false;
    std::vector<VolumeOptics> m_volumes;
    // One of the two, depending on whether the light is extended.
    std::vector<LightSent> m_lights;
    // The majorants: the largest extinction in each box of a grid around all volumes.
    Bounds m_wsBounds;
    Int3 m_size{0};
    double m_edge = 1;
    std::vector<double> m_majorants;
};

}  // namespace scrim
