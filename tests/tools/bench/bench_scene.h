// SPDX-License-Identifier: Apache-2.0
// The scenes that benchmarks measure: one volume, framed as `scrim render ASSET` frames it, under one light.
#pragma once

#include <scrim/scene/view_scene.h>

#include <string>

namespace scrim::bench {

/// `asset`: a .vdb file, or "noise:RESOLUTION" for procedural smoke. 512 x 512 unless said otherwise; one shadowed
/// distant light, no ambient light, isotropic scattering.
ViewScene benchScene(const std::string& asset, Int2 resolution = {512, 512});

/// The asset's name in tables.
std::string assetLabel(const std::string& asset);

/// Adds lights until there are `count`, all near the first one, so that one sweep serves them.
void addLights(ViewScene& scene, int count);

}  // namespace scrim::bench
