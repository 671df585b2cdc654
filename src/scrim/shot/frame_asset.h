// SPDX-License-Identifier: Apache-2.0
// From an asset, a volume file or a scan, to the text of a scene that shows it.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/geometry/spaces.h>
#include <scrim/shot/field_store.h>

#include <optional>
#include <string>

namespace scrim {

/// Whether the file is framed and lit by itself: .vdb, or a scan.
bool isAssetFile(const std::string& path);

struct AssetOptions {
    Int2 resolution{512, 512};
    std::optional<Vec3> wsUp;  ///< a unit vector along an axis; none: guessed
};

/// The scene but for its numbers. `pattern`: the asset's path as a scene names it.
std::string unframedText(const std::string& pattern, const AssetOptions& options);

/// The scene. Loads into `store` what it shows; says which way is up where that was guessed, and which grids are not
/// shown. `path`: for messages. Throws Error.
std::string framedText(FieldStore& store, const std::string& path, const std::string& pattern,
                       const AssetOptions& options, const MessageSink& messages);

/// What a volume of that file is called: "smoke" for "caches/smoke.####.vdb", of letters, digits, '_' and '-'.
std::string volumeNameOf(const std::string& pattern);

}  // namespace scrim
