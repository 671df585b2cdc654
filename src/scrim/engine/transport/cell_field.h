// SPDX-License-Identifier: Apache-2.0
// Light on cells, which shading looks up at any point.
#pragma once

#include <scrim/base/real.h>
#include <scrim/engine/model/plan.h>
#include <scrim/engine/model/eye_view.h>
#include <scrim/engine/transport/cell_grid.h>
#include <scrim/geometry/camera.h>
#include <scrim/scene/light.h>
#include <scrim/scene/medium.h>
#include <scrim/scene/phase_over_caps.h>

#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

namespace scrim {

/// The positions of a tile's samples, ws = origin + u perU + v perV, in the middle of a sheet. `wsPerSheet` leads to
/// the next sheet along its normal, and a slope du/dw of 1 by `toTexels` along perU.
struct SamplePlane {
    Vec3 wsOrigin{0}, wsPerU{0}, wsPerV{0}, wsPerSheet{0};
    double toTexels = 1;
    double towardsEye = 0;  ///< 1 if the next sheet is nearer to the eye, -1 if it is farther; 0: it does not matter
};

struct CellMedia;

/// Light on cells: radiance towards the eye per unit of scattering coefficient, which equals that of an equivalent
/// uniform environment. It is interpolated linearly between the centres of those cells that are on the same side of the
/// grid's walls.
class CellField {
  public:
    /// Black. With one value per cell instead of three, the light is that value times `tint`.
    CellField(std::shared_ptr<const CellGrid> grid, int colours, const Rgb& tint = Rgb(1));

    const CellGrid& grid() const { return *m_grid; }
    std::size_t colours() const { return m_colours; }
    /// The values of block `b`: `colours` for each of its kPaddedCells cells, x fastest.
    Real* block(std::size_t b) { return m_values.data() + b * kPaddedCells * m_colours; }
    /// The values of a stored cell, in its own block.
    Real* cell(std::size_t index);
    /// Adds light(centre) to every cell: to the first colour, or to all three. `light` is called by many threads.
    void add(const std::function<Rgb(const Vec3& ws)>& light);
    /// The light at a point, 0 beyond the stored cells.
    void sample(const Vec3& ws, Real (&rgb)[3]) const;
    /// The light at a tile of samples: kTileSize values for each colour, 0 where `extinction`, likewise kTileSize
    /// values per world unit, is. Within a sheet the light counts as the eye sees it through the part before.
    void lookUp(const SamplePlane& plane, const SampleTile& samples, const Real* extinction, Real* const rgb[3]) const;

    /// What is kept is transmittance from `lamp`, a point light or a sphere; the phase function is towards the camera.
    /// `attenuated`: volumes hold its light back. `nearby`: only near the lamp, because cells that many lamps share
    /// keep the light of places far from it.
    void setLamp(const Light& lamp, const Phase& phase, const Camera& camera, bool attenuated, bool nearby);
    const Light& lamp() const { return *m_lamp; }  ///< after setLamp
    /// Replaces the transmittance t that is kept by the mean extinction on the way from the lamp, -log(t) / (length of
    /// the way). Near a lamp that changes slowly, but irradiance, transmittance and direction change fast. Look-ups
    /// compute these three from the mean extinction, with the mean of 1/r^2 over the eye's path through the sheet.
    /// `media`: what dims the light near the surface of a sphere. There the light comes from so many sides that the
    /// lamp's points do not represent it, and the extinction is computed anew. `open`: the fraction of the light that
    /// passes solids; null: there are no solids.
    void makeMean(const CellMedia& media, std::shared_ptr<const CellField> open);
    /// The lamp's light at a point, with a transmittance of the way there, but for the part that is kept near the lamp.
    Rgb farLight(const Vec3& ws, double transmittance) const;
    /// What farLight gives beyond `reach` (world units) without attenuation, times the square of the distance, if it
    /// depends on no more than that; none: it does.
    std::optional<Rgb> evenFarLight(double& reach) const;
    /// Look-ups also find what `lamp` keeps near it.
    void addNear(std::shared_ptr<const CellField> lamp) { m_lamps.push_back(std::move(lamp)); }

    std::size_t bytes() const { return m_values.size() * sizeof(Real); }

  private:
    double nearShare(double r) const;
    template <class Visit>
    void forCells(const Visit& visit);
    double wayTo(const Int3& cell) const;
    void keepNearSphere(const CellMedia& media, const Vec3& ws, Real* values) const;
    double lampFactor(const Vec3& ws) const;
    double lampDecay(double r2) const;
    void addNearLamps(const SamplePlane& plane, const SampleTile& samples, const Real* extinction,
                      Real* const rgb[3]) const;
    void sampleAt(const Vec3& at, std::pair<Int3, std::int32_t>& last, Real (&rgb)[3]) const;
    void lampAt(const Vec3& ws, double part, Real (&rgb)[3]) const;
    double meanProfile(const Vec3& way, const Vec3& path) const;
    double meanDecay(const Vec3& way, const Vec3& path) const;
    double meanNearSphere(const Vec3& way, const Vec3& path, double extinction) const;

    std::shared_ptr<const CellGrid> m_grid;
    std::size_t m_colours;
    Real m_tint[3];
    std::optional<Light> m_lamp;
    Mat3 m_lampFrame{1.0};  // of its luminaire
    std::shared_ptr<const CellField> m_open;
    bool m_attenuated = true;
    double m_near = 0;      // of a lamp that shares cells: how far those of its own reach, world units; 0: it is alone
    bool m_hollow = false;  // the lamp is a sphere whose light begins at its surface
    Phase m_phase;          // towards the camera, of a lamp's light
    std::shared_ptr<const PhaseOverCaps> m_caps;  // of a sphere, which fills a cone; null: of a point, or isotropic
    Camera m_camera;
    std::vector<std::shared_ptr<const CellField>> m_lamps;  // of lamps that share this
    std::vector<Real> m_values;                             // [block][padded cell][colour]
};

/// True if cells of this edge resolve a sphere, so that its light must begin at its surface.
bool hollowOnCells(const Light& lamp, double edge);

/// The distance from a lamp from which on cells that many lamps share keep all of its light, world units.
double nearestFar(const Light& lamp, double edge);

/// The blocks of `all` in which such a lamp has cells of its own, one of which has a corner at `wsCorner`.
std::shared_ptr<const CellGrid> cellsNear(const Light& lamp, const CellGrid& all, const Vec3& wsCorner);

/// The light on cells that belongs to one output.
struct CellLight {
    std::optional<Output> output;                            ///< none: the beauty
    bool again = false;                                      ///< it has scattered before it arrives
    std::vector<std::shared_ptr<const CellField>> ofVolume;  ///< for each volume of the scene; null: none
};

}  // namespace scrim
