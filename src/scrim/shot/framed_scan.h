// SPDX-License-Identifier: Apache-2.0
// The look of a scan that comes without a scene.
#pragma once

#include <scrim/shot/scan_info.h>
#include <scrim/volume/source_parameters.h>
#include <scrim/volume/sparse_field.h>

#include <string>

namespace scrim {

/// Parameters of the source `scan` for a file, and the materials that are made visible.
struct ScanLook {
    SourceParameters parameters;  ///< all parameters but `file`
    std::string classified;       ///< the text of the table [volume.classified]
    float solid = 0;              ///< value of the field above which it is solid material: bone, wood
};

/// Shows tissue as a faint veil with bone as a surface in it, or whatever materials lie at their thresholds
/// (materialsOf). `window` is not empty where the caller gives [volume.classified] this window, as TOML or as a bare
/// word; the field then suits it. Throws Error(input) where the scan has no Hounsfield units and the window needs them.
ScanLook scanLook(const ScanInfo& info, const std::string& window = "");

/// The text of a volume called `name` that shows the scan `file` (a path as a scene names it) with the look `look`.
std::string scanVolumeText(const std::string& name, const std::string& file, const ScanLook& look);

/// Where a scan's upright position comes from.
enum class UpFrom {
    file,    ///< the file gives the patient's position
    weight,  ///< the scan has one heavy end, on which it stands
    slices,  ///< z, the direction in which slices are stacked
};

struct Upright {
    Mat3 wsFromUpright{1};  ///< right, up and back directions of a viewer in front of the patient, as columns
    UpFrom from = UpFrom::slices;
};

/// `field`: the scan's field, in which values of at least `solid` are its solid material (ScanLook).
Upright uprightOf(const ScanInfo& info, const SparseField& field, float solid);

}  // namespace scrim
