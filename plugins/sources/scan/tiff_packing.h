// SPDX-License-Identifier: Apache-2.0
// How TIFF packs samples (TIFF 6.0, sections 9, 13 and 14; deflate and floats: Adobe's technical notes of 2002 and
// 2005): unpacks a strip or a tile. It is written out here because libtiff brings seven more libraries into the process
// that reads scans, one of them (libjbig) under the GPL.
#pragma once

#include "scan.h"

#include <cstdint>
#include <string>

namespace scan {

enum class TiffPacking : std::uint64_t { none = 1, lzw = 5, adobeDeflate = 8, packBits = 32773, deflate = 32946 };

/// The most bytes that one packed byte becomes; 0: this packing is not read.
std::int64_t mostRatioOf(TiffPacking packing);

/// "JPEG", or "method 12345".
std::string nameOf(TiffPacking packing);

/// The first `bytes` bytes of what `packed` unpacks to; fewer where it is damaged or cut off. `bytes` is at most what
/// the ratio allows, which the caller checks.
std::string unpacked(const std::string& packed, TiffPacking packing, std::int64_t bytes);

/// Rows of samples, and how they were turned into differences.
struct TiffRows {
    std::int64_t columns = 0;
    int parts = 1;  ///< of a sample that lie beside each other
    SampleType type = SampleType::uint8;
    bool bigEndian = false;
    std::uint64_t predictor = 1;  ///< 1: none, 2: differences of numbers, 3: of the bytes of floats
};

/// Brings whole rows into this machine's order of bytes, and makes samples of differences.
void undoDifferences(std::string& bytes, const TiffRows& rows);

}  // namespace scan
