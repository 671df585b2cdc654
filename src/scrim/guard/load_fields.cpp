// SPDX-License-Identifier: Apache-2.0
#include <scrim/guard/load_fields.h>

#include <scrim/base/error.h>
#include <scrim/base/installed.h>
#include <scrim/volume/foreign_format.h>
#include <scrim/image/texture_read.h>
#include <scrim/guard/guarded_load.h>
#include <scrim/volume/read_fields.h>
#include <scrim/volume/source.h>
#include <scrim/volume/vdb_file.h>
#include <scrim/volume/vdb_module.h>

#include <filesystem>

#include <fmt/format.h>

namespace scrim {
namespace {

/// A progress sink for sources, through which no exception may pass: it asks to stop where `checkpoint` throws.
ProgressSink asProgress(const Checkpoint& checkpoint) {
    return [checkpoint](double) {
        try {
            if (checkpoint) checkpoint();
        } catch (const Error&) {
            return false;
        }
        return true;
    };
}

/// The editor for grids of this process.
std::shared_ptr<const GridEditor> editorHere(const GridEdit& edit) {
    const AxModule* const ax =
        edit.programs.empty() ? nullptr : loadAxModule(besideLibrary(kAxModule), edit.programs.front().where);
    return vdbModule().editor(edit, ax);
}

}  // namespace

std::vector<SparseField> loadFields(const std::string& path, const std::vector<GridRequest>& requests,
                                    const LoadOptions& options, const MessageSink& messages,
                                    const Checkpoint& checkpoint, const GridEdit* edit) {
    if (options.volumes == VolumeLoading::guarded)
        return guardedFields(path, requests, options, messages, checkpoint, edit);
    std::vector<SparseField> fields;
    readWithErrors(path, [&] {
        BlockMemory memory;
        fields = edit == nullptr || !edit->editsGrids()
                     ? readFields(VdbBytes(path), requests, messages, memory, edit ? edit->points : PointLook())
                     : readFields(openFiles(path, edit->files), requests, *editorHere(*edit), messages);
    });
    return fields;
}

std::vector<SparseField> editedFields(const std::vector<SparseField>& grids, const std::string& name,
                                      const std::vector<GridRequest>& requests, const GridEdit& edit,
                                      const LoadOptions& options, const MessageSink& messages,
                                      const Checkpoint& checkpoint) {
    if (options.volumes == VolumeLoading::guarded)
        return guardedEdit(grids, name, requests, edit, options, messages, checkpoint);
    std::vector<SparseField> fields;
    readWithErrors(name, [&] { fields = editFields(grids, name, requests, *editorHere(edit), messages); });
    return fields;
}

std::string fileIn(const SourceParameters& parameters) {
    for (const auto& [name, value] : parameters)
        if (name == "file") return value;
    return "";
}

std::vector<SparseField> sourceFields(const std::string& source, const SourceParameters& parameters,
                                      const LoadOptions& options, const MessageSink& messages,
                                      const Checkpoint& checkpoint) {
    const std::string file = fileIn(parameters);
    // The source would take any unknown ending for a raw file, and ask for its size.
    if (const ForeignFormat* const format = foreignFormat(file); format != nullptr && source == "scan")
        throw Error(ErrorKind::input, fmt::format("source 'scan': {}: {}", file, textOf(*format)));
    if (options.volumes != VolumeLoading::guarded || file.empty())
        return generate(source, parameters, messages, asProgress(checkpoint));
    const std::string path = std::filesystem::absolute(sourceFile(source)).string();
    return guardedSource(path, parameters, file, options, messages, checkpoint);
}

FilePicture readPicture(const std::string& path, const LoadOptions& options, const Checkpoint& checkpoint) {
    checkPictureFile(path);
    if (options.volumes == VolumeLoading::guarded) return guardedPicture(path, options, checkpoint);
    return pictureModule().read(path);
}

FileDepth readDepth(const std::string& path, const std::string& channel, const LoadOptions& options,
                    const Checkpoint& checkpoint) {
    checkPictureFile(path);
    if (options.volumes == VolumeLoading::guarded) return guardedDepth(path, channel, options, checkpoint);
    return pictureModule().depth(path, channel);
}

FilePhotometry loadPhotometry(const std::string& path, const LoadOptions& options, const Checkpoint& checkpoint) {
    FilePhotometry file;
    if (options.volumes == VolumeLoading::guarded)
        file = guardedPhotometry(path, options, checkpoint);
    else
        readWithErrors(path, [&] { file = readPhotometry(path); });
    if (!file.problem.empty()) throw Error(ErrorKind::input, file.problem);
    return file;
}

TriangleMesh loadMesh(const std::string& path, const LoadOptions& options, const Checkpoint& checkpoint) {
    const auto inThisProcess = [&] {
        void* const module = moduleFunction(kMeshModule, SCRIM_MESH_MODULE_SYMBOL, "reads meshes");
        return reinterpret_cast<MeshModuleFunction>(module)()->read(path, false);
    };
    FileMesh file =
        options.volumes == VolumeLoading::guarded ? guardedMesh(path, options, checkpoint) : inThisProcess();
    if (!file.problem.empty()) throw Error(ErrorKind::input, file.problem);
    return std::move(file.mesh);
}

VdbFileInfo loadInfo(const std::string& path, const LoadOptions& options, const Checkpoint& checkpoint) {
    if (options.volumes == VolumeLoading::guarded) return guardedInfo(path, options, checkpoint);
    VdbFileInfo info;
    readWithErrors(path, [&] { info = VdbFile::open(path).info(); });
    return info;
}

}  // namespace scrim
