// SPDX-License-Identifier: Apache-2.0
// Hands what one process read to another, so that an untrusted .vdb is parsed in a child that may crash, and
// parsed only once.
//
// The two share a file descriptor: a memfd, or any regular file (transfer_file.h). The receiver maps the file, and the
// blocks of its fields point into the mapping. It trusts nothing: the sender's memory may have been overwritten by the
// file it read.
//
// A child that is forked without exec must be forked by a process without threads: those do not survive a fork, and
// loops in the child would wait for them for ever.
#pragma once

#include <scrim/base/error.h>
#include <scrim/base/messages.h>
#include <scrim/volume/grid_request.h>
#include <scrim/volume/source_parameters.h>
#include <scrim/volume/sparse_field.h>
#include <scrim/guard/transfer_file.h>
#include <scrim/volume/vdb_info.h>

#include <string>
#include <utility>
#include <vector>

namespace scrim {

inline constexpr const char* kPictureHeader = "header";
inline constexpr const char* kPictureDepth = "depth";  ///< of the channel that the one parameter names
inline constexpr const char* kMesh = "mesh";

/// What a child is asked for: "fields" or "info" of a volume file, a "picture", its kPictureHeader or
/// kPictureDepth, or what a "source" makes of a file, or a kMesh. The file is handed to it; its path is for messages.
struct LoadRequest {
    std::string what;
    std::string path;
    std::vector<GridRequest> grids;
    std::string source = {};  ///< path of its shared object, or of the module that reads meshes
    SourceParameters parameters = {};
    std::string beside = {};  ///< name of a file in the same folder that is handed over, too; "": there is none
};

struct TransferMessage {
    Severity severity = Severity::info;
    std::string text;
};

struct ReceivedFields {
    std::vector<SparseField> fields;
    std::vector<TransferMessage> messages;
};

/// Each writes the one thing the transfer holds, from the file's start; `fd` stays open. Throw Error(memory)
/// where there is no space, Error(render) where writing fails otherwise.
void sendRequest(int fd, const LoadRequest& request);
void sendFields(int fd, const std::vector<SparseField>& fields, const std::vector<TransferMessage>& messages);
void sendInfo(int fd, const VdbFileInfo& info);
void sendError(int fd, const Error& error);

/// Each takes over what was sent, and throws the Error (a GridError or BesideError again, if it was one) that was sent
/// instead, if one was. Throws Error(input) "what was read is incomplete: ..." where the sender did not finish or sent
/// nonsense. The memory of the fields lives as long as one of them does; `fd` may be closed at once.
LoadRequest receiveRequest(int fd);
ReceivedFields receiveFields(int fd);
VdbFileInfo receiveInfo(int fd);

}  // namespace scrim
