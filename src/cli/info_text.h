// SPDX-License-Identifier: Apache-2.0
// What `scrim info` prints of a file, a sequence, a scan.
#pragma once

#include <scrim/shot/scan_info.h>
#include <scrim/volume/vdb_info.h>

#include <string>
#include <vector>

namespace scrim::cli {

std::string infoText(const VdbFileInfo& info);
std::string infoText(const ScanInfo& info);

/// Of the files of a sequence: what its grids hold in all frames together. `frames` has the frame of each file.
std::string sequenceText(const std::string& pattern, const std::vector<int>& frames,
                         const std::vector<VdbFileInfo>& files);

}  // namespace scrim::cli
