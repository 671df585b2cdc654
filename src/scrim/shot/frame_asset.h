// SPDX-License-Identifier: Apache-2.0
// Makes the text of a scene that shows an asset: a volume file or a scan.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/geometry/spaces.h>
#include <scrim/shot/field_store.h>

#include <optional>
#include <string>

namespace scrim {

/// True for files that are framed and lit automatically: .vdb and scans.
bool isAssetFile(const std::string& path);

struct AssetOptions {
    Int2 resolution{512, 512};
    std::optional<Vec3> wsUp;  ///< a unit vector along an axis; none: guessed
    std::string window = {};   ///< the window that overrides give a scan (scanLook); "": none
};

/// The scene's text before the asset is read, without the numbers that depend on it. `pattern`: the
/// asset's path as a scene names it.
std::string unframedText(const std::string& pattern, const AssetOptions& options);

/// The scene's text. Loads the fields it shows into `store`; reports which way is up where that was
/// guessed, and which grids are not shown. `path`: for messages. Throws Error.
std::string framedText(FieldStore& store, const std::string& path, const std::string& pattern,
                       const AssetOptions& options, const MessageSink& messages);

/// The name of a volume of that file: "smoke" for "caches/smoke.####.vdb". It consists of letters, digits, '_' and '-'.
std::string volumeNameOf(const std::string& pattern);

}  // namespace scrim
