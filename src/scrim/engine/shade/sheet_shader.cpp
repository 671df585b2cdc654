// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/shade/sheet_shader.h>

#include <scrim/engine/shade/pass_solids.h>
#include <scrim/engine/shade/sheet_rows.h>
#include <scrim/engine/splat/surface.h>
#include <scrim/engine/splat/plane_stack.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstring>

namespace scrim {
namespace {

using Row = SheetShader::GivenRows::Row;

const std::vector<bool>* litOrAll(const Plan& plan, int sceneVolume) {
    const std::vector<bool>& lit = plan.subLights.lit[std::size_t(sceneVolume)];
    return lit.empty() ? nullptr : &lit;
}

void copyTile(const PlaneStack& planes, int p, int tx, int ty, Real* to) {
    const Real* from = planes.tile(p, tx, ty);
    for (int y = 0; y < kTileEdge; ++y, from += planes.rowStride())
        std::memcpy(to + y * kTileEdge, from, kTileEdge * sizeof(Real));
}

}  // namespace

SheetShader::Rows& SheetShader::rowsFor(std::size_t lights) const {
    thread_local Rows rows;
    const auto grow = [](auto& kind, std::size_t count) {
        if (kind.size() < count) kind.resize(count);
    };
    const auto channels = std::size_t(m_plan.extinction.count());
    grow(rows.total, channels);
    grow(rows.seen, m_holdouts ? channels : 0);
    grow(rows.medium, m_media.size());
    grow(rows.scatter, 3 * m_media.size());
    grow(rows.flow, m_motion ? 3 * m_media.size() : 0);
    grow(rows.motion, m_motion ? 2 : 0);
    grow(rows.emission, m_emissions.size());
    grow(rows.coarser, 2);
    grow(rows.more, m_surfaces.empty() ? 0 : 1);
    // There is always a first row, even if all lights are on cells.
    grow(rows.tauIn, std::max<std::size_t>(lights * channels, 1));
    grow(rows.tauOut, surfacesAlone() ? rows.tauIn.size() : 0);
    grow(rows.unblocked, m_lights.passSolids() ? std::max<std::size_t>(lights, 1) : 0);
    grow(rows.onCells, 3 * m_scatteredParts.size());
    grow(rows.outputs, 3 * std::size_t(m_group.outputs.layout.outputs - 1) + 1);
    grow(rows.classified, m_surfaces.size());
    rows.surfaces.clear();
    return rows;
}

SheetShader::SheetShader(const ViewScene& scene, const Plan& plan, const LevelSheets& level, const EyeView& eye,
                         const std::vector<CellLight>& cellLight, OtherLevels others)
    : SheetShader(scene, plan, level, eye, std::move(others)) {
    for (int i = 0; i < levels(); ++i) addVolumes(scene, plan, i);
    finishVolumes(scene, cellLight);
}

SheetShader::SheetShader(const ViewScene& scene, const Plan& plan, const LevelSheets& level, const EyeView& eye,
                         OtherLevels others)
    : m_plan(plan),
      m_group(level.group),
      m_extinction(level.extinction),
      m_lights(level.lights),
      m_eye(eye),
      m_others(std::move(others)) {
    for (const LevelSheets* other : m_others.coarser) m_toCoarser.emplace_back(m_group.sheets, other->group.sheets);
    for (const LevelSheets* other : m_others.finer) m_toFiner.emplace_back(m_group.sheets, other->group.sheets);
    for (int c = 0; c < 3; ++c) m_ambient[c] = static_cast<Real>(m_group.primary * scene.ambient[c]);
    m_emitting = static_cast<Real>(m_group.primary);
    m_unlit.resize(m_plan.subLights.lights.size());
}

void SheetShader::finishVolumes(const ViewScene& scene, const std::vector<CellLight>& cellLight) {
    m_opacities = !m_group.outputs.opacities.empty();
    if (m_group.outputs.layout.motion) m_motion.emplace(scene, m_group.sheets);
    m_alone = m_media.size() == 1 && m_surfaces.empty() && m_plan.extinction.count() == 1 && levels() == 1;
    if (m_group.primary > 0) chooseScattered(cellLight);
}

// Adds the looks of the volumes and emissions of a level.
void SheetShader::addVolumes(const ViewScene& scene, const Plan& plan, int level) {
    for (const ExtinctionSum::Emission& emission : extinctionOf(level).emissions())
        m_emissions.emplace_back(level, &emission);
    for (const ExtinctionSum::Volume& own : extinctionOf(level).volumes()) {
        const ViewVolume& volume = scene.volumes[own.sceneVolume];
        if (seesBalls(plan, volume)) continue;
        const Seen seen{level, &own, volume.holdout, own.scatter[0] != nullptr};
        m_holdouts = m_holdouts || volume.holdout;
        if (volume.classified) {
            SheetSurface& look = m_surfaces.emplace_back(surfaceOf(*volume.classified));
            m_surfaceVolumes.push_back(seen);
            look.lit = litOrAll(plan, own.sceneVolume);
            look.sceneVolume = own.sceneVolume;
            look.output = outputOf(look.sceneVolume);
            continue;
        }
        addMedium(scene, plan, seen);
    }
}

void SheetShader::addMedium(const ViewScene& scene, const Plan& plan, const Seen& seen) {
    const int sceneVolume = seen.volume->sceneVolume;
    const ViewVolume& volume = scene.volumes[std::size_t(sceneVolume)];
    // A held-out volume scatters nothing.
    const Rgb reflects = volume.holdout ? Rgb(0) : seen.grid ? Rgb(1) : volume.medium.albedo;
    const Rgb albedo = reflects * volume.medium.relativeTint();
    SheetMedium look{
        {}, {}, volume.medium.phase, volume.medium.octaves, volume.holdout ? &m_unlit : litOrAll(plan, sceneVolume)};
    for (int c = 0; c < 3; ++c) look.albedo[c] = static_cast<Real>(albedo[c]);
    look.ambient = !scattersFully(volume);
    look.output = outputOf(sceneVolume);
    look.caps = plan.caps[std::size_t(sceneVolume)].get();
    m_media.push_back(look);
    m_tints.push_back(volume.medium.relativeTint());
    m_mediumVolumes.push_back(seen);
}

// Light on cells belongs to no sweep's lights; the sweeps that own alpha show it.
void SheetShader::chooseScattered(const std::vector<CellLight>& cellLight) {
    for (const CellLight& light : cellLight) {
        int output = 0;
        for (std::size_t i = 0; light.output && i < m_group.outputs.list.size(); ++i)
            if (m_group.outputs.list[i] == *light.output) output = static_cast<int>(i) + 1;
        const auto show = [&](const Seen& seen, std::size_t medium, int surface) {
            const auto& field = light.ofVolume[seen.volume->sceneVolume];
            if (!field || seen.held) return;
            m_scatteredParts.push_back({static_cast<int>(medium),
                                        surface,
                                        {},
                                        static_cast<Real>(m_group.primary),
                                        output,
                                        light.again,
                                        light.as});
            m_scatteredFields.push_back(field);
        };
        for (std::size_t i = 0; i < m_media.size(); ++i) show(m_mediumVolumes[i], i, -1);
        for (std::size_t i = 0; i < m_surfaces.size(); ++i) show(m_surfaceVolumes[i], 0, static_cast<int>(i));
    }
}

void SheetShader::lookUpScattered(int sheet, const SampleTile& samples, Rows& rows) const {
    rows.scattered.clear();
    if (m_scatteredParts.empty()) return;
    const Sheets& sheets = m_group.sheets;
    const auto at = [&](int u, int v, int on) { return sheets.wsPoint({u, v, sheet + 0.5 + on}); };
    const Vec3 origin = at(0, 0, 0), perU = at(1, 0, 0) - origin, perV = at(0, 1, 0) - origin;
    const SamplePlane plane{
        origin,     perU, perV, at(0, 0, 1) - origin, sheets.thickness / sheets.texel, m_group.sameSide ? -1.0 : 1.0,
        m_plan.simd};
    // Most samples of a tile at the border of a volume lie beside it.
    Row medium{};  // mean extinction
    for (int c = 0; c < m_plan.extinction.count(); ++c) {
        const Rgb& tint = m_plan.extinction.tints[std::size_t(c)];
        const auto part = static_cast<Real>((tint.x + tint.y + tint.z) / 3);
        for (int k = 0; k < kTileSize; ++k) medium.values[k] += part * rows.total[std::size_t(c)].values[k];
    }
    Row nearer{};  // of the halves of the sheet that are nearer to the eye
    for (int k = 0; !m_surfaces.empty() && k < kTileSize; ++k)
        nearer.values[k] = std::max(medium.values[k] + (m_group.sameSide ? 1 : -1) * rows.more[0].values[k], Real(0));
    for (std::size_t i = 0; i < m_scatteredParts.size(); ++i) {
        SheetScattered part = m_scatteredParts[i];
        if (part.surface >= 0) {  // where it is among those that are visible here
            const int volume = m_surfaces[std::size_t(part.surface)].sceneVolume;
            const auto own = std::ranges::find(rows.surfaces, volume, &SheetSurface::sceneVolume);
            if (own == rows.surfaces.end()) continue;
            part.surface = static_cast<int>(own - rows.surfaces.begin());
        }
        // Of several media each is looked up only where it is.
        Row there;
        const bool apart = part.surface < 0 && m_media.size() > 1;
        if (apart) {
            const Real* extinction = rows.medium[std::size_t(part.medium)].values;
            Real most = 0;
            for (int k = 0; k < kTileSize; ++k) {
                most = std::max(most, extinction[k]);
                there.values[k] = extinction[k] > 0 ? medium.values[k] : Real(0);
            }
            if (!(most > 0)) continue;
        }
        Row* const own = rows.onCells.data() + 3 * i;
        Real* const rgb[3] = {own[0].values, own[1].values, own[2].values};
        m_scatteredFields[i]->lookUp(plane, samples, apart ? there.values : medium.values, rgb,
                                     part.as == ShownAs::scattered ? nullptr : nearer.values);
        std::copy(rgb, rgb + 3, part.radiance);
        rows.scattered.push_back(part);
    }
}

// The output of a volume's own layer.
std::optional<int> SheetShader::outputOf(int sceneVolume) const {
    if (m_group.outputs.ofVolumes.empty()) return std::nullopt;
    return m_group.outputs.ofVolumes[std::size_t(sceneVolume)];
}

// Fills the rows of all media; read(level, planes, to) reads one row of one medium.
template <class Read>
void SheetShader::gather(const Read& read, Rows& rows) const {
    // If there are surfaces, `classify` computes the sum.
    for (int level = 0; level < levels() && m_surfaces.empty(); ++level)
        for (int i = 0; i < m_plan.extinction.count(); ++i) {
            if (level == 0) {
                read(level, m_extinction.seen(i), rows.total[i].values);
                continue;
            }
            Row own;
            read(level, extinctionOf(level).seen(i), own.values);
            addTimes(1, own.values, rows.total[i].values);
        }
    for (std::size_t i = 0; i < m_media.size(); ++i) {
        const Seen& seen = m_mediumVolumes[i];
        const ExtinctionSum::Volume& volume = *seen.volume;
        const bool grid = seen.grid;
        if (grid)
            for (int c = 0; c < 3; ++c) read(seen.level, *volume.scatter[c], rows.scatter[3 * i + c].values);
        const bool looked = m_media.size() > 1 && !m_scatteredParts.empty();
        if (!m_surfaces.empty() || m_holdouts || looked || !(grid || m_alone) || m_motion || m_opacities)
            read(seen.level, volume.extinction(), rows.medium[i].values);
        for (int c = 0; volume.flow[0] && c < 3; ++c) read(seen.level, *volume.flow[c], rows.flow[3 * i + c].values);
    }
    for (int i = 0; m_holdouts && i < m_plan.extinction.count(); ++i)
        std::fill(rows.seen[i].values, rows.seen[i].values + kTileSize, Real(0));
    for (std::size_t i = 0; m_holdouts && i < m_media.size(); ++i)
        addSeen(m_mediumVolumes[i], rows.medium[i].values, rows);
    for (std::size_t e = 0; e < m_emissions.size(); ++e)
        read(m_emissions[e].first, *m_emissions[e].second->planes, rows.emission[e].values);
}

// Adds the extinction of a volume to the visible sum, unless it is held out.
void SheetShader::addSeen(const Seen& volume, const Real* extinction, Rows& rows) const {
    if (!m_holdouts || volume.held) return;
    const std::vector<Real>& weights = m_plan.extinction.weights[volume.volume->sceneVolume];
    for (int i = 0; i < m_plan.extinction.count(); ++i) addTimes(weights[i], extinction, rows.seen[i].values);
}

ShadeWork SheetShader::shadeTexels(int p, int sheet, int tx, int ty, Real* out) const {
    SampleTile samples;
    m_eye.setTexels(sheet + 0.5, tx * kTileEdge, ty * kTileEdge, samples);
    // Surfaces are classified along eye rays, which a plane's texels do not know: texels are treated like points.
    if (!m_surfaces.empty()) {
        ShadeWork work;
        if (!shadePoints(p, samples, nullptr, false, out, work))
            std::fill(out, out + m_group.outputs.layout.floats() * kTileSize, Real(0));
        return work;
    }

    const LightSweep::OnSheet& lights = m_lights.onSheet(p);
    Rows& rows = rowsFor(lights.lights.size());
    gather([&](int, const PlaneStack& planes, Real* to) { copyTile(planes, p, tx, ty, to); }, rows);
    for (std::size_t i = 0; i < lights.shadows.size(); ++i)
        if (lights.shadows[i]) lights.shadows[i]->lookUpTile(p, tx * kTileEdge, ty * kTileEdge, rows.tauIn[i].values);
    passSolids(m_lights.onSheet(p), m_group.sheets, samples, rows.unblocked);
    lookUpScattered(lights.sheet, samples, rows);
    return shadeTile(inputOf(p, samples, rows), out);
}

bool SheetShader::shadePoints(int p, const SampleTile& samples, const std::uint8_t* open, bool onward, Real* out,
                              ShadeWork& work) const {
    Rows& rows = rowsFor(m_lights.onSheet(p).lights.size());
    gatherPoints(p, samples, rows);
    classify(p, samples, open, onward, rows, work);
    return shadeGathered(p, samples, rows, out, work);
}

bool SheetShader::shadeCells(int p, const SampleTile& samples, const Int2& cells, const std::uint8_t* open, bool onward,
                             Real* out, ShadeWork& work) const {
    Rows& rows = rowsFor(m_lights.onSheet(p).lights.size());
    gather([&](int, const PlaneStack& planes, Real* to) { copyTile(planes, p, cells.x, cells.y, to); }, rows);
    SampleTile atCells{};  // a cell is the same ray on every plane
    for (int k = 0; k < kTileSize; ++k) {
        atCells.u[k] = static_cast<Real>(cells.x * kTileEdge + k % kTileEdge);
        atCells.v[k] = static_cast<Real>(cells.y * kTileEdge + k / kTileEdge);
    }
    classify(p, atCells, open, onward, rows, work);
    return shadeGathered(p, samples, rows, out, work);
}

// Lights what the rows hold.
bool SheetShader::shadeGathered(int p, const SampleTile& samples, Rows& rows, Real* out, ShadeWork& work) const {
    const LightSweep::OnSheet& lights = m_lights.onSheet(p);
    SampleRows lit;
    for (int i = 0; i < m_plan.extinction.count(); ++i) lit.include(rows.total[std::size_t(i)].values);
    if (!lit.any() && !glows(rows)) return false;
    addLit(rows, lit);
    if (surfacesAlone())
        for (std::size_t i = 0; i < lights.shadows.size(); ++i) {
            Real *const enters = rows.tauIn[i].values, *const leaves = rows.tauOut[i].values;
            if (lights.shadows[i])
                m_lights.lookUpEnds(p, i, samples, m_extinction.surfacesAlone(), rows.total[0].values,
                                    m_group.sameSide ? enters : leaves, m_group.sameSide ? leaves : enters);
        }
    else
        for (std::size_t i = 0; i < lights.shadows.size(); ++i) {
            if (!lights.shadows[i]) continue;
            Real* const tau = rows.tauIn[i].values;
            std::fill_n(tau, kTileSize, Real(0));
            if (!lit.any()) continue;
            const int at = lit.begin();
            lights.shadows[i]->lookUpPoints(p, samples.u + at, samples.v + at, lit.count(), tau + at);
        }
    addCoarserShadows(p, samples, rows);
    addFinerShadows(p, samples, rows);
    passSolids(m_lights.onSheet(p), m_group.sheets, samples, rows.unblocked);
    lookUpScattered(lights.sheet, samples, rows);
    work += shadeTile(inputOf(p, samples, rows), out);
    return true;
}

// Fills the rows of all media at points of plane p, of coarser levels where the points lie in their sheets.
void SheetShader::gatherPoints(int p, const SampleTile& samples, Rows& rows) const {
    int at = 0;  // the level that the positions in rows.coarser belong to
    gather(
        [&](int level, const PlaneStack& planes, Real* to) {
            if (level == 0) {
                samplePoints(planes.view(p, m_plan.simd), samples.u, samples.v, false, kTileSize, to);
                return;
            }
            Real *const u = rows.coarser[0].values, *const v = rows.coarser[1].values;
            const LevelMap& map = m_toCoarser[std::size_t(level - 1)];
            for (int k = 0; k < kTileSize && at != level; ++k) {
                u[k] = static_cast<Real>(map.u(samples.u[k]));
                v[k] = static_cast<Real>(map.v(samples.v[k]));
            }
            at = level;
            samplePoints(planes.view(0, m_plan.simd), u, v, false, kTileSize, to);
        },
        rows);
}

// Adds what coarser levels take from the lights on the way to sheet p, to a fraction of their own sheets.
void SheetShader::addCoarserShadows(int p, const SampleTile& samples, Rows& rows) const {
    const LightSweep::OnSheet& lights = m_lights.onSheet(p);
    const int channels = m_plan.extinction.count();
    Real *const u = rows.coarser[0].values, *const v = rows.coarser[1].values;
    alignas(64) Real tau[kTileSize];
    for (std::size_t level = 0; level < m_others.coarser.size() && !lights.shadows.empty(); ++level) {
        const LevelSheets& other = *m_others.coarser[level];
        const LevelMap& map = m_toCoarser[level];
        for (int k = 0; k < kTileSize; ++k) {
            u[k] = static_cast<Real>(map.u(samples.u[k]));
            v[k] = static_cast<Real>(map.v(samples.v[k]));
        }
        const double plane = map.n(lights.sheet + 0.5);
        const double part = std::clamp(map.n(lights.sheet) - other.sheet, 0.0, 1.0);
        for (std::size_t i = 0; i < lights.shadows.size(); ++i) {
            const auto light = lights.numbers[i / std::size_t(channels)];
            const Shadow* shadow = other.lights.shadow(light, static_cast<int>(i) % channels);
            if (shadow == nullptr) continue;
            shadow->lookUpWithin(plane, static_cast<Real>(part), u, v, kTileSize, tau);
            addTimes(1, tau, rows.tauIn[i].values);
            if (surfacesAlone()) addTimes(1, tau, rows.tauOut[i].values);
        }
    }
}

namespace {

// The box around the first, last and corner samples of a tile, which lie in rows of 16, moved by
// `away` sheets along the eye's rays; `toTexels` turns slopes into texels a sheet.
Box2<double> boxAlong(const SampleTile& samples, double away, double toTexels) {
    auto box = Box2<double>::nothing();
    for (const int k : {0, kTileEdge - 1, kTileSize - kTileEdge, kTileSize - 1})
        box.include(samples.u[k] + away * toTexels * samples.eyeA[k], samples.v[k] + away * toTexels * samples.eyeB[k]);
    return box;
}

}  // namespace

// Adds what finer levels take from the lights. Their shadows may be much narrower than this level's
// sheets are thick: light is averaged over points of the eye's ray through the sheet, as many as
// the shadow's cells that it crosses ask for.
void SheetShader::addFinerShadows(int p, const SampleTile& samples, Rows& rows) const {
    constexpr double kCells = 2;
    constexpr int kMost = 32;
    const LightSweep::OnSheet& lights = m_lights.onSheet(p);
    const auto channels = std::size_t(m_plan.extinction.count());
    const double toTexels = m_group.sheets.thickness / m_group.sheets.texel;
    struct Other {
        const Shadow* shadow;
        const LevelMap* map;
    };
    for (std::size_t i = 0; i < lights.shadows.size() && !m_others.finer.empty(); ++i) {
        std::vector<Other> others;
        double cells = 0;
        for (std::size_t level = 0; level < m_others.finer.size(); ++level) {
            const LevelMap& map = m_toFiner[level];
            const Shadow* shadow =
                m_others.finer[level]->lights.shadow(lights.numbers[i / channels], static_cast<int>(i % channels));
            if (shadow == nullptr) continue;
            const auto at = [&](double away) {
                return shadow->cellsOf(map.box(boxAlong(samples, away, toTexels)), map.n(lights.sheet + 0.5 + away));
            };
            const Box2<double> from = at(-0.5), to = at(0.5);
            Box2<double> all = from;
            all.include(to.x0, to.y0);
            all.include(to.x1, to.y1);
            if (shadow->anyMet(all)) others.push_back({shadow, &map});
            // Those that are not looked up count, too: a crop, which splats less, must have as many points.
            cells = std::max({cells, std::abs(to.x0 - from.x0), std::abs(to.y0 - from.y0), std::abs(to.x1 - from.x1),
                              std::abs(to.y1 - from.y1)});
        }
        if (others.empty()) continue;
        const int points = std::clamp(static_cast<int>(std::ceil(cells / kCells)), 1, kMost);
        alignas(64) Real u[kTileSize], v[kTileSize], tau[kTileSize], sum[kTileSize], light[kTileSize];
        std::fill_n(light, kTileSize, Real(0));
        for (int point = 0; point < points; ++point) {
            const double away = (point + 0.5) / points - 0.5;
            const auto shift = static_cast<Real>(away * toTexels);
            std::fill_n(sum, kTileSize, Real(0));
            for (const Other& other : others) {
                const auto scale = static_cast<Real>(other.map->texels);
                const auto firstU = static_cast<Real>(other.map->first.x),
                           firstV = static_cast<Real>(other.map->first.y);
                for (int k = 0; k < kTileSize; ++k) {
                    u[k] = firstU + scale * (samples.u[k] + shift * samples.eyeA[k]);
                    v[k] = firstV + scale * (samples.v[k] + shift * samples.eyeB[k]);
                }
                other.shadow->lookUpNow(other.map->n(lights.sheet + 0.5 + away), u, v, kTileSize, tau);
                addTimes(1, tau, sum);
            }
            for (int k = 0; k < kTileSize; ++k) light[k] += std::exp(-sum[k]);
        }
        constexpr Real kDark = 80;  // of an optical depth beyond it nothing is left
        for (int k = 0; k < kTileSize; ++k)
            rows.tauIn[i].values[k] +=
                light[k] > 0 ? -std::log(std::min(light[k] / static_cast<Real>(points), Real(1))) : kDark;
    }
}

bool SheetShader::anyCoarser(const Box2<double>& texels) const {
    for (std::size_t level = 0; level < m_others.coarser.size(); ++level) {
        const PlaneStack& covered = m_others.coarser[level]->extinction.seen(0);
        const Box2<double> box = m_toCoarser[level].box(texels);
        if (anyActiveNear(covered, 0, box)) return true;
    }
    return false;
}

// Classifies all surfaces at positions `at` of the eye's lattice, and sets the total extinction to that of the surfaces
// and media there. The sheets' own classified extinction, at texels, only serves lights.
void SheetShader::classify(int p, const SampleTile& at, const std::uint8_t* open, bool onward, Rows& rows,
                           ShadeWork& work) const {
    if (m_surfaces.empty()) return;
    for (ClassifiedTile& seen : rows.classified)
        if (!onward) seen.leave();
    const int channels = m_plan.extinction.count();
    for (int i = 0; i < channels; ++i) std::fill(rows.total[i].values, rows.total[i].values + kTileSize, Real(0));
    std::fill_n(rows.more[0].values, kTileSize, Real(0));
    const auto add = [&](const Seen& volume, const Real* extinction) {
        const std::vector<Real>& weights = m_plan.extinction.weights[volume.volume->sceneVolume];
        for (int i = 0; i < channels; ++i) addTimes(weights[i], extinction, rows.total[i].values);
    };
    for (std::size_t i = 0; i < m_media.size(); ++i) add(m_mediumVolumes[i], rows.medium[i].values);
    for (std::size_t i = 0; i < m_surfaces.size(); ++i) {
        ClassifiedTile& seen = rows.classified[i];
        seen.halves = !m_scatteredParts.empty();
        if (!m_surfaceVolumes[i].volume->surface->classify(p, at, open, seen)) continue;
        work.gradients += kTileSize;
        add(m_surfaceVolumes[i], seen.extinction);
        for (int k = 0; seen.halves && k < kTileSize; ++k)
            rows.more[0].values[k] += seen.firstHalf[k] - seen.extinction[k];
        addSeen(m_surfaceVolumes[i], seen.extinction, rows);
        if (m_surfaceVolumes[i].held) continue;
        SheetSurface surface = m_surfaces[i];
        surface.extinction = seen.extinction;
        for (int c = 0; c < 3; ++c) {
            surface.emission[c] = seen.emission[c];
            surface.normal[c] = seen.normal[c];
        }
        surface.weight = seen.weight;
        rows.surfaces.push_back(surface);
    }
}

// Adds the samples that reflect light. Where all extinction has been rounded to 0, there may be scattering.
void SheetShader::addLit(const Rows& rows, SampleRows& lit) const {
    for (std::size_t i = 0; i < m_media.size(); ++i)
        for (std::size_t c = 0; c < 3 && m_mediumVolumes[i].grid; ++c) lit.include(rows.scatter[3 * i + c].values);
}

bool SheetShader::glows(const Rows& rows) const {
    SampleRows glowing;
    for (std::size_t e = 0; e < m_emissions.size() && !glowing.any(); ++e) glowing.include(rows.emission[e].values);
    return glowing.any();
}

// Surfaces that share sheets with media, or have sheets of their own for each view, are lit like media.
bool SheetShader::surfacesAlone() const {
    return !m_ofBalls && !m_extinction.surfacesAlone().empty() && m_group.lattice.shared();
}

// The mean motion of the volumes at the samples, for the layer `motion`.
void SheetShader::fillMotion(int p, const SampleTile& samples, Rows& rows) const {
    std::vector<ScreenMotion::Part> parts;
    for (std::size_t i = 0; i < m_media.size(); ++i) {
        const ExtinctionSum::Volume& volume = *m_mediumVolumes[i].volume;
        ScreenMotion::Part& part = parts.emplace_back(ScreenMotion::Part{volume.sceneVolume, rows.medium[i].values});
        for (int c = 0; volume.flow[0] && c < 3; ++c) part.flow[c] = rows.flow[3 * i + c].values;
        for (int c = 0; m_ballsFlow && c < 3; ++c) part.velocity[c] = rows.flow[3 * i + c].values;
    }
    for (const SheetSurface& surface : rows.surfaces) parts.push_back({surface.sceneVolume, surface.extinction});
    m_motion->fill(m_lights.onSheet(p).sheet + 0.5, samples, parts, rows.motion[0].values, rows.motion[1].values);
}

// The extinction of volumes whose opacities are wanted, by colour.
void SheetShader::fillOpacities(Rows& rows) const {
    rows.opacities.clear();
    const auto add = [&](int sceneVolume, const Real* extinction, const Rgb& tint) {
        rows.opacities.push_back({extinction, {}, m_group.outputs.opacities[std::size_t(sceneVolume)]});
        for (int c = 0; c < 3; ++c) rows.opacities.back().color[c] = static_cast<Real>(tint[c]);
    };
    for (std::size_t i = 0; m_opacities && i < m_media.size(); ++i)
        if (!m_mediumVolumes[i].held) add(m_mediumVolumes[i].volume->sceneVolume, rows.medium[i].values, m_tints[i]);
    for (std::size_t i = 0; m_opacities && i < rows.surfaces.size(); ++i)
        add(rows.surfaces[i].sceneVolume, rows.surfaces[i].extinction, Rgb(1));
}

// Makes the input of shading from the rows.
ShadeInput SheetShader::inputOf(int p, const SampleTile& samples, Rows& rows) const {
    const LightSweep::OnSheet& lights = m_lights.onSheet(p);
    rows.media = m_media;
    for (std::size_t i = 0; i < m_media.size(); ++i) {
        const bool grid = m_mediumVolumes[i].grid;
        for (int c = 0; c < 3; ++c)
            rows.media[i].scatter[c] = grid      ? rows.scatter[3 * i + c].values
                                       : m_alone ? rows.total[0].values
                                                 : rows.medium[i].values;
    }
    rows.emissions.clear();
    for (std::size_t e = 0; e < m_emissions.size() && m_emitting > 0; ++e) {
        const ExtinctionSum::Emission& source = *m_emissions[e].second;
        SheetEmission& emission = rows.emissions.emplace_back();
        emission.coefficient = rows.emission[e].values;
        emission.output = outputOf(source.sceneVolume);
        for (int c = 0; c < 3; ++c) emission.color[c] = m_emitting * static_cast<Real>(source.color[c]);
    }
    ShadeInput input{};
    input.samples = &samples;
    input.texel = static_cast<Real>(m_group.sheets.texel);
    input.thickness = static_cast<Real>(m_group.sheets.thickness);
    input.sameSide = m_group.sameSide;
    input.coloured = m_plan.extinction.coloured;
    input.channels = m_plan.extinction.count();
    for (int i = 0; i < input.channels; ++i) {
        input.extinction[i] = rows.total[i].values;
        input.seen[i] = m_holdouts ? rows.seen[i].values : nullptr;
        for (int c = 0; c < 3; ++c) input.tints[i][c] = static_cast<Real>(m_plan.extinction.tints[i][c]);
    }
    input.media = rows.media;
    input.surfaces = rows.surfaces;
    input.emissions = rows.emissions;
    input.scattered = rows.scattered;
    fillOpacities(rows);
    input.opacities = rows.opacities;
    input.lights = lights.lights;
    input.tauIn = rows.tauIn[0].values;
    input.tauOut = surfacesAlone() ? rows.tauOut[0].values : nullptr;
    input.unblocked = m_lights.passSolids() ? rows.unblocked.front().values : nullptr;
    std::copy(m_ambient, m_ambient + 3, input.ambient);
    if (m_motion) {
        fillMotion(p, samples, rows);
        for (int c = 0; c < 2; ++c) input.motion[c] = rows.motion[c].values;
    }
    input.layout = m_group.outputs.layout;
    input.outputs = rows.outputs.front().values;
    input.simd = m_plan.simd;
    return input;
}

}  // namespace scrim
