// SPDX-License-Identifier: Apache-2.0
// The text that `scrim info` prints about a file, a sequence or a scan.
#pragma once

#include <scrim/shot/scan_info.h>
#include <scrim/volume/vdb_info.h>

#include <string>
#include <vector>

namespace scrim::cli {

std::string infoText(const VdbFileInfo& info);
std::string infoText(const ScanInfo& info);

/// The contents of the grids of a sequence in all frames together. `frames` holds the frame of each file.
std::string sequenceText(const std::string& pattern, const std::vector<int>& frames,
                         const std::vector<VdbFileInfo>& files);

}  // namespace scrim::cli
