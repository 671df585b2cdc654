// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/shade/sheet_shader.h>

#include <scrim/engine/splat/plane_sampling.h>

#include <algorithm>
#include <cstring>

namespace scrim {
namespace {

struct alignas(64) Row {
    float values[kTileSize];
};

// Memory for the samples of a tile, kept by each thread, so that shading a tile allocates nothing.
struct Scratch {
    std::vector<Row> rows;
    std::vector<ClassifiedTile> classified;
    std::vector<SheetMedium> media;
    std::vector<SheetSurface> surfaces;
    std::vector<SheetEmission> emissions;
};

Scratch& threadScratch() {
    thread_local Scratch scratch;
    return scratch;
}

const std::vector<bool>* litOrAll(const ViewVolume& volume) {
    return volume.lights.empty() ? nullptr : &volume.lights;
}

void copyTile(const PlaneStack& planes, int p, int tx, int ty, float* to) {
    const float* from =
        planes.plane(p) + static_cast<std::ptrdiff_t>(ty * kTileEdge) * planes.rowStride() + tx * kTileEdge;
    for (int y = 0; y < kTileEdge; ++y, from += planes.rowStride())
        std::memcpy(to + y * kTileEdge, from, kTileEdge * sizeof(float));
}

}  // namespace

// What is known of a tile's samples: rows of 256 floats, one kind behind the other.
struct SheetShader::Rows {
    Rows(const SheetShader& shader, std::size_t lights) : scratch(threadScratch()) {
        const auto perMedium = std::size_t{4};  // extinction, and what is scattered of red, green and blue
        m_medium = static_cast<std::size_t>(shader.m_plan.extinction.count());
        m_emission = m_medium + perMedium * shader.m_media.size();
        m_tauIn = m_emission + static_cast<std::size_t>(shader.m_fields.emissionCount());
        const std::size_t shadows = lights * static_cast<std::size_t>(shader.m_plan.extinction.count());
        m_pictures = m_tauIn + std::max<std::size_t>(shadows, 1);  // the first is there in any case
        const auto further = static_cast<std::size_t>(shader.m_group.layout.pictures - 1);
        const std::size_t count = m_pictures + 3 * further + 1;
        if (scratch.rows.size() < count) scratch.rows.resize(count);
        if (scratch.classified.size() < shader.m_surfaces.size()) scratch.classified.resize(shader.m_surfaces.size());
        scratch.surfaces.clear();
    }
    /// Of all volumes, by row of extinction.
    float* total(int row) const { return scratch.rows[static_cast<std::size_t>(row)].values; }
    float* medium(std::size_t i) const { return scratch.rows[m_medium + 4 * i].values; }
    float* scatter(std::size_t i, int channel) const {
        return scratch.rows[m_medium + 4 * i + 1 + static_cast<std::size_t>(channel)].values;
    }
    float* emission(std::size_t i) const { return scratch.rows[m_emission + i].values; }
    float* tauIn(std::size_t shadow) const { return scratch.rows[m_tauIn + shadow].values; }
    float* pictures() const { return scratch.rows[m_pictures].values; }

    Scratch& scratch;

  private:
    std::size_t m_medium, m_emission, m_tauIn, m_pictures;
};

SheetShader::SheetShader(const ViewScene& scene, const Plan& plan, const GroupPlan& group, const BatchFields& fields,
                         const BatchLights& lights, const EyeView& eye)
    : m_plan(plan), m_group(group), m_fields(fields), m_lights(lights), m_eye(eye) {
    for (int c = 0; c < 3; ++c) m_ambient[c] = static_cast<float>(group.primary * scene.ambient[c]);
    m_emitting = static_cast<float>(group.primary);
    for (int i = 0; i < fields.volumeCount(); ++i) {
        const ViewVolume& volume = fields.volume(i).volume();
        if (const Classified* c = volume.classified.get()) {
            SheetSurface look{};
            look.ambient = static_cast<float>(c->ambient);
            look.diffuse = static_cast<float>(c->diffuse);
            look.specular = static_cast<float>(c->specular);
            look.exponent = static_cast<float>(c->exponent);
            look.twoSided = c->twoSided;
            look.lit = litOrAll(volume);
            m_surfaces.push_back({i, look});
            continue;
        }
        const bool grid = fields.scatter(i, 0) != nullptr;
        SheetMedium look{{}, {}, volume.medium.phase, volume.medium.octaves, litOrAll(volume)};
        const Rgb albedo = (grid ? Rgb(1) : volume.medium.albedo) * volume.medium.relativeTint();
        for (int c = 0; c < 3; ++c) look.albedo[c] = static_cast<float>(albedo[c]);
        m_media.push_back({i, grid, look});
    }
    m_alone = m_media.size() == 1 && m_surfaces.empty() && plan.extinction.count() == 1;
}

// Fills the rows of all media; read(planes, to) reads one row of one of them.
template <class Read>
void SheetShader::gather(const Read& read, Rows& rows) const {
    // Where there are surfaces `classify` adds up what is there.
    if (m_surfaces.empty())
        for (int r = 0; r < m_plan.extinction.count(); ++r) read(m_fields.extinction(r), rows.total(r));
    for (std::size_t i = 0; i < m_media.size(); ++i) {
        const Medium& medium = m_media[i];
        if (medium.grid)
            for (int c = 0; c < 3; ++c) read(m_fields.scatter(medium.volume, c)->extinction(), rows.scatter(i, c));
        if (!m_surfaces.empty() || !(medium.grid || m_alone))
            read(m_fields.volume(medium.volume).extinction(), rows.medium(i));
    }
    for (int e = 0; e < m_fields.emissionCount(); ++e)
        read(m_fields.emission(e).extinction(), rows.emission(static_cast<std::size_t>(e)));
}

void SheetShader::lookUpShadows(int p, const SampleTile& samples, Rows& rows) const {
    const BatchLights::OnSheet& lights = m_lights.onSheet(p);
    for (std::size_t i = 0; i < lights.shadows.size(); ++i)
        if (lights.shadows[i]) lights.shadows[i]->lookUpPoints(p, samples.u, samples.v, rows.tauIn(i));
}

ShadeWork SheetShader::shadeTexels(int p, int sheet, int tx, int ty, float* out) const {
    SampleTile samples;
    texelSamples(m_group.sheets, m_eye.slopes(), sheet + 0.5, tx * kTileEdge, ty * kTileEdge, samples, m_plan.simd);
    m_eye.setDepth(sheet + 0.5, samples);
    // Surfaces are classified along eye rays, which no texel of a plane knows: there texels are points like any other.
    if (!m_surfaces.empty()) return shadePoints(p, samples, out);

    const BatchLights::OnSheet& lights = m_lights.onSheet(p);
    Rows rows(*this, lights.lights.size());
    gather([&](const PlaneStack& planes, float* to) { copyTile(planes, p, tx, ty, to); }, rows);
    for (std::size_t i = 0; i < lights.shadows.size(); ++i)
        if (lights.shadows[i]) lights.shadows[i]->lookUpTile(p, tx * kTileEdge, ty * kTileEdge, rows.tauIn(i));
    return shade(p, samples, rows, out);
}

ShadeWork SheetShader::shadePoints(int p, const SampleTile& samples, float* out) const {
    Rows rows(*this, m_lights.onSheet(p).lights.size());
    gather(
        [&](const PlaneStack& planes, float* to) {
            samplePoints({planes.plane(p), planes.width(), planes.height(), 0, 0, m_plan.simd}, samples.u, samples.v,
                         false, kTileSize, to);
        },
        rows);
    return shadeGathered(p, samples, samples, 0, 0, rows, out);
}

ShadeWork SheetShader::shadeCells(int p, const SampleTile& samples, int tx, int ty, float* out) const {
    Rows rows(*this, m_lights.onSheet(p).lights.size());
    gather([&](const PlaneStack& planes, float* to) { copyTile(planes, p, tx, ty, to); }, rows);
    if (m_surfaces.empty()) return shadeGathered(p, samples, samples, tx, ty, rows, out);
    // A cell is the same ray on every plane.
    SampleTile cells{};
    for (int k = 0; k < kTileSize; ++k) {
        cells.u[k] = static_cast<float>(tx * kTileEdge + k % kTileEdge);
        cells.v[k] = static_cast<float>(ty * kTileEdge + k / kTileEdge);
    }
    return shadeGathered(p, samples, cells, tx, ty, rows, out);
}

// The rest of both: `at`, tx and ty as `classify` wants them.
ShadeWork SheetShader::shadeGathered(int p, const SampleTile& samples, const SampleTile& at, int tx, int ty, Rows& rows,
                                     float* out) const {
    ShadeWork work;
    if (!m_surfaces.empty() && !classify(p, at, tx, ty, rows, work)) {
        std::fill(out, out + m_group.layout.floats() * kTileSize, 0.0f);
        return work;
    }
    lookUpShadows(p, samples, rows);
    work += shade(p, samples, rows, out);
    return work;
}

// Classifies all surfaces at positions `at` of the fields' raster (of which (tx, ty) is the tile, where it is the eye's
// own), and lets the total extinction be what they and the media have there: what the sheets hold of classified volumes
// is classified at texels, which serves lights. False where nothing is to be seen.
bool SheetShader::classify(int p, const SampleTile& at, int tx, int ty, Rows& rows, ShadeWork& work) const {
    for (int r = 0; r < m_plan.extinction.count(); ++r) std::fill(rows.total(r), rows.total(r) + kTileSize, 0.0f);
    const auto add = [&](int volume, const float* extinction) {
        for (const auto& share : m_plan.extinction.shares[static_cast<std::size_t>(m_fields.sceneVolume(volume))]) {
            float* total = rows.total(share.row);
            for (int k = 0; k < kTileSize; ++k) total[k] += share.weight * extinction[k];
        }
    };
    for (std::size_t i = 0; i < m_media.size(); ++i) add(m_media[i].volume, rows.medium(i));
    for (std::size_t i = 0; i < m_surfaces.size(); ++i) {
        const VolumePlanes& volume = m_fields.volume(m_surfaces[i].volume);
        const ValuePlanes planes = volume.values(p);
        ClassifiedTile& tile = rows.scratch.classified[i];
        if (!classifyExtinction(planes, at, m_group.sheets, volume.table(), tile)) continue;
        classifySurface(planes, at, volume.step(p, tx, ty), volume.vagueGradient(), volume.table(), tile);
        work.gradients += kTileSize;
        add(m_surfaces[i].volume, tile.extinction);
        SheetSurface surface = m_surfaces[i].look;
        surface.extinction = tile.extinction;
        for (int c = 0; c < 3; ++c) {
            surface.emission[c] = tile.emission[c];
            surface.normal[c] = tile.normal[c];
        }
        surface.weight = tile.weight;
        rows.scratch.surfaces.push_back(surface);
    }
    const auto shows = [](float value) { return value > 0; };
    for (int r = 0; r < m_plan.extinction.count(); ++r)
        if (std::any_of(rows.total(r), rows.total(r) + kTileSize, shows)) return true;
    for (int e = 0; e < m_fields.emissionCount(); ++e) {
        const float* emission = rows.emission(static_cast<std::size_t>(e));
        if (std::any_of(emission, emission + kTileSize, shows)) return true;
    }
    return false;
}

ShadeWork SheetShader::shade(int p, const SampleTile& samples, Rows& rows, float* out) const {
    const BatchLights::OnSheet& lights = m_lights.onSheet(p);
    Scratch& scratch = rows.scratch;
    scratch.media.clear();
    for (std::size_t i = 0; i < m_media.size(); ++i) {
        SheetMedium& medium = scratch.media.emplace_back(m_media[i].look);
        for (int c = 0; c < 3; ++c)
            medium.scatter[c] = m_media[i].grid ? rows.scatter(i, c) : m_alone ? rows.total(0) : rows.medium(i);
    }
    scratch.emissions.clear();
    for (int e = 0; e < m_fields.emissionCount() && m_emitting > 0; ++e) {
        SheetEmission& emission = scratch.emissions.emplace_back();
        emission.coefficient = rows.emission(static_cast<std::size_t>(e));
        for (int c = 0; c < 3; ++c) emission.color[c] = m_emitting * static_cast<float>(m_fields.emissionColor(e)[c]);
    }
    ShadeInput input{};
    input.samples = &samples;
    input.texel = static_cast<float>(m_group.sheets.texel);
    input.thickness = static_cast<float>(m_group.sheets.thickness);
    input.sameSide = m_group.sameSide;
    input.coloured = m_plan.extinction.coloured;
    input.rows = m_plan.extinction.count();
    for (int r = 0; r < input.rows; ++r) {
        input.extinction[r] = rows.total(r);
        for (int c = 0; c < 3; ++c)
            input.tints[r][c] = static_cast<float>(m_plan.extinction.tints[static_cast<std::size_t>(r)][c]);
    }
    input.media = scratch.media.data();
    input.mediumCount = static_cast<int>(scratch.media.size());
    input.surfaces = scratch.surfaces.data();
    input.surfaceCount = static_cast<int>(scratch.surfaces.size());
    input.emissions = scratch.emissions.data();
    input.emissionCount = static_cast<int>(scratch.emissions.size());
    input.lights = lights.lights.data();
    input.lightCount = static_cast<int>(lights.lights.size());
    input.tauIn = rows.tauIn(0);
    std::copy(m_ambient, m_ambient + 3, input.ambient);
    input.layout = m_group.layout;
    input.targets = m_group.targets;
    input.pictures = rows.pictures();
    input.simd = m_plan.simd;
    return shadeTile(input, out);
}

}  // namespace scrim
