// SPDX-License-Identifier: Apache-2.0
// The contents of a scan (NRRD, NIfTI, DICOM, TIFF) and estimates of where its materials begin. This is plain data,
// made from what the volume source `scan` returns for a file with its parameter `describe`.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/geometry/spaces.h>
#include <scrim/guard/load_options.h>

#include <cstdint>
#include <string>
#include <vector>

namespace scrim {

struct ScanInfo {
    std::string path;
    std::uint64_t fileBytes = 0;
    std::string sampleType;  ///< "uint8", "int16", "float", "RGB of uint8", ...
    std::string space;       ///< directions of x, y and z: "right-anterior-superior"; "": the file does not say
    std::string unit;        ///< of the world, as the file has it: "micron"; "": not stated, or its format's own
    bool isSpaced = true;    ///< the file says how far samples are apart
    Int3 size{1};            ///< number of samples along each axis
    Mat4 wsFromIs{1.0};
    double minValue = 0, maxValue = 0;  ///< over the finite samples
    double binWidth = 1;
    /// Counts of samples by value, from the least to the largest; the first bin is centred on the least value.
    std::vector<double> counts;

    double valueOf(std::size_t bin) const { return minValue + double(bin) * binWidth; }
};

/// True for names that end in .nrrd, .nhdr, .nii, .nii.gz, .hdr, .mha, .mhd, .npy, .mrc, .vti, .ccp4, .dcm, .dicom,
/// .tif or .tiff, and for folders, which may hold a series, unless they are named like another file (.vdb, .nvdb).
bool isScanFile(const std::string& path);

/// Reads the whole file. Throws Error as `sourceFields` (load_fields.h).
ScanInfo loadScanInfo(const std::string& path, const LoadOptions& options, const Checkpoint& checkpoint = {});

/// The values at which materials begin, in the scan's units.
struct ScanMaterials {
    double soft = 0;          ///< what rises above the surroundings: tissue, leaves
    double solid = 0;         ///< what rises above that: bone, wood
    bool hounsfield = false;  ///< the thresholds come from the units, not from the histogram
};

/// For a scan in Hounsfield units (air lies below -500), the thresholds of tissue and bone. For
/// others, the two thresholds that best divide the histogram into three classes (Otsu 1979,
/// equation 23), as far as it has enough values.
ScanMaterials materialsOf(const ScanInfo& info);

/// The histogram as `columns` columns of bars, `rows` lines high, with logarithmic heights; no line break at the end.
std::string histogramText(const ScanInfo& info, int columns, int rows);

/// `info` as one JSON object, with its materials.
std::string toJson(const ScanInfo& info);

}  // namespace scrim
