// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/passes/sky_peaks.h>

#include <scrim/engine/cells/cell_walk.h>
#include <scrim/scene/picture_cells.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <numbers>
#include <utility>

#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

namespace scrim {
namespace {

class SkyPeaks {
  public:
    SkyPeaks(const ViewScene& scene, const Sources& sources, std::size_t owner, const CutPhase& cut,
             const Octave& octave, const MediaTogether& media)
        : m_scene(scene),
          m_sky(scene.lights[std::size_t(sources.ofScene[owner])]),
          m_blocked(sources.blocked),
          m_attenuated(sources.attenuated),
          m_cut(cut),
          m_octave(octave),
          m_media(media) {}

    Rgb at(const Vec3& ws) const {
        const Vec3 toEye = travelToEye(m_scene.camera, ws);
        Rgb sum(0);
        if (m_cut.onwards.part > kLittle) sum += m_cut.onwards.part * around(ws, -toEye, m_cut.onwards.rings);
        if (m_cut.backwards.part > kLittle) sum += m_cut.backwards.part * around(ws, toEye, m_cut.backwards.rings);
        return m_octave.share * sum;
    }

  private:
    static constexpr double kLittle = 1e-3;  // of the scattered light
    static constexpr double kDark = 10;      // optical depth
    static constexpr int kRays = 4;          // of a ring

    Rgb along(const Vec3& ws, const Vec3& way) const {
        constexpr double kInfinity = std::numeric_limits<double>::infinity();
        const Rgb radiance = skyAt(m_sky, way);
        if (radiance == Rgb(0)) return radiance;
        if (m_blocked && m_scene.solids->firstHit(SolidRole::shadow, ws, way, 0, kInfinity) < kInfinity) return Rgb(0);
        if (!m_attenuated) return radiance;
        return radiance *
               glm::exp(-m_octave.extinction * opticalDepth(m_media, ws, way, kInfinity, kDark / m_octave.extinction));
    }
    Rgb around(const Vec3& ws, const Vec3& way, const std::vector<PeakRing>& rings) const {
        const Mat3 frame = frameAround(way);
        Rgb sum(0);
        for (std::size_t r = 0; r < rings.size(); ++r) {
            const double depth = rings[r].depth, aside = std::sqrt(depth * (2 - depth));
            const int rays = depth > 0 ? kRays : 1;
            Rgb own(0);
            for (int i = 0; i < rays; ++i) {
                const double turn = 2 * std::numbers::pi * (i + 0.618034 * double(r)) / rays;
                own += along(ws, (1 - depth) * way + aside * (std::cos(turn) * frame[0] + std::sin(turn) * frame[1]));
            }
            sum += rings[r].part / rays * own;
        }
        return sum;
    }

    const ViewScene& m_scene;
    const Light& m_sky;
    bool m_blocked, m_attenuated;
    const CutPhase& m_cut;
    const Octave& m_octave;
    const MediaTogether& m_media;
};

// True if so much lies between the eye and a place that what it shows does not count. All of it hides what is behind.
bool isHidden(const ViewScene& scene, const MediaTogether& media, const Vec3& ws) {
    constexpr double kHidden = 12;  // optical depth
    const double distance = scene.camera.type == CameraType::orthographic ? std::numeric_limits<double>::infinity()
                                                                          : glm::distance(ws, scene.camera.wsPosition);
    const Rgb depth = opticalDepth(media, ws, travelToEye(scene.camera, ws), distance, kHidden);
    return std::min({depth.x, depth.y, depth.z}) >= kHidden;
}

// The largest optical depth of a cell.
double depthOfCell(const CellMedia& media) {
    double most = 0;
    for (const std::vector<Real>& channel : media.extinction)
        for (const Real value : channel) most = std::max(most, double(value));
    return most * media.grid.edge();
}

// The most directions that stand for a sky with peaks.
std::size_t mostDirections(const Sources& sources, const std::vector<WidePhase>& wide) {
    std::size_t most = 0;
    for (std::size_t owner = 0; owner < wide.size(); ++owner)
        if (wide[owner].ofSky)
            most = std::max(most, std::size_t(std::ranges::count(sources.owners, static_cast<int>(owner))));
    return most;
}

}  // namespace

void addPeaks(const ViewScene& scene, const Sources& sources, const std::vector<WidePhase>& wide, const Octave& octave,
              const MediaTogether& media, CellField& field, const std::function<void()>& checkpoint) {
    if (std::ranges::none_of(wide, [](const WidePhase& own) { return own.ofSky.has_value(); })) return;
    checkpoint();
    // Rays take their time: in larger cells where there are many, between which their light is interpolated, as long as
    // these are thin. Disney's cloud with droplets and 0.3 a voxel was 20, 4.5 and 2.1 % off with cells of 4, 1 and 0.5
    // voxels. A rough look with a few directions (verify/light_cell_pilot.h) has rough peaks, too.
    constexpr std::size_t kFewCells = 60'000, kMostCells = 2'000'000, kFewDirections = 64;
    constexpr double kThin = 0.35;
    const std::size_t mostCells = mostDirections(sources, wide) < kFewDirections ? 0 : kMostCells;
    CellMedia larger;
    const CellMedia* through = media.front();
    while (through->grid.cells() > kFewCells) {
        if (through->grid.cells() <= mostCells && 2 * depthOfCell(*through) > kThin) break;
        CellMedia next = coarser(*through);
        if (next.grid.cells() >= through->grid.cells()) break;
        larger = std::move(next);
        through = &larger;
    }
    MediaTogether all = media;
    all.front() = through;
    std::vector<SkyPeaks> peaks;
    for (std::size_t owner = 0; owner < wide.size(); ++owner)
        if (const auto& cut = wide[owner].ofSky) peaks.emplace_back(scene, sources, owner, *cut, octave, all);
    const bool someHidden = sources.attenuated && std::ranges::none_of(scene.volumes, [](const ViewVolume& volume) {
                                return volume.holdout;
                            });
    const auto light = [&](const Vec3& ws) {
        Rgb sum(0);
        if (someHidden && isHidden(scene, all, ws)) return sum;
        for (const SkyPeaks& sky : peaks) sum += sky.at(ws);
        return sources.colours == 1 ? Rgb(largest(sum) / largest(sources.tint)) : sum;
    };
    if (through == media.front()) return field.add(light);
    CellField coarse(std::make_shared<const CellGrid>(larger.grid), static_cast<int>(sources.colours));
    coarse.add(light);
    field.add([&](const Vec3& ws) {
        Real rgb[3];
        coarse.sample(ws, rgb);
        return Rgb(rgb[0], rgb[1], rgb[2]);
    });
}

}  // namespace scrim
