// SPDX-License-Identifier: Apache-2.0
// Internal: transfers a picture or a photometric file that another process read (transfer_file.h).
#pragma once

#include <scrim/image/light_profile.h>
#include <scrim/image/picture_module.h>

namespace scrim {

/// Throws as TransferWriter.
void sendPicture(int fd, const FilePicture& picture);
/// The picture, or one without pixels whose `problem` says why. Throws as `receiveFields` (field_transfer.h).
FilePicture receivePicture(int fd);

/// The same for a header.
void sendPictureHeader(int fd, const PictureHeader& header);
PictureHeader receivePictureHeader(int fd);

/// The same for depths.
void sendPictureDepth(int fd, const FileDepth& depth);
FileDepth receivePictureDepth(int fd);

/// The same for a photometric file, whose angles ascend and whose candelas are finite, not negative, and not all 0.
void sendPhotometry(int fd, const FilePhotometry& file);
FilePhotometry receivePhotometry(int fd);

}  // namespace scrim
