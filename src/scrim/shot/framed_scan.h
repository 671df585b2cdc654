// SPDX-License-Identifier: Apache-2.0
// How a scan without a scene is shown.
#pragma once

#include <scrim/shot/scan_info.h>
#include <scrim/volume/source_parameters.h>

#include <string>

namespace scrim {

/// What the source `scan` makes of the file, and the materials that are seen in it.
struct ScanLook {
    SourceParameters parameters;  ///< without `file`
    std::string classified;       ///< the text of the volume's table [volume.classified]
};

/// Tissue as a faint veil and bone as a surface in it, or whatever else lies at their thresholds (materialsOf).
ScanLook scanLook(const ScanInfo& info);

/// The text of a volume that is called `name` and shows the file `file`, as a scene names it, so.
std::string scanVolumeText(const std::string& name, const std::string& file, const ScanLook& look);

/// Columns: right, up and back of somebody who stands before the patient, where the file says how it lies; z up, as
/// slices are stacked, where it does not.
Mat3 uprightOf(const ScanInfo& info);

}  // namespace scrim
