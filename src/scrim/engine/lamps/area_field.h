// SPDX-License-Identifier: Apache-2.0
// The light of one rectangle, disk or cylinder on cells close to it. There its light rises faster than cells can show,
// and its sub-lights show as blobs. But what the eye sees of what arrives at a cell, relative to what it would see if
// nothing held the same sub-lights back, changes slowly: a mean of transmittances. So that is what cells keep, as two
// sums whose singularities cancel, and look-ups multiply it by the mean over the eye's path of what the surface would
// show (AreaShine). Farther away the field of all lights keeps the rest, with as much light as the surface has and not
// its sub-lights.
#pragma once

#include <scrim/engine/cells/cell_field.h>
#include <scrim/engine/lamps/area_shine.h>
#include <scrim/geometry/bounds.h>
#include <scrim/scene/light.h>

#include <cstddef>
#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace scrim {

/// What an area light lights.
struct AreaView {
    std::vector<Octave> octaves;  ///< what the medium sends towards the camera
    Camera camera;
    double sheet = 0;  ///< how thick sheets are, world units
};

class AreaField {
  public:
    /// `light`: one that AreaShine serves. `elements`: its sub-lights, alike in area. `all`: the cells of all of its
    /// light, one of which has a corner at `wsCorner`. `colours`, `tint`: as those of its light's field.
    AreaField(const Light& light, const AreaView& view, std::span<const Light> elements, const CellGrid& all,
              const Vec3& wsCorner, std::size_t colours, const Rgb& tint);
    /// True if it has cells: the light is close to those of `all`.
    bool any() const { return !m_lit.grid().storedBlocks().empty(); }

    /// The sums over sub-lights of what arrives at a cell of what the eye sees of it; they are to
    /// be added here before keepNear.
    CellField& lit() { return m_lit; }
    /// What the same sub-lights would show at those cells if nothing held their light back, for a
    /// radiance of 1; it is to be added here.
    CellField& open() { return m_open; }
    /// Leaves of lit() the part that this field keeps, which fades out with the distance from the
    /// surface. To be called once.
    void keepNear();
    /// Takes that part from the light of the sub-lights, on cells of those that the field was made
    /// for, and gives it what the surface shines brighter than they.
    void keepFar(CellField& light) const;

    /// True if the field has light in the box.
    bool reaches(const Bounds& ws) const;
    /// Adds the light at a point.
    void addTo(const Vec3& ws, Real (&rgb)[3]) const;
    /// Adds the light at a tile of samples, as CellField::lookUp.
    void addTo(const SamplePlane& plane, const SampleTile& samples, const Real* extinction, Real* const rgb[3],
               const Real* nearer) const;

    std::size_t bytes() const { return m_lit.bytes() + m_open.bytes() + m_far.bytes(); }

  private:
    struct LastBlocks {
        CellField::LastBlock lit, open;
    };
    double evenLight(const Vec3& ws) const;
    double nearShare(const Vec3& ws) const;
    double farShare(const Vec3& ws) const;
    void addPieces(const AreaShine::Pieces& pieces, double share, LastBlocks& last, Real (&rgb)[3]) const;

    AreaShine m_shine;
    std::vector<Vec3> m_at, m_normal;  // of its sub-lights, world space
    double m_area;                     // of a sub-light, world units squared
    double m_near, m_spacing;  // world units: how far from the surface nearShare reaches, and between sub-lights
    CellField m_lit, m_open, m_far;
};

}  // namespace scrim
