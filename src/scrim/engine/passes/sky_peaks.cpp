// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/passes/sky_peaks.h>

#include <scrim/engine/cells/cell_walk.h>
#include <scrim/scene/picture_cells.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

#include <glm/exponential.hpp>

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
          m_media(media),
          m_depth(cut.spread / kAround) {}

    Rgb at(const Vec3& ws) const {
        const Vec3 toEye = travelToEye(m_scene.camera, ws);
        Rgb sum(0);
        if (m_cut.onwards > kNarrow) sum += m_cut.onwards * around(ws, -toEye);
        if (m_cut.backwards > kNarrow) sum += m_cut.backwards * around(ws, toEye);
        return m_octave.share * sum;
    }

  private:
    // A peak is one ray, or also six around it, so that its mean cosine is kept.
    static constexpr double kNarrow = 1e-3, kAround = 0.75;
    static constexpr int kRays = 6;

    Rgb along(const Vec3& ws, const Vec3& way) const {
        constexpr double kInfinity = std::numeric_limits<double>::infinity();
        const Rgb radiance = skyAt(m_sky, way);
        if (radiance == Rgb(0)) return radiance;
        if (m_blocked && m_scene.solids->firstHit(SolidRole::shadow, ws, way, 0, kInfinity) < kInfinity) return Rgb(0);
        if (!m_attenuated) return radiance;
        return radiance * glm::exp(-m_octave.extinction *
                                   opticalDepth(m_media, ws, way, kInfinity, kMostDepth / m_octave.extinction));
    }
    Rgb around(const Vec3& ws, const Vec3& way) const {
        const Rgb middle = along(ws, way);
        if (m_depth < kNarrow) return middle;
        const double aside = std::sqrt(m_depth * (2 - m_depth));
        const Mat3 frame = frameAround(way);
        Rgb sum(0);
        for (int i = 0; i < kRays; ++i) {
            const double turn = 2 * std::numbers::pi * i / kRays;
            sum += along(ws, (1 - m_depth) * way + aside * (std::cos(turn) * frame[0] + std::sin(turn) * frame[1]));
        }
        return (1 - kAround) * middle + kAround / kRays * sum;
    }

    const ViewScene& m_scene;
    const Light& m_sky;
    bool m_blocked, m_attenuated;
    const CutPhase& m_cut;
    const Octave& m_octave;
    const MediaTogether& m_media;
    double m_depth;  // 1 - cos of the angle of the rays around a peak
};

}  // namespace

void addPeaks(const ViewScene& scene, const Sources& sources, const std::vector<WidePhase>& wide, const Octave& octave,
              const MediaTogether& media, CellField& field, const std::function<void()>& checkpoint) {
    if (std::ranges::none_of(wide, [](const WidePhase& own) { return own.ofSky.has_value(); })) return;
    checkpoint();
    // Rays take their time: in larger cells where there are many, between which their light is interpolated.
    constexpr std::size_t kMostCells = 60'000;
    CellMedia larger;
    const CellMedia* through = media.front();
    while (through->grid.cells() > kMostCells) {
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
    const auto light = [&](const Vec3& ws) {
        Rgb sum(0);
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
