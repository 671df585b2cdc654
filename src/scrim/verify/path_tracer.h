// SPDX-License-Identifier: Apache-2.0
// Light that scatters more than once, by Monte Carlo: what is added to the reference where a medium asks for it. Paths
// go from the eye, collisions are found by delta tracking, lights are asked for at each (E. Woodcock and others, 1965;
// J. Novak and others, Monte Carlo Methods for Volumetric Light Transport Simulation, 2018). It knows nothing of cells,
// ordinates or shadow buffers. Its noise is known, and is told.
#pragma once

#include <scrim/engine/light/slide_map.h>
#include <scrim/engine/splat/kernel.h>
#include <scrim/scene/view_scene.h>
#include <scrim/verify/field_probes.h>
#include <scrim/verify/light_rays.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

namespace scrim {

class HeldRay;

/// Of a mean of random numbers: the mean, and the variance of it.
struct Estimate {
    Rgb mean{0}, variance{0};
};

class PathTracer {
  public:
    /// `scene` must outlive this. `probes`: as for a Reference.
    explicit PathTracer(const ViewScene& scene, FieldProbes* probes = nullptr);

    /// Does anything scatter light more than once?
    bool any() const { return m_any; }

    /// Premultiplied radiance, in the mean over pixel (x, y), of light of lights that has scattered twice or more, and
    /// of ambient light and of what glows that has scattered at all. `paths` paths, of which every `seed` has others.
    Estimate pixel(int x, int y, int paths, std::uint64_t seed = 1) const;

  private:
    struct Random;
    struct Probe {
        std::shared_ptr<const FieldProbe> field;
        Mat4 isFromWs{1.0};
        double value(const Vec3& ws) const { return field->value(transformPoint(isFromWs, ws)); }
    };
    struct Volume {
        std::optional<Probe> density;
        std::vector<Probe> scatter;
        std::vector<std::pair<Probe, Rgb>> emission;
        const ViewVolume* look = nullptr;
    };
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
    // Light that reaches a point, before anything takes some of it.
    struct Incident {
        Rgb irradiance{0};
        Vec3 toLight{0};
        double distance = 0;
    };

    Matter matterAt(const Vec3& ws) const;
    Rgb extinctionOf(const Volume& volume, const Vec3& ws) const;
    Rgb scatteringOf(const Volume& volume, const Vec3& ws) const;
    void measure();
    template <class Visit>
    void forCells(const Vec3& ws, const Vec3& direction, double from, double length, const Visit& visit) const;
    Flight fly(const Vec3& ws, const Vec3& direction, double from, double length, Random& random) const;
    Rgb transmittance(const Vec3& ws, const Vec3& direction, double length, Random& random) const;
    Incident incident(std::size_t light, const Vec3& ws, Random& random) const;
    Rgb lit(const Volume& volume, const Vec3& ws, const Vec3& direction, Random& random) const;
    Rgb path(Vec3 ws, Vec3 direction, double begin, double length, const HeldRay& held, Random& random) const;
    double solidAhead(SolidRole role, const Vec3& ws, const Vec3& direction, double begin) const;

    const ViewScene& m_scene;
    bool m_any = false;
    std::vector<Volume> m_volumes;
    std::vector<std::optional<SlideMap>> m_slides;
    std::vector<std::optional<LightRays>> m_extents;
    // The most extinction that there is in each box of a grid around everything.
    Bounds m_wsBounds;
    Int3 m_size{0};
    double m_edge = 1;
    std::vector<double> m_majorants;
};

}  // namespace scrim
