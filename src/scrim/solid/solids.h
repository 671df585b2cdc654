// SPDX-License-Identifier: Apache-2.0
// Surfaces that end rays: triangle meshes at one frame, which rays of eyes and lights are traced against.
#pragma once

#include <scrim/geometry/bounds.h>
#include <scrim/geometry/spaces.h>
#include <scrim/solid/triangle_mesh.h>

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

namespace scrim {

/// What a solid does. One mesh may do several things.
enum class SolidRole {
    holdout,  ///< hides from the eye what is behind it, and adds nothing
    shadow,   ///< takes light from volumes
    catcher,  ///< shows what light the volumes leave on it
};

struct Solid {
    std::string name;
    std::shared_ptr<const TriangleMesh> mesh;
    Mat4 wsFromMesh{1.0};
    bool holdout = true, shadows = true, catches = false;

    bool has(SolidRole role) const {
        return role == SolidRole::holdout ? holdout : role == SolidRole::shadow ? shadows : catches;
    }
};

/// Where a ray meets a surface.
struct SolidHit {
    double t;            ///< the ray's parameter; infinity: it meets none
    Vec3 wsNormal{0};    ///< of the triangle, of any length and to either side
    bool hides = false;  ///< is it of a holdout?
};

/// A set of solids, ready for rays (Embree). May be asked from many threads.
class Solids {
  public:
    /// Throws Error(memory).
    explicit Solids(std::vector<Solid> solids);
    ~Solids();
    Solids(const Solids&) = delete;
    Solids& operator=(const Solids&) = delete;

    const std::vector<Solid>& all() const { return m_solids; }
    bool any(SolidRole role) const;
    /// World-space box around all with that role; empty where there are none.
    const Bounds& wsBounds(SolidRole role) const;

    /// Where, with the least t in [begin, end] at which wsOrigin + t wsDirection meets a surface of a solid with that
    /// role, from either side. The direction has any length but 0. Exact to the last digits of a double where the
    /// surface is hit at all; which triangle an edge belongs to is decided in floats, relative to the middle of the
    /// solids.
    SolidHit trace(SolidRole role, const Vec3& wsOrigin, const Vec3& wsDirection, double begin, double end) const;

    /// Its t.
    double firstHit(SolidRole role, const Vec3& wsOrigin, const Vec3& wsDirection, double begin, double end) const {
        return trace(role, wsOrigin, wsDirection, begin, end).t;
    }

    /// Of meshes and what was built for them.
    std::size_t bytes() const;

  private:
    struct Traced;  // what one role's rays are traced against
    const Traced& of(SolidRole role) const { return *m_traced[static_cast<std::size_t>(role)]; }

    std::vector<Solid> m_solids;
    std::vector<std::shared_ptr<const Traced>> m_traced;  // one a role; roles of the same solids share one
};

}  // namespace scrim
