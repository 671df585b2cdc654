// SPDX-License-Identifier: Apache-2.0
// How a flat or round surface shines at a place before anything holds its light back: the solid angle that its emitting
// side fills there, in closed form. Close to a surface this changes within a cell and within a sheet, where all else
// that makes its light changes slowly.
#pragma once

#include <scrim/geometry/spaces.h>
#include <scrim/scene/light.h>

#include <array>
#include <span>

namespace scrim {

class AreaShine {
  public:
    /// True for rectangles, disks and cylinders that shine evenly: with neither a slide nor a spread.
    static bool serves(const Light& light);
    /// `light`: an area light that is a rectangle, a disk or a cylinder, which need not shine evenly.
    explicit AreaShine(const Light& light);

    /// Steradians, from 0 (behind a rectangle or disk, within a cylinder or beyond its ends) to 2 pi.
    double at(const Vec3& ws) const;
    /// World units to the surface; 0 within a cylinder.
    double distance(const Vec3& ws) const;

    /// A part of a path: what it adds to the path's mean solid angle, and the place, world space, about which it does.
    struct Piece {
        double solidAngle = 0;
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
    // In the light's axes (right, up, normal): a path, the depth before its end, and the integral of what the eye sees
    // of it.
    struct Path {
        Vec3 begin, way;
        double length, tau, seen;
    };
    Vec3 local(const Vec3& ws) const { return (ws - m_center) * m_frame; }
    double atLocal(const Vec3& p) const;
    double distanceLocal(const Vec3& p) const;
    double nearest(const Path& path, double from, double to) const;
    double scaleAt(const Vec3& p) const;
    std::size_t litParts(const Path& path, std::array<std::array<double, 2>, 2>& parts) const;
    void addPiece(const Path& path, double from, double to, Pieces& pieces) const;
    void addEven(const Path& path, double from, double to, Pieces& pieces) const;

    AreaShape m_shape;
    Vec3 m_center;
    Mat3 m_frame;
    double m_halfWidth, m_halfHeight, m_radius;
};

}  // namespace scrim
