// SPDX-License-Identifier: Apache-2.0
// Internal: transfers a picture that another process read (transfer_file.h).
#pragma once

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

}  // namespace scrim
