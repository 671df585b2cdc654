// SPDX-License-Identifier: Apache-2.0
// Hands the data that one process has read to another, so that an untrusted .vdb is parsed in a child that may crash,
// and parsed only once.
//
// The two share a file descriptor: a memfd, or any regular file (transfer_file.h). The receiver maps the file, and the
// blocks of its fields point into the mapping. It trusts nothing in it: the file that the sender read may have made it
// overwrite its own memory.
//
// A child that is forked without exec must be forked by a process without threads, because threads do not survive a
// fork and loops in the child would wait for them forever.
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
inline constexpr const char* kPictureDepth = "depth";  ///< depth channel; the one parameter is its name
inline constexpr const char* kMesh = "mesh";
inline constexpr const char* kPhotometry = "photometry";
inline constexpr const char* kEditedFile = "file";  ///< all grids of a file after an edit, as a .vdb file
inline constexpr const char* kMadeFields = "made";  ///< fields that a source made, to be edited

/// The task for a child. `what` is "fields" or "info" of a volume file, "picture", kPictureHeader or kPictureDepth of a
/// picture, "source" to run a source on a file, kMesh, kPhotometry, kMadeFields, or kEditedFile. The file is passed as
/// a descriptor; its path is for messages.
struct LoadRequest {
    std::string what;
    std::string path;
    std::vector<GridRequest> grids;
    std::string source = {};  ///< path of the source's shared object, or of the module that reads meshes or runs AX
    SourceParameters parameters = {};
    std::string beside = {};  ///< name of a second file of the same folder or below that is passed, too; "": none
    std::string edit = {};    ///< what is done to the grids (grid_edit.h); "": nothing
};

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
void sendRequest(int fd, const LoadRequest& request);
void sendFields(int fd, const std::vector<SparseField>& fields, const std::vector<TransferMessage>& messages,
                const TransferBlocks* blocks = nullptr);
void sendInfo(int fd, const VdbFileInfo& info);
void sendFile(int fd, const std::string& bytes, const std::vector<TransferMessage>& messages);
void sendError(int fd, const Error& error);

/// Each returns what was sent, or throws the Error that was sent instead (a GridError or BesideError again, if it was
/// one). Throws Error(input) "what was read is incomplete: ..." where the sender did not finish or sent nonsense. The
/// memory of the fields lives as long as any of them does; `fd` may be closed at once.
LoadRequest receiveRequest(int fd);
ReceivedFields receiveFields(int fd);
VdbFileInfo receiveInfo(int fd);
std::pair<std::string, std::vector<TransferMessage>> receiveFile(int fd);

}  // namespace scrim
