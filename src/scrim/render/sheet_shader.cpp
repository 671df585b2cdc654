// SPDX-License-Identifier: Apache-2.0
#include <scrim/render/sheet_shader.h>

#include <scrim/light/plane_sampling.h>

#include <algorithm>
#include <cstring>

namespace scrim {
namespace {

// Rows of 256 floats, aligned for vectors and kept by each thread, so that shading a tile allocates nothing.
class Scratch {
  public:
    float* rows(std::size_t count) {
        if (m_rows.size() < count) m_rows.resize(count);
        return m_rows.data()->values;
    }

    SheetMedium* media(const std::vector<SheetMedium>& values) {
        m_media.assign(values.begin(), values.end());
        return m_media.data();
    }

  private:
    struct alignas(64) Row {
        float values[kTileSize];
    };
    std::vector<Row> m_rows;
    std::vector<SheetMedium> m_media;
};

Scratch& threadScratch() {
    thread_local Scratch scratch;
    return scratch;
}

}  // namespace

SheetShader::SheetShader(const ViewScene& scene, const GroupPlan& group, const BatchFields& fields,
                         const BatchLights& lights, const EyeView& eye)
    : m_group(group), m_fields(fields), m_lights(lights), m_eye(eye) {
    for (int c = 0; c < 3; ++c) m_ambient[c] = group.primary ? static_cast<float>(scene.ambient[c]) : 0.0f;
    for (int i = 0; i < fields.volumeCount(); ++i) {
        const Medium& medium = fields.medium(i);
        SheetMedium part{nullptr, {}, static_cast<float>(medium.phase.g)};
        for (int c = 0; c < 3; ++c) part.albedo[c] = static_cast<float>(medium.albedo[c]);
        m_media.push_back(part);
    }
}

void SheetShader::shadeTexels(int p, int sheet, int tx, int ty, float* out) const {
    const BatchLights::OnSheet& lights = m_lights.onSheet(p);
    const int volumes = m_fields.volumeCount();
    float* rows = threadScratch().rows(static_cast<std::size_t>(volumes + 1) + lights.lights.size());

    // Extinction: the total first, then each volume's own (which is the total where there is one).
    const auto copyTile = [&](const PlaneStack& planes, float* to) {
        const float* from =
            planes.plane(p) + static_cast<std::ptrdiff_t>(ty * kTileEdge) * planes.rowStride() + tx * kTileEdge;
        for (int y = 0; y < kTileEdge; ++y, from += planes.rowStride())
            std::memcpy(to + y * kTileEdge, from, kTileEdge * sizeof(float));
    };
    copyTile(m_fields.extinction(), rows);
    if (volumes > 1)
        for (int i = 0; i < volumes; ++i) copyTile(m_fields.volume(i), rows + (i + 1) * kTileSize);

    float* tauIn = rows + (volumes + 1) * kTileSize;
    for (std::size_t i = 0; i < lights.lights.size(); ++i)
        if (lights.shadows[i]) lights.shadows[i]->lookUpTile(p, tx * kTileEdge, ty * kTileEdge, tauIn + i * kTileSize);

    SampleTile samples;
    texelSamples(m_group.sheets, m_eye.slopes(), sheet + 0.5, tx * kTileEdge, ty * kTileEdge, samples);
    shade(p, samples, rows, tauIn, out);
}

void SheetShader::shadePoints(int p, const SampleTile& samples, float* out) const {
    const BatchLights::OnSheet& lights = m_lights.onSheet(p);
    const int volumes = m_fields.volumeCount();
    float* rows = threadScratch().rows(static_cast<std::size_t>(volumes + 1) + lights.lights.size());

    const auto sample = [&](const PlaneStack& planes, float* to) {
        samplePoints({planes.plane(p), planes.width(), planes.height()}, samples.u, samples.v, false, kTileSize, to);
    };
    sample(m_fields.extinction(), rows);
    if (volumes > 1)
        for (int i = 0; i < volumes; ++i) sample(m_fields.volume(i), rows + (i + 1) * kTileSize);

    float* tauIn = rows + (volumes + 1) * kTileSize;
    for (std::size_t i = 0; i < lights.lights.size(); ++i)
        if (lights.shadows[i]) lights.shadows[i]->lookUpPoints(p, samples.u, samples.v, tauIn + i * kTileSize);
    shade(p, samples, rows, tauIn, out);
}

void SheetShader::shade(int p, const SampleTile& samples, const float* extinctions, const float* tauIn,
                        float* out) const {
    const BatchLights::OnSheet& lights = m_lights.onSheet(p);
    const int volumes = m_fields.volumeCount();
    SheetMedium* media = threadScratch().media(m_media);
    for (int i = 0; i < volumes; ++i) media[i].extinction = extinctions + (volumes > 1 ? (i + 1) * kTileSize : 0);
    ShadeInput input{};
    input.samples = &samples;
    input.texel = static_cast<float>(m_group.sheets.texel);
    input.thickness = static_cast<float>(m_group.sheets.thickness);
    input.sameSide = m_group.sameSide;
    input.extinction = extinctions;
    input.media = media;
    input.mediumCount = volumes;
    input.lights = lights.lights.data();
    input.lightCount = static_cast<int>(lights.lights.size());
    input.tauIn = tauIn;
    std::copy(m_ambient, m_ambient + 3, input.ambient);
    shadeTile(input, out);
}

}  // namespace scrim
