// SPDX-License-Identifier: Apache-2.0
// What layers are called, in scenes and in files.
#pragma once

#include <scrim/scene/scene.h>

#include <string>
#include <vector>

namespace scrim {

/// In the order of Layer.
inline const std::vector<std::string>& layerNames() {
    static const std::vector<std::string> names{"light", "ambient", "emission", "albedo", "depth", "transmittance"};
    return names;
}
inline const std::string& nameOf(Layer layer) {
    return layerNames()[std::size_t(layer)];
}

}  // namespace scrim
