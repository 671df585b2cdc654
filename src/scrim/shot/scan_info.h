// SPDX-License-Identifier: Apache-2.0
// What a scan (NRRD, NIfTI) holds, and where its materials seem to begin. Plain data, made of what the volume source
// `scan` says of a file with its parameter `describe`.
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
    std::string sampleType;  ///< "uint8", "int16", "float", ...
    std::string space;       ///< where x, y and z lead: "right-anterior-superior"; "": the file does not say
    Int3 size{1};            ///< samples
    Mat4 wsFromIs{1.0};
    double minValue = 0, maxValue = 0;  ///< of the finite samples
    double binWidth = 1;
    std::vector<double>
        counts;  ///< of samples by value, from the least to the largest; the first bin's middle is there

    double valueOf(std::size_t bin) const { return minValue + double(bin) * binWidth; }
};

/// By the ending of the name: .nrrd, .nhdr, .nii, .nii.gz.
bool isScanFile(const std::string& path);

/// Reads the whole file. Throws Error as `sourceFields` (load_fields.h).
ScanInfo loadScanInfo(const std::string& path, const LoadOptions& options, const Checkpoint& checkpoint = {});

/// Where materials begin, in the scan's values.
struct ScanMaterials {
    double soft = 0;          ///< above the surroundings: tissue, leaves
    double solid = 0;         ///< above that: bone, wood
    bool hounsfield = false;  ///< known by its units, not by its histogram
};

/// Of a scan in Hounsfield units (air lies below -500) those of tissue and bone; of others the two thresholds that
/// part the histogram best into three (Otsu 1979, equation 23), as far as it has values for that.
ScanMaterials materialsOf(const ScanInfo& info);

/// The histogram in so many columns of bars, `rows` lines high, heights by the logarithm of the count; no line break
/// at the end.
std::string histogramText(const ScanInfo& info, int columns, int rows);

/// `info` as one JSON object, with its materials.
std::string toJson(const ScanInfo& info);

}  // namespace scrim
