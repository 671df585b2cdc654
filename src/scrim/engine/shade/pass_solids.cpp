// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/shade/pass_solids.h>

#include <scrim/engine/light/solid_shadow.h>
#include <scrim/engine/shade/lamp_on_path.h>

#include <algorithm>
#include <cstddef>

namespace scrim {
namespace {

// Where solids block a part of a path along which a light differs, it is what the light sends there that counts.
void passBeam(const SheetLight& light, const SolidShadow& solids, int sheet, const Sheets& sheets,
              const SampleTile& samples, Real* unblocked) {
    if (!light.near()) return;
    bool wanted[kTileSize];
    for (int k = 0; k < kTileSize; ++k) wanted[k] = unblocked[k] > 0 && unblocked[k] < 1;
    const LampOnPath lamp(*light.near(), static_cast<Real>(sheets.texel), static_cast<Real>(sheets.thickness));
    alignas(64) Real tint[3 * kTileSize];
    alignas(64) Real means[2 * kTileSize];  // of the light, as the slide leaves it, with and without solids
    const auto meets = [&](const SampleTile& part, Real* values) {
        std::fill_n(values, 2 * kTileSize, Real(1));
        if (light.slide.image) {
            if (!tintTile(light.slide, part, static_cast<Real>(sheets.thickness / sheets.texel), tint))
                std::fill_n(tint, 3 * kTileSize, Real(0));
            for (int k = 0; k < kTileSize; ++k)
                values[k] = values[kTileSize + k] = tint[k] + tint[kTileSize + k] + tint[2 * kTileSize + k];
        }
        solids.multiply(sheet, part, values);
    };
    if (!lamp.average(samples, wanted, 2, meets, means)) return;
    for (int k = 0; k < kTileSize; ++k)
        if (means[kTileSize + k] > 0) unblocked[k] = means[k] / means[kTileSize + k];
}

}  // namespace

void passSolids(const LightSweep::OnSheet& lights, const Sheets& sheets, const SampleTile& samples,
                std::vector<SheetShader::GivenRows::Row>& unblocked) {
    for (std::size_t i = 0; i < lights.solids.size(); ++i) {
        std::fill_n(unblocked[i].values, kTileSize, Real(1));
        if (!lights.solids[i]) continue;
        lights.solids[i]->multiply(lights.sheet, samples, unblocked[i].values);
        passBeam(lights.lights[i], *lights.solids[i], lights.sheet, sheets, samples, unblocked[i].values);
    }
}

}  // namespace scrim
