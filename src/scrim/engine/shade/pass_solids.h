// SPDX-License-Identifier: Apache-2.0
// What solids let through of each light of a sheet.
#pragma once

#include <scrim/engine/light/light_sweep.h>
#include <scrim/engine/shade/sheet_shader.h>
#include <scrim/geometry/sheets.h>

#include <vector>

namespace scrim {

/// Writes the fraction of each light that passes the solids to the paths of 256 samples:
/// `unblocked` has a row for each light of `lights`, which has solids. Where a light differs along
/// a path, that is the fraction of what it sends there.
void passSolids(const LightSweep::OnSheet& lights, const Sheets& sheets, const SampleTile& samples,
                std::vector<SheetShader::GivenRows::Row>& unblocked);

}  // namespace scrim
