// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/shade/sheet_shader.h>

#include <scrim/engine/splat/surface.h>
#include <scrim/engine/splat/plane_stack.h>

#include <algorithm>
#include <bit>
#include <cstdint>
#include <cstring>
#include <type_traits>

namespace scrim {
namespace {

struct alignas(64) Row {
    Real values[kTileSize];
};

const std::vector<bool>* litOrAll(const ViewVolume& volume) {
    return volume.lights.empty() ? nullptr : &volume.lights;
}

void copyTile(const PlaneStack& planes, int p, int tx, int ty, Real* to) {
    const Real* from = planes.tile(p, tx, ty);
    for (int y = 0; y < kTileEdge; ++y, from += planes.rowStride())
        std::memcpy(to + y * kTileEdge, from, kTileEdge * sizeof(Real));
}

void addTimes(Real weight, const Real* row, Real* sum) {
    if (weight == 0) return;
    for (int k = 0; k < kTileSize; ++k) sum[k] += weight * row[k];
}

}  // namespace

// The data of a tile's samples. It is memory of the thread that only grows, so that shading a tile allocates nothing.
struct SheetShader::Rows {
    std::vector<Row> total;      // sums over all volumes, by extinction channel
    std::vector<Row> seen;       // sums over the visible volumes, by extinction channel; only if some are not visible
    std::vector<Row> medium;     // the extinction of each medium
    std::vector<Row> scatter;    // the scattering of each medium, three colours each
    std::vector<Row> flow;       // the velocity in each medium, three axes each; only for the layer `motion`
    std::vector<Row> motion;     // to the right and up; only for that layer
    std::vector<Row> emission;   // of each source
    std::vector<Row> tauIn;      // by light, and then by extinction channel
    std::vector<Row> tauOut;     // by light; only if surfaces are alone (see surfacesAlone)
    std::vector<Row> unblocked;  // by light; only if solids cast shadows
    std::vector<Row> onCells;    // of each part of the light on cells, three colours each
    std::vector<Row> outputs;    // three colours for each output beside the beauty
    std::vector<ClassifiedTile> classified;
    std::vector<SheetMedium> media;
    std::vector<SheetSurface> surfaces;
    std::vector<SheetEmission> emissions, opacities;
    std::vector<SheetScattered> scattered;
};

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
    grow(rows.emission, m_extinction.emissions().size());
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

SheetShader::SheetShader(const ViewScene& scene, const Plan& plan, const GroupPlan& group,
                         const ExtinctionSum& extinction, const LightSweep& lights, const EyeView& eye,
                         const std::vector<CellLight>& cellLight)
    : m_plan(plan), m_group(group), m_extinction(extinction), m_lights(lights), m_eye(eye) {
    for (int c = 0; c < 3; ++c) m_ambient[c] = static_cast<Real>(group.primary * scene.ambient[c]);
    m_emitting = static_cast<Real>(group.primary);
    m_unlit.resize(scene.lights.size());
    for (std::size_t i = 0; i < extinction.volumes().size(); ++i) {
        const ViewVolume& volume = scene.volumes[extinction.volumes()[i].sceneVolume];
        m_held.push_back(volume.holdout);
        m_holdouts = m_holdouts || volume.holdout;
        if (volume.classified) {
            SheetSurface& look = m_surfaces.emplace_back(surfaceOf(*volume.classified));
            m_surfaceVolumes.push_back(static_cast<int>(i));
            look.lit = litOrAll(volume);
            look.sceneVolume = extinction.volumes()[i].sceneVolume;
            look.output = outputOf(look.sceneVolume);
            continue;
        }
        const bool grid = extinction.volumes()[i].scatter[0] != nullptr;
        // A held-out volume scatters nothing.
        const Rgb own = volume.holdout ? Rgb(0) : grid ? Rgb(1) : volume.medium.albedo;
        const Rgb albedo = own * volume.medium.relativeTint();
        SheetMedium look{
            {}, {}, volume.medium.phase, volume.medium.octaves, volume.holdout ? &m_unlit : litOrAll(volume)};
        for (int c = 0; c < 3; ++c) look.albedo[c] = static_cast<Real>(albedo[c]);
        look.ambient = !scattersFully(volume);
        look.output = outputOf(extinction.volumes()[i].sceneVolume);
        look.caps = plan.caps[std::size_t(extinction.volumes()[i].sceneVolume)].get();
        m_media.push_back(look);
        m_tints.push_back(volume.medium.relativeTint());
        m_mediumVolumes.push_back(static_cast<int>(i));
    }
    m_opacities = !group.outputs.opacities.empty();
    if (group.outputs.layout.motion) m_motion.emplace(scene, group.sheets);
    m_alone = m_media.size() == 1 && m_surfaces.empty() && plan.extinction.count() == 1;
    if (group.primary > 0) chooseScattered(cellLight);
}

// Light on cells belongs to no sweep's lights; the sweeps that own alpha show it.
void SheetShader::chooseScattered(const std::vector<CellLight>& cellLight) {
    for (const CellLight& light : cellLight) {
        int output = 0;
        for (std::size_t i = 0; light.output && i < m_group.outputs.list.size(); ++i)
            if (m_group.outputs.list[i] == *light.output) output = static_cast<int>(i) + 1;
        const auto show = [&](int volume, std::size_t medium, int surface) {
            const auto& field = light.ofVolume[m_extinction.volumes()[volume].sceneVolume];
            if (!field) return;
            m_scatteredParts.push_back(
                {static_cast<int>(medium), surface, {}, static_cast<Real>(m_group.primary), output, light.again});
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
        origin, perU, perV, at(0, 0, 1) - origin, sheets.thickness / sheets.texel, m_group.sameSide ? -1.0 : 1.0};
    // Most samples of a tile at the border of a volume lie beside it.
    Row medium{};  // mean extinction
    for (int c = 0; c < m_plan.extinction.count(); ++c) {
        const Rgb& tint = m_plan.extinction.tints[std::size_t(c)];
        const auto part = static_cast<Real>((tint.x + tint.y + tint.z) / 3);
        for (int k = 0; k < kTileSize; ++k) medium.values[k] += part * rows.total[std::size_t(c)].values[k];
    }
    for (std::size_t i = 0; i < m_scatteredParts.size(); ++i) {
        SheetScattered part = m_scatteredParts[i];
        if (part.surface >= 0) {  // where it is among those that are visible here
            const int volume = m_surfaces[std::size_t(part.surface)].sceneVolume;
            const auto own = std::ranges::find(rows.surfaces, volume, &SheetSurface::sceneVolume);
            if (own == rows.surfaces.end()) continue;
            part.surface = static_cast<int>(own - rows.surfaces.begin());
        }
        Row* const own = rows.onCells.data() + 3 * i;
        Real* const rgb[3] = {own[0].values, own[1].values, own[2].values};
        m_scatteredFields[i]->lookUp(plane, samples, medium.values, rgb);
        std::copy(rgb, rgb + 3, part.radiance);
        rows.scattered.push_back(part);
    }
}

// The output of a volume's own layer; 0: none.
int SheetShader::outputOf(int sceneVolume) const {
    return m_group.outputs.ofVolumes.empty() ? 0 : m_group.outputs.ofVolumes[std::size_t(sceneVolume)];
}

// Fills the rows of all media; read(planes, to) reads one row of one medium.
template <class Read>
void SheetShader::gather(const Read& read, Rows& rows) const {
    // If there are surfaces, `classify` computes the sum.
    if (m_surfaces.empty())
        for (int i = 0; i < m_plan.extinction.count(); ++i) read(m_extinction.total(i), rows.total[i].values);
    for (std::size_t i = 0; i < m_media.size(); ++i) {
        const ExtinctionSum::Volume& volume = m_extinction.volumes()[m_mediumVolumes[i]];
        const bool grid = volume.scatter[0] != nullptr;
        if (grid)
            for (int c = 0; c < 3; ++c) read(*volume.scatter[c], rows.scatter[3 * i + c].values);
        if (!m_surfaces.empty() || m_holdouts || !(grid || m_alone) || m_motion || m_opacities)
            read(volume.extinction(), rows.medium[i].values);
        for (int c = 0; volume.flow[0] && c < 3; ++c) read(*volume.flow[c], rows.flow[3 * i + c].values);
    }
    for (int i = 0; m_holdouts && i < m_plan.extinction.count(); ++i)
        std::fill(rows.seen[i].values, rows.seen[i].values + kTileSize, Real(0));
    for (std::size_t i = 0; m_holdouts && i < m_media.size(); ++i)
        addSeen(std::size_t(m_mediumVolumes[i]), rows.medium[i].values, rows);
    for (std::size_t e = 0; e < m_extinction.emissions().size(); ++e)
        read(*m_extinction.emissions()[e].planes, rows.emission[e].values);
}

// Adds the extinction of one of m_extinction's volumes to the visible sum, unless it is held out.
void SheetShader::addSeen(std::size_t volume, const Real* extinction, Rows& rows) const {
    if (!m_holdouts || m_held[volume]) return;
    const std::vector<Real>& weights = m_plan.extinction.weights[m_extinction.volumes()[volume].sceneVolume];
    for (int i = 0; i < m_plan.extinction.count(); ++i) addTimes(weights[i], extinction, rows.seen[i].values);
}

ShadeWork SheetShader::shadeTexels(int p, int sheet, int tx, int ty, Real* out) const {
    SampleTile samples;
    m_eye.setTexels(sheet + 0.5, tx * kTileEdge, ty * kTileEdge, samples);
    // Surfaces are classified along eye rays, which a plane's texels do not know: texels are treated like points.
    if (!m_surfaces.empty()) {
        ShadeWork work;
        if (!shadePoints(p, samples, std::nullopt, nullptr, false, out, work))
            std::fill(out, out + m_group.outputs.layout.floats() * kTileSize, Real(0));
        return work;
    }

    const LightSweep::OnSheet& lights = m_lights.onSheet(p);
    Rows& rows = rowsFor(lights.lights.size());
    gather([&](const PlaneStack& planes, Real* to) { copyTile(planes, p, tx, ty, to); }, rows);
    for (std::size_t i = 0; i < lights.shadows.size(); ++i)
        if (lights.shadows[i]) lights.shadows[i]->lookUpTile(p, tx * kTileEdge, ty * kTileEdge, rows.tauIn[i].values);
    passSolids(p, samples, rows);
    lookUpScattered(lights.sheet, samples, rows);
    return shadeTile(inputOf(p, samples, rows), out);
}

bool SheetShader::shadePoints(int p, const SampleTile& samples, const std::optional<Int2>& cells,
                              const std::uint8_t* open, bool onward, Real* out, ShadeWork& work) const {
    const LightSweep::OnSheet& lights = m_lights.onSheet(p);
    Rows& rows = rowsFor(lights.lights.size());
    if (cells)
        gather([&](const PlaneStack& planes, Real* to) { copyTile(planes, p, cells->x, cells->y, to); }, rows);
    else
        gather([&](const PlaneStack& planes,
                   Real* to) { samplePoints(planes.view(p, m_plan.simd), samples.u, samples.v, false, kTileSize, to); },
               rows);
    if (!m_surfaces.empty()) {
        // A cell is the same ray on every plane.
        SampleTile atCells{};
        if (cells)
            for (int k = 0; k < kTileSize; ++k) {
                atCells.u[k] = static_cast<Real>(cells->x * kTileEdge + k % kTileEdge);
                atCells.v[k] = static_cast<Real>(cells->y * kTileEdge + k / kTileEdge);
            }
        for (ClassifiedTile& seen : rows.classified)
            if (!onward) seen.leave();
        classify(p, cells ? atCells : samples, open, rows, work);
    }
    if (!shows(rows)) return false;
    if (surfacesAlone())
        for (std::size_t i = 0; i < lights.shadows.size(); ++i) {
            Real *const enters = rows.tauIn[i].values, *const leaves = rows.tauOut[i].values;
            if (lights.shadows[i])
                m_lights.lookUpEnds(p, i, samples, m_extinction.surfacesAlone(), rows.total[0].values,
                                    m_group.sameSide ? enters : leaves, m_group.sameSide ? leaves : enters);
        }
    else
        for (std::size_t i = 0; i < lights.shadows.size(); ++i)
            if (lights.shadows[i])
                lights.shadows[i]->lookUpPoints(p, samples.u, samples.v, kTileSize, rows.tauIn[i].values);
    passSolids(p, samples, rows);
    lookUpScattered(lights.sheet, samples, rows);
    work += shadeTile(inputOf(p, samples, rows), out);
    return true;
}

// Classifies all surfaces at positions `at` of the eye's lattice, and sets the total extinction to that of the surfaces
// and media there. The sheets' own classified extinction, at texels, only serves lights.
void SheetShader::classify(int p, const SampleTile& at, const std::uint8_t* open, Rows& rows, ShadeWork& work) const {
    const int channels = m_plan.extinction.count();
    for (int i = 0; i < channels; ++i) std::fill(rows.total[i].values, rows.total[i].values + kTileSize, Real(0));
    const auto add = [&](int volume, const Real* extinction) {
        const std::vector<Real>& weights = m_plan.extinction.weights[m_extinction.volumes()[volume].sceneVolume];
        for (int i = 0; i < channels; ++i) addTimes(weights[i], extinction, rows.total[i].values);
    };
    for (std::size_t i = 0; i < m_media.size(); ++i) add(m_mediumVolumes[i], rows.medium[i].values);
    for (std::size_t i = 0; i < m_surfaces.size(); ++i) {
        ClassifiedTile& seen = rows.classified[i];
        if (!m_extinction.volumes()[m_surfaceVolumes[i]].surface->classify(p, at, open, seen)) continue;
        work.gradients += kTileSize;
        add(m_surfaceVolumes[i], seen.extinction);
        addSeen(std::size_t(m_surfaceVolumes[i]), seen.extinction, rows);
        if (m_held[std::size_t(m_surfaceVolumes[i])]) continue;
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

// True if there is extinction or emission at any of the samples.
bool SheetShader::shows(const Rows& rows) const {
    const auto any = [](const Real* values) {
        using Bits = std::conditional_t<sizeof(Real) == 4, std::uint32_t, std::uint64_t>;
        Bits all = 0;  // a loop over floats with an early exit would not be vectorised
        for (int k = 0; k < kTileSize; ++k) all |= std::bit_cast<Bits>(values[k]);
        return all != 0;
    };
    for (int i = 0; i < m_plan.extinction.count(); ++i)
        if (any(rows.total[i].values)) return true;
    for (std::size_t e = 0; e < m_extinction.emissions().size(); ++e)
        if (any(rows.emission[e].values)) return true;
    return false;
}

// Surfaces that share sheets with media, or have sheets of their own for each view, are lit like media.
bool SheetShader::surfacesAlone() const {
    return !m_extinction.surfacesAlone().empty() && m_group.lattice.shared();
}

// The fraction of each light that passes the solids to the samples.
void SheetShader::passSolids(int p, const SampleTile& samples, Rows& rows) const {
    const LightSweep::OnSheet& lights = m_lights.onSheet(p);
    for (std::size_t i = 0; i < lights.solids.size(); ++i) {
        std::fill_n(rows.unblocked[i].values, kTileSize, Real(1));
        if (lights.solids[i]) lights.solids[i]->multiply(lights.sheet, samples.u, samples.v, rows.unblocked[i].values);
    }
}

// The mean motion of the volumes at the samples, for the layer `motion`.
void SheetShader::fillMotion(int p, const SampleTile& samples, Rows& rows) const {
    std::vector<ScreenMotion::Part> parts;
    for (std::size_t i = 0; i < m_media.size(); ++i) {
        const ExtinctionSum::Volume& volume = m_extinction.volumes()[m_mediumVolumes[i]];
        ScreenMotion::Part& part = parts.emplace_back(ScreenMotion::Part{volume.sceneVolume, rows.medium[i].values});
        for (int c = 0; volume.flow[0] && c < 3; ++c) part.flow[c] = rows.flow[3 * i + c].values;
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
        if (const auto v = std::size_t(m_mediumVolumes[i]); !m_held[v])
            add(m_extinction.volumes()[v].sceneVolume, rows.medium[i].values, m_tints[i]);
    for (std::size_t i = 0; m_opacities && i < rows.surfaces.size(); ++i)
        add(rows.surfaces[i].sceneVolume, rows.surfaces[i].extinction, Rgb(1));
}

// Makes the input of shading from the rows.
ShadeInput SheetShader::inputOf(int p, const SampleTile& samples, Rows& rows) const {
    const LightSweep::OnSheet& lights = m_lights.onSheet(p);
    rows.media = m_media;
    for (std::size_t i = 0; i < m_media.size(); ++i) {
        const bool grid = m_extinction.volumes()[m_mediumVolumes[i]].scatter[0] != nullptr;
        for (int c = 0; c < 3; ++c)
            rows.media[i].scatter[c] = grid      ? rows.scatter[3 * i + c].values
                                       : m_alone ? rows.total[0].values
                                                 : rows.medium[i].values;
    }
    rows.emissions.clear();
    for (std::size_t e = 0; e < m_extinction.emissions().size() && m_emitting > 0; ++e) {
        SheetEmission& emission = rows.emissions.emplace_back();
        emission.coefficient = rows.emission[e].values;
        emission.output = outputOf(m_extinction.emissions()[e].sceneVolume);
        for (int c = 0; c < 3; ++c)
            emission.color[c] = m_emitting * static_cast<Real>(m_extinction.emissions()[e].color[c]);
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
