// SPDX-License-Identifier: Apache-2.0
// The colour spaces that Scrim knows by more than one name. Configs of different years call the same space differently
// ("lin_rec709", "Utility - Linear - Rec.709", ...); this table maps those names to the one identifier of the ASWF
// Color Interop Forum. It is pure data, independent of OpenColorIO.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace scrim {

/// CIE x and y of red, green, blue and white, in this order.
using Chromaticities = std::array<float, 8>;

struct KnownSpace {
    std::string_view interopId;           ///< "lin_ap1_scene": the value of colorInteropID in files
    std::vector<std::string_view> names;  ///< names and aliases in published configs, the preferred one first
    /// Of linear spaces of three primaries. None for others: EXR's attribute says nothing of curves.
    std::optional<Chromaticities> chromaticities = {};
};

/// The known space called `name` (its interop id included; letter case does not matter), or null.
const KnownSpace* findKnownSpace(std::string_view name);

}  // namespace scrim
