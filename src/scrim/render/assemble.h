// SPDX-License-Identifier: Apache-2.0
// From a scene and the fields it names to what the engine renders.
#pragma once

#include <scrim/render/view_scene.h>
#include <scrim/scene/scene.h>

#include <memory>
#include <optional>
#include <vector>

namespace scrim {

/// `fields[i]` belongs to `scene.volumes[i]`, in its asset's own world space; null where the volume shows nothing
/// at this frame. `crop` limits the region to pixels of it (display window coordinates). Ramps are applied, and
/// coarser levels built where the dial `lod` asks for them.
ViewScene assemble(const Scene& scene, const std::vector<std::shared_ptr<const SparseField>>& fields,
                   const std::optional<PixelWindow>& crop, std::size_t memoryLimit);

}  // namespace scrim
