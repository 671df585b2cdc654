// SPDX-License-Identifier: Apache-2.0
// The look of a scan that comes without a scene.
#pragma once

#include <scrim/shot/scan_info.h>
#include <scrim/volume/source_parameters.h>

#include <string>

namespace scrim {

/// Parameters of the source `scan` for a file, and the materials that are made visible.
struct ScanLook {
    SourceParameters parameters;  ///< all parameters but `file`
    std::string classified;       ///< the text of the table [volume.classified]
};

/// Shows tissue as a faint veil with bone as a surface in it, or whatever materials lie at their thresholds
/// (materialsOf).
ScanLook scanLook(const ScanInfo& info);

/// The text of a volume called `name` that shows the scan `file` (a path as a scene names it) with the look `look`.
std::string scanVolumeText(const std::string& name, const std::string& file, const ScanLook& look);

/// The right, up and back directions of a viewer in front of the patient, as columns. Where the file does not give the
/// patient's position, up is z, the direction in which slices are stacked.
Mat3 uprightOf(const ScanInfo& info);

}  // namespace scrim
