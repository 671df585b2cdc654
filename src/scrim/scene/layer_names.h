// SPDX-License-Identifier: Apache-2.0
// The names of layers in scenes and in files.
#pragma once

#include <scrim/scene/scene.h>

#include <string>
#include <vector>

namespace scrim {

/// The names, in the order of Layer.
inline const std::vector<std::string>& layerNames() {
    static const std::vector<std::string> names{"light",  "direct",      "indirect",      "ambient", "emission",
                                                "albedo", "depth",       "transmittance", "shadow",  "volume",
                                                "motion", "cryptomatte", "backdrop"};
    return names;
}
inline const std::string& nameOf(Layer layer) {
    return layerNames()[std::size_t(layer)];
}

/// A light's name as part of a channel's name. Characters that are neither letters, digits nor
/// underscores become underscores, since compositing programs refuse or mangle all others.
inline std::string channelName(std::string name) {
    for (char& c : name) {
        const bool plain = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
        if (!plain) c = '_';
    }
    return name;
}

}  // namespace scrim
