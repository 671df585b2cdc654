// SPDX-License-Identifier: Apache-2.0
// Internal: transfers a mesh that another process read (transfer_file.h).
#pragma once

#include <scrim/solid/mesh_module.h>

namespace scrim {

/// Throws as TransferWriter.
void sendMesh(int fd, const FileMesh& mesh);
/// The mesh, or an empty one whose `problem` says why. Every triangle refers to existing points,
/// and all points are finite. Throws as `receiveFields` (field_transfer.h).
FileMesh receiveMesh(int fd);

}  // namespace scrim
