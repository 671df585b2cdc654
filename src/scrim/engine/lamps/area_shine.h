// SPDX-License-Identifier: Apache-2.0
// How a surface shines at a place before anything holds its light back: the solid angle that its emitting side fills
// there, in closed form, and what phase functions show of it. Close to a surface both change within a cell
// and within a sheet, where all else that makes its light changes slowly.
#pragma once

#include <scrim/geometry/camera.h>
#include <scrim/geometry/spaces.h>
#include <scrim/scene/light.h>
#include <scrim/scene/medium.h>
#include <scrim/scene/phase_over_caps.h>
#include <scrim/solid/shining_mesh.h>

#include <array>
#include <memory>
#include <numbers>
#include <span>
#include <vector>

namespace scrim {

class AreaShine {
  public:
    /// True for rectangles, disks, cylinders and meshes that shine evenly: with neither a slide nor a spread.
    static bool serves(const Light& light);
    /// `light`: an area light that is no sphere, which need not shine evenly. `octaves`: what the
    /// medium sends towards the camera.
    AreaShine(const Light& light, const std::vector<Octave>& octaves, const Camera& camera);

    /// Steradians, from 0 (behind a rectangle or disk, within a cylinder or beyond its ends) to 2
    /// pi; of a mesh the sum over its triangles, whatever hides them.
    double at(const Vec3& ws) const;
    /// The integral over the directions towards the surface, world space. Over its length, divided
    /// by the solid angle, the directions' mean cosine to their middle.
    Vec3 towards(const Vec3& ws) const;
    /// What the eye sees of a radiance of 1 for a scattering coefficient of 1: the integral of the phase functions over
    /// the solid angle. That is taken for a cap with the same middle and the same mean cosine, which phase functions
    /// that are linear in the cosine do not tell from it; where lobes are narrower, for one cap for each part of it.
    double shown(const Vec3& ws) const;
    /// World units to the surface; 0 within a cylinder.
    double distance(const Vec3& ws) const;

    /// A part of a path: what it adds to the path's mean of `shown`, and the place, world space, about which it does.
    struct Piece {
        double shown = 0;
        Vec3 ws{0};
    };
    struct Pieces {
        std::array<Piece, 4> all{};
        std::size_t count = 0;
        std::span<const Piece> used() const { return {all.data(), count}; }
    };
    /// The mean over the path from `wsBegin` to `wsBegin` + `wsPath`, as an eye sees it that looks along it through an
    /// optical depth of `tau`, in pieces: before and after the place nearest to the surface.
    Pieces along(const Vec3& wsBegin, const Vec3& wsPath, double tau) const;

  private:
    // In the light's axes (right, up, normal): a path, the depth before its end, and the integral
    // of what the eye sees of it.
    struct Path {
        Vec3 begin, way;
        double length, tau, seen;
    };
    Vec3 local(const Vec3& ws) const { return (ws - m_center) * m_frame; }
    double atLocal(const Vec3& p) const;
    template <class Visit>
    void visitPatches(const Vec3& p, double least, const Visit& visit) const;
    Vec3 towardsLocal(const Vec3& p) const;
    double shownLocal(const Vec3& p) const;
    double distanceLocal(const Vec3& p) const;
    double nearest(const Path& path, double from, double to) const;
    double scaleAt(const Vec3& p) const;
    std::size_t litParts(const Path& path, std::array<std::array<double, 2>, 2>& parts) const;
    void addPiece(const Path& path, double from, double to, Pieces& pieces) const;
    void addEven(const Path& path, double from, double to, Pieces& pieces) const;
    void addAcrossMesh(const Path& path, Pieces& pieces) const;

    AreaShape m_shape;
    Vec3 m_center;
    Mat3 m_frame;
    double m_halfWidth, m_halfHeight, m_radius;
    std::shared_ptr<const ShiningMesh> m_mesh;  // in world space, as the light's axes are then; null: it is no mesh
    Camera m_camera;
    double m_lobe = std::numbers::pi;  // the width of the narrowest one of the octaves'
    double m_even = 0;                 // what octaves show that send light to all sides alike, per steradian
    struct Directed {
        double share;
        PhaseOverCaps caps;
    };
    std::vector<Directed> m_directed;  // the others
};

}  // namespace scrim
