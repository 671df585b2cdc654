// SPDX-License-Identifier: Apache-2.0
// Internal: what a child is asked to do. Each task has what its kind needs and nothing else. The
// files are passed as descriptors, and their paths are for messages.
#pragma once

#include <scrim/volume/grid_edit.h>
#include <scrim/volume/grid_request.h>
#include <scrim/volume/source_parameters.h>

#include <optional>
#include <string>
#include <tuple>
#include <variant>
#include <vector>

namespace scrim {

/// What is done to the grids of a volume first.
struct LoadEdit {
    GridEdit edit;
    std::string ax;  ///< path of the module that runs expressions (ax_module.h); "": there are none

    auto members() { return std::tie(edit, ax); }
    bool operator==(const LoadEdit&) const = default;
};

/// The fields of a volume file. Answered by sendFields, as all tasks that make fields.
struct FieldsTask {
    std::vector<GridRequest> grids;
    std::optional<LoadEdit> edit = {};

    auto members() { return std::tie(grids, edit); }
    bool operator==(const FieldsTask&) const = default;
};

/// The description of a volume file. Answered by sendInfo.
struct InfoTask {
    std::optional<LoadEdit> edit = {};

    auto members() { return std::tie(edit); }
    bool operator==(const InfoTask&) const = default;
};

/// All grids of a volume file after an edit. Answered by sendFile.
struct EditedFileTask {
    LoadEdit edit;

    auto members() { return std::tie(edit); }
    bool operator==(const EditedFileTask&) const = default;
};

/// Fields that a source made, and that are handed over in place of a file (sendFields), after an edit.
struct MadeFieldsTask {
    std::vector<GridRequest> grids;
    LoadEdit edit;

    auto members() { return std::tie(grids, edit); }
    bool operator==(const MadeFieldsTask&) const = default;
};

/// The fields that a source makes of a file.
struct SourceTask {
    std::string source;  ///< path of its shared object
    SourceParameters parameters = {};
    std::string beside = {};  ///< name of a second file of the same folder or below that is passed, too; "": none

    auto members() { return std::tie(source, parameters, beside); }
    bool operator==(const SourceTask&) const = default;
};

/// A mesh. Answered by sendMesh.
struct MeshTask {
    std::string module;  ///< path of the module that reads meshes

    auto members() { return std::tie(module); }
    bool operator==(const MeshTask&) const = default;
};

/// A photometric file. Answered by sendPhotometry.
struct PhotometryTask {
    auto members() { return std::tie(); }
    bool operator==(const PhotometryTask&) const = default;
};

/// A picture, its header alone, or the depths of a channel. Answered by sendPicture,
/// sendPictureHeader and sendPictureDepth.
struct PictureTask {
    auto members() { return std::tie(); }
    bool operator==(const PictureTask&) const = default;
};
struct HeaderTask {
    auto members() { return std::tie(); }
    bool operator==(const HeaderTask&) const = default;
};
struct DepthTask {
    std::string channel;  ///< "": the only one that can hold depths

    auto members() { return std::tie(channel); }
    bool operator==(const DepthTask&) const = default;
};

using LoadTask = std::variant<FieldsTask, InfoTask, EditedFileTask, MadeFieldsTask, SourceTask, MeshTask,
                              PhotometryTask, PictureTask, HeaderTask, DepthTask>;

struct LoadRequest {
    std::string path;
    LoadTask task;
};

/// What a task does to grids first; null: nothing.
const LoadEdit* editOf(const LoadTask& task);

/// Writes the request as the whole contents of a transfer (transfer_file.h); `fd` stays open.
/// Throws Error(memory) where there is no space, Error(render) where writing fails otherwise.
void sendRequest(int fd, const LoadRequest& request);
/// Returns what was sent. Throws Error(input) "what was read is incomplete: ..." where that is no request.
LoadRequest receiveRequest(int fd);

}  // namespace scrim
