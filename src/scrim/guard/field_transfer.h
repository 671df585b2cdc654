// SPDX-License-Identifier: Apache-2.0
// Hands the data that one process has read to another, so that an untrusted .vdb is parsed in a
// child that may crash, and parsed only once.
//
// The two share a file descriptor: a memfd, or any regular file (transfer_file.h). The receiver
// maps the file, and the blocks of its fields point into the mapping. It trusts nothing in it: the
// file that the sender read may have made it overwrite its own memory.
//
// A child that is forked without exec must be forked by a process without threads, because threads
// do not survive a fork and loops in the child would wait for them forever.
#pragma once

#include <scrim/base/error.h>
#include <scrim/base/messages.h>
#include <scrim/volume/grid_request.h>
#include <scrim/volume/sparse_field.h>
#include <scrim/guard/transfer_file.h>
#include <scrim/volume/vdb_info.h>

#include <string>
#include <utility>
#include <vector>

namespace scrim {

struct TransferMessage {
    Severity severity = Severity::info;
    std::string text;
};

struct ReceivedFields {
    std::vector<SparseField> fields;
    std::vector<TransferMessage> messages;
};

/// Each writes one thing as the whole contents of the transfer, from the file's start; `fd` stays open. They throw
/// Error(memory) where there is no space, Error(render) where writing fails otherwise. Values of fields that lie in
/// `blocks` (null: none do), which belongs to the transfer, stay where they are.
void sendFields(int fd, const std::vector<SparseField>& fields, const std::vector<TransferMessage>& messages,
                const TransferBlocks* blocks = nullptr);
void sendInfo(int fd, const VdbFileInfo& info);
void sendFile(int fd, const std::string& bytes, const std::vector<TransferMessage>& messages);
void sendError(int fd, const Error& error);

/// Each returns what was sent, or throws the Error that was sent instead (a GridError or BesideError again, if it was
/// one). Throws Error(input) "what was read is incomplete: ..." where the sender did not finish or sent nonsense. The
/// memory of the fields lives as long as any of them does; `fd` may be closed at once.
ReceivedFields receiveFields(int fd);
VdbFileInfo receiveInfo(int fd);
std::pair<std::string, std::vector<TransferMessage>> receiveFile(int fd);

}  // namespace scrim
