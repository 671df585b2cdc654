// SPDX-License-Identifier: Apache-2.0
#include <scrim/render/sheet_shader.h>

#include <scrim/light/plane_sampling.h>

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
};

Scratch& threadScratch() {
    thread_local Scratch scratch;
    return scratch;
}

}  // namespace

// What is known of a tile's samples: rows of 256 floats.
struct SheetShader::Gathered {
    Gathered(std::size_t media, std::size_t surfaces, std::size_t lights) : scratch(threadScratch()) {
        const std::size_t count = 1 + media + std::max<std::size_t>(lights, 1);  // tauIn(0) is there in any case
        if (scratch.rows.size() < count) scratch.rows.resize(count);
        if (scratch.classified.size() < surfaces) scratch.classified.resize(surfaces);
        scratch.surfaces.clear();
        total = scratch.rows[0].values;
        m_tauIn = 1 + media;
    }
    float* medium(std::size_t i) const { return scratch.rows[1 + i].values; }
    float* tauIn(std::size_t light) const { return scratch.rows[m_tauIn + light].values; }

    Scratch& scratch;
    float* total;  // extinction of all volumes

  private:
    std::size_t m_tauIn;
};

SheetShader::SheetShader(const ViewScene& scene, const GroupPlan& group, const BatchFields& fields,
                         const BatchLights& lights, const EyeView& eye)
    : m_group(group), m_fields(fields), m_lights(lights), m_eye(eye) {
    for (int c = 0; c < 3; ++c) m_ambient[c] = static_cast<float>(group.primary * scene.ambient[c]);
    for (int i = 0; i < fields.volumeCount(); ++i) {
        const ViewVolume& volume = fields.volume(i).volume();
        if (const Classified* c = volume.classified.get()) {
            SheetSurface part{};
            part.ambient = static_cast<float>(c->ambient);
            part.diffuse = static_cast<float>(c->diffuse);
            part.specular = static_cast<float>(c->specular);
            part.exponent = static_cast<float>(c->exponent);
            part.twoSided = c->twoSided;
            m_surfaceVolumes.push_back(i);
            m_surfaces.push_back(part);
            continue;
        }
        SheetMedium part{nullptr, {}, static_cast<float>(volume.medium.phase.g)};
        for (int c = 0; c < 3; ++c) part.albedo[c] = static_cast<float>(volume.medium.albedo[c]);
        m_mediumVolumes.push_back(i);
        m_media.push_back(part);
    }
}

void SheetShader::copyTile(const PlaneStack& planes, int p, int tx, int ty, float* to) const {
    const float* from =
        planes.plane(p) + static_cast<std::ptrdiff_t>(ty * kTileEdge) * planes.rowStride() + tx * kTileEdge;
    for (int y = 0; y < kTileEdge; ++y, from += planes.rowStride())
        std::memcpy(to + y * kTileEdge, from, kTileEdge * sizeof(float));
}

void SheetShader::lookUpShadows(int p, const SampleTile& samples, Gathered& rows) const {
    const BatchLights::OnSheet& lights = m_lights.onSheet(p);
    for (std::size_t i = 0; i < lights.lights.size(); ++i)
        if (lights.shadows[i]) lights.shadows[i]->lookUpPoints(p, samples.u, samples.v, rows.tauIn(i));
}

void SheetShader::shadeTexels(int p, int sheet, int tx, int ty, float* out) const {
    SampleTile samples;
    texelSamples(m_group.sheets, m_eye.slopes(), sheet + 0.5, tx * kTileEdge, ty * kTileEdge, samples);
    // Surfaces are classified along eye rays, which no texel of a plane knows: there texels are points like any other.
    if (!m_surfaces.empty()) return shadePoints(p, samples, out);

    const BatchLights::OnSheet& lights = m_lights.onSheet(p);
    Gathered rows(m_media.size(), 0, lights.lights.size());
    copyTile(m_fields.extinction(), p, tx, ty, rows.total);
    if (m_media.size() > 1)
        for (std::size_t i = 0; i < m_media.size(); ++i)
            copyTile(m_fields.volume(m_mediumVolumes[i]).extinction(), p, tx, ty, rows.medium(i));
    for (std::size_t i = 0; i < lights.lights.size(); ++i)
        if (lights.shadows[i]) lights.shadows[i]->lookUpTile(p, tx * kTileEdge, ty * kTileEdge, rows.tauIn(i));
    shade(p, samples, rows, out);
}

void SheetShader::shadePoints(int p, const SampleTile& samples, float* out) const {
    Gathered rows(m_media.size(), m_surfaces.size(), m_lights.onSheet(p).lights.size());
    const auto sample = [&](const PlaneStack& planes, float* to) {
        samplePoints({planes.plane(p), planes.width(), planes.height()}, samples.u, samples.v, false, kTileSize, to);
    };
    if (m_media.size() > 1 || !m_surfaces.empty())
        for (std::size_t i = 0; i < m_media.size(); ++i)
            sample(m_fields.volume(m_mediumVolumes[i]).extinction(), rows.medium(i));
    if (m_surfaces.empty()) {
        sample(m_fields.extinction(), rows.total);
    } else if (!classify(p, samples, 0, 0, rows)) {
        std::fill(out, out + 4 * kTileSize, 0.0f);
        return;
    }
    lookUpShadows(p, samples, rows);
    shade(p, samples, rows, out);
}

void SheetShader::shadeCells(int p, const SampleTile& samples, int tx, int ty, float* out) const {
    Gathered rows(m_media.size(), m_surfaces.size(), m_lights.onSheet(p).lights.size());
    if (m_media.size() > 1 || !m_surfaces.empty())
        for (std::size_t i = 0; i < m_media.size(); ++i)
            copyTile(m_fields.volume(m_mediumVolumes[i]).extinction(), p, tx, ty, rows.medium(i));
    if (m_surfaces.empty()) {
        copyTile(m_fields.extinction(), p, tx, ty, rows.total);
    } else {
        // A cell is the same ray on every plane.
        SampleTile cells{};
        for (int k = 0; k < kTileSize; ++k) {
            cells.u[k] = static_cast<float>(tx * kTileEdge + k % kTileEdge);
            cells.v[k] = static_cast<float>(ty * kTileEdge + k / kTileEdge);
        }
        if (!classify(p, cells, tx, ty, rows)) {
            std::fill(out, out + 4 * kTileSize, 0.0f);
            return;
        }
    }
    lookUpShadows(p, samples, rows);
    shade(p, samples, rows, out);
}

// Classifies all surfaces at positions `at` of the fields' raster (of which (tx, ty) is the tile, where it is the eye's
// own), and lets the total extinction be what they and the media have there: what
// the sheets hold of classified volumes is classified at texels, which serves lights. False where nothing is to be
// seen.
bool SheetShader::classify(int p, const SampleTile& at, int tx, int ty, Gathered& rows) const {
    std::fill(rows.total, rows.total + kTileSize, 0.0f);
    const auto add = [&](const float* extinction) {
        for (int k = 0; k < kTileSize; ++k) rows.total[k] += extinction[k];
    };
    for (std::size_t i = 0; i < m_media.size(); ++i) add(rows.medium(i));
    for (std::size_t i = 0; i < m_surfaces.size(); ++i) {
        const VolumePlanes& volume = m_fields.volume(m_surfaceVolumes[i]);
        const ValuePlanes planes = volume.values(p);
        ClassifiedTile& tile = rows.scratch.classified[i];
        if (!classifyExtinction(planes, at, m_group.sheets, volume.table(), tile)) continue;
        classifySurface(planes, at, volume.step(p, tx, ty), volume.vagueGradient(), volume.table(), tile);
        add(tile.extinction);
        SheetSurface surface = m_surfaces[i];
        surface.extinction = tile.extinction;
        for (int c = 0; c < 3; ++c) {
            surface.emission[c] = tile.emission[c];
            surface.normal[c] = tile.normal[c];
        }
        surface.weight = tile.weight;
        rows.scratch.surfaces.push_back(surface);
    }
    return std::any_of(rows.total, rows.total + kTileSize, [](float sigma) { return sigma > 0; });
}

void SheetShader::shade(int p, const SampleTile& samples, const Gathered& rows, float* out) const {
    const BatchLights::OnSheet& lights = m_lights.onSheet(p);
    rows.scratch.media = m_media;
    // A medium that is alone has all the extinction there is.
    const bool alone = m_media.size() == 1 && m_surfaces.empty();
    for (std::size_t i = 0; i < m_media.size(); ++i)
        rows.scratch.media[i].extinction = alone ? rows.total : rows.medium(i);
    ShadeInput input{};
    input.samples = &samples;
    input.texel = static_cast<float>(m_group.sheets.texel);
    input.thickness = static_cast<float>(m_group.sheets.thickness);
    input.sameSide = m_group.sameSide;
    input.extinction = rows.total;
    input.media = rows.scratch.media.data();
    input.mediumCount = static_cast<int>(m_media.size());
    input.surfaces = rows.scratch.surfaces.data();
    input.surfaceCount = static_cast<int>(rows.scratch.surfaces.size());
    input.lights = lights.lights.data();
    input.lightCount = static_cast<int>(lights.lights.size());
    input.tauIn = rows.tauIn(0);
    std::copy(m_ambient, m_ambient + 3, input.ambient);
    shadeTile(input, out);
}

}  // namespace scrim
