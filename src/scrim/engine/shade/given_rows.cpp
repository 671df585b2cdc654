// SPDX-License-Identifier: Apache-2.0
// The shader of balls: samples whose rows are given, and which lie at places of their own in a sheet.
#include <scrim/engine/shade/pass_solids.h>
#include <scrim/engine/shade/sheet_rows.h>
#include <scrim/engine/splat/plane_stack.h>

#include <algorithm>
#include <cmath>

namespace scrim {

SheetShader::SheetShader(const ViewScene& scene, const Plan& plan, const LevelSheets& level, const EyeView& eye,
                         const std::vector<CellLight>& cellLight, OtherLevels others, std::size_t ofBalls)
    : SheetShader(scene, plan, level, eye, std::move(others)) {
    const ViewVolume& volume = scene.volumes[ofBalls];
    m_ofBalls = true;
    m_ballVolume.sceneVolume = static_cast<int>(ofBalls);
    for (const ViewEmission& emission : volume.balls->emission)
        m_ballEmissions.push_back({nullptr, emission.color, static_cast<int>(ofBalls)});
    for (const ExtinctionSum::Emission& emission : m_ballEmissions) m_emissions.emplace_back(0, &emission);
    m_holdouts = std::ranges::any_of(scene.volumes, &ViewVolume::holdout);
    addMedium(scene, plan, {0, &m_ballVolume, volume.holdout, !volume.balls->scatter.empty()});
    finishVolumes(scene, cellLight);
    m_ballsFlow = m_motion && !volume.balls->velocity.empty();
}

void SheetShader::shadeGiven(int p, const SampleTile& samples, const GivenRows& given, Real* out,
                             ShadeWork& work) const {
    const LightSweep::OnSheet& lights = m_lights.onSheet(p);
    Rows& rows = rowsFor(lights.lights.size());
    const auto copy = [](const Real* from, GivenRows::Row& to) { std::copy_n(from, kTileSize, to.values); };
    const std::vector<Real>& weights = m_plan.extinction.weights[std::size_t(m_ballVolume.sceneVolume)];
    for (std::size_t i = 0; i < weights.size(); ++i) {
        std::fill_n(rows.total[i].values, kTileSize, Real(0));
        addTimes(weights[i], given.extinction, rows.total[i].values);
        if (m_holdouts) std::fill_n(rows.seen[i].values, kTileSize, Real(0));
    }
    copy(given.extinction, rows.medium[0]);
    addSeen(m_mediumVolumes[0], given.extinction, rows);
    for (std::size_t c = 0; c < given.scatter.size(); ++c) copy(given.scatter[c].values, rows.scatter[c]);
    for (std::size_t e = 0; e < given.emission.size(); ++e) copy(given.emission[e].values, rows.emission[e]);
    for (std::size_t axis = 0; m_ballsFlow && axis < 3; ++axis) copy(given.velocity[axis].values, rows.flow[axis]);
    addWithinSheet(p, samples, given, rows);
    addCoarserShadows(p, samples, rows);
    addFinerShadows(p, samples, rows);
    passSolids(m_lights.onSheet(p), m_group.sheets, samples, rows.unblocked);
    lookUpScattered(lights.sheet, samples, rows);
    work += shadeTile(inputOf(p, samples, rows), out);
}

// Tau towards each light: where light enters the sheet, and from there to the place of each sample.
void SheetShader::addWithinSheet(int p, const SampleTile& samples, const GivenRows& given, Rows& rows) const {
    const LightSweep::OnSheet& lights = m_lights.onSheet(p);
    const auto channels = std::size_t(m_plan.extinction.count());
    const auto thickness = static_cast<Real>(m_group.sheets.thickness), texel = static_cast<Real>(m_group.sheets.texel);
    alignas(64) Real there[kTileSize];
    for (std::size_t i = 0; i < lights.shadows.size(); ++i) {
        Real* const tau = rows.tauIn[i].values;
        std::fill_n(tau, kTileSize, Real(0));
        if (!lights.shadows[i]) continue;
        lights.shadows[i]->lookUpPoints(p, samples.u, samples.v, kTileSize, tau);
        const SheetLight& light = lights.lights[i / channels];
        if (!light.withinSheet) continue;
        const PlaneStack& planes = m_extinction.total(static_cast<int>(i % channels));
        samplePoints(planes.view(p, m_plan.simd), samples.u, samples.v, false, kTileSize, there);
        for (int k = 0; k < kTileSize; ++k) {
            const Vec2 slope = light.slopesAt(double(samples.u[k]), double(samples.v[k]), double(texel));
            const auto slant = static_cast<Real>(std::sqrt(1 + slope.x * slope.x + slope.y * slope.y));
            tau[k] += given.behind[k] * thickness * slant * there[k];
        }
    }
}

}  // namespace scrim
