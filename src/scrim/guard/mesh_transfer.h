// SPDX-License-Identifier: Apache-2.0
// Internal: hands over a mesh that another process read (transfer_file.h).
#pragma once

#include <scrim/solid/mesh_module.h>

namespace scrim {

/// Throws as TransferWriter.
void sendMesh(int fd, const FileMesh& mesh);
/// The mesh, or the empty one that says why. Every triangle names points that there are, and these are finite. Throws
/// as `receiveFields` (field_transfer.h).
FileMesh receiveMesh(int fd);

}  // namespace scrim
