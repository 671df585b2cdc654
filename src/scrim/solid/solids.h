// SPDX-License-Identifier: Apache-2.0
// Surfaces that end rays: triangle meshes at one frame, against which rays of the eye and of lights are traced.
#pragma once

#include <scrim/geometry/bounds.h>
#include <scrim/geometry/spaces.h>
#include <scrim/solid/triangle_mesh.h>

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace scrim {

/// The roles of a solid. One mesh may have several.
enum class SolidRole {
    holdout,  ///< hides what is behind it from the eye, and adds nothing
    shadow,   ///< casts shadows into volumes, and stops scattered light
    catcher,  ///< shows the light that the volumes leave on it
};

struct Solid {
    std::string name;
    std::shared_ptr<const TriangleMesh> mesh;
    Mat4 wsFromMesh{1.0};
    bool holdout = true, shadows = true, catches = false;
    Rgb albedo{0};  ///< the part of scattered light that comes back from it, evenly to all sides (Lambert); 0 to 1

    /// Of what the camera sees of it, a matte surface (engine/light/backdrop.h); none: nothing. Only holdouts have one.
    std::optional<Rgb> color = {};
    /// The number of the light that it is the surface of, which the camera sees shine; none: it does not.
    std::optional<std::size_t> light = {};

    bool operator==(const Solid&) const = default;
    bool has(SolidRole role) const {
        return role == SolidRole::holdout ? holdout : role == SolidRole::shadow ? shadows : catches;
    }
    bool sendsBack() const { return shadows && albedo != Rgb(0); }
};

/// A ray's intersection with a surface.
struct SolidHit {
    double t;                      ///< the ray's parameter; infinity: no intersection
    Vec3 wsNormal{0};              ///< normal of the triangle, of any length and to either side
    const Solid* solid = nullptr;  ///< null: no intersection
};

/// A set of solids, prepared for rays (Embree). May be used from many threads at once.
class Solids {
  public:
    /// Throws Error(memory).
    explicit Solids(std::vector<Solid> solids);
    ~Solids();
    Solids(const Solids&) = delete;
    Solids& operator=(const Solids&) = delete;

    const std::vector<Solid>& all() const { return m_solids; }
    bool any(SolidRole role) const;
    bool anySendsBack() const;
    /// World-space box around all solids of that role; empty where there are none.
    const Bounds& wsBounds(SolidRole role) const;

    /// The intersection with the least t in [begin, end] at which wsOrigin + t wsDirection meets a
    /// surface of a solid of that role, from either side. The direction has any length but 0. t is
    /// exact to the last digits of a double if the surface is hit at all. Which triangle an edge
    /// belongs to is decided in floats, relative to the centre of the solids.
    SolidHit trace(SolidRole role, const Vec3& wsOrigin, const Vec3& wsDirection, double begin, double end) const;

    /// The t of that intersection.
    double firstHit(SolidRole role, const Vec3& wsOrigin, const Vec3& wsDirection, double begin, double end) const {
        return trace(role, wsOrigin, wsDirection, begin, end).t;
    }

    /// Memory of the meshes and of the structures built for them, bytes.
    std::size_t bytes() const;

  private:
    struct Traced;  // the geometry that one role's rays are traced against
    const Traced& of(SolidRole role) const { return *m_traced[static_cast<std::size_t>(role)]; }

    std::vector<Solid> m_solids;
    std::vector<std::shared_ptr<const Traced>> m_traced;  // one for each role; roles with the same solids share one
};

}  // namespace scrim
