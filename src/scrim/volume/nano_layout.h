// SPDX-License-Identifier: Apache-2.0
// The outer structure of a NanoVDB file (.nvdb): segments, each of a header, the descriptions of its grids, and the
// grids, which may be compressed (nanovdb/util/IO.h). It is checked before a byte of a grid is read, and becomes the
// same VdbLayout as that of an OpenVDB file, so that grids are chosen alike.
#pragma once

#include <scrim/volume/vdb_layout.h>

namespace scrim {

/// True where the file begins as a NanoVDB file.
bool isNanoVdb(const VdbBytes& bytes);

/// `bytes` must begin as such a file. Grids of types that are read get the type of the OpenVDB grid
/// that is made of them, others "NanoVDB NAME". Throws Error(input) "path: truncated or damaged:
/// ...", or where the file's version is not read.
VdbLayout checkNanoLayout(const VdbBytes& bytes);

}  // namespace scrim
