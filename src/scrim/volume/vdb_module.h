// SPDX-License-Identifier: Apache-2.0
// Internal: the code that needs OpenVDB. Binding the 67,000 names of OpenVDB's library takes four times as long as the
// rest of a program's start. Therefore the library is not linked to it. A module is, which is loaded only where this
// process itself reads or writes .vdb files. So it is with the program `scrim-load`, which reads them on its behalf,
// and without OpenVDB where it can (direct_fields.h).
#pragma once

#include <scrim/volume/ax_module.h>
#include <scrim/volume/block_memory.h>
#include <scrim/volume/point_cloud.h>
#include <scrim/volume/vdb_bytes.h>
#include <scrim/volume/vdb_file.h>
#include <scrim/volume/vdb_write.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace scrim {

/// The interface behind VdbFile.
struct VdbFile::Content {
    virtual ~Content() = default;
    virtual VdbFileInfo info() const = 0;
    virtual std::vector<std::string> usableGrids() const = 0;
    virtual SparseField field(const GridRequest& request, const MessageSink& messages) const = 0;
    virtual SparseField lastField(const GridRequest& request, const MessageSink& messages) = 0;
    virtual std::string asFile() const = 0;
};

/// Each implements the function that calls it: VdbFile::open (null requests: read the whole file;
/// null memory: read all fields from grids),
/// VdbFile::of, writeVdb and writeVdbGrids.
std::unique_ptr<VdbFile::Content> readVdbContent(const VdbBytes& file, const std::vector<GridRequest>* requests,
                                                 BlockMemory* memory, const PointLook& look);
std::unique_ptr<VdbFile::Content> readEditedVdbContent(const VdbFiles& files, const std::vector<GridRequest>* requests,
                                                       const GridEditor& editor, const MessageSink& messages);
std::unique_ptr<VdbFile::Content> editedContent(const std::vector<SparseField>& fields, const std::string& name,
                                                const GridEditor& editor, const MessageSink& messages);
/// Makes the editor of an edit; null `ax`: no AX is needed.
std::shared_ptr<const GridEditor> makeGridEditor(const GridEdit& edit, const AxModule* ax);
void writeVdbContent(const std::string& path, const std::vector<SparseField>& fields);
void writeVdbGridContent(const std::string& path, const std::vector<VdbGrid>& grids,
                         const std::vector<std::pair<std::string, std::string>>& metadata);

struct VdbModule {
    decltype(&readVdbContent) read = nullptr;
    decltype(&readEditedVdbContent) readEdited = nullptr;
    decltype(&editedContent) editFields = nullptr;
    decltype(&makeGridEditor) editor = nullptr;
    decltype(&writeVdbContent) write = nullptr;
    decltype(&writeVdbGridContent) writeGrids = nullptr;
};

/// The single function that the module exports. The name must change whenever anything above changes.
#define SCRIM_VDB_MODULE_SYMBOL "scrim_vdb_module_7"
using VdbModuleFunction = const VdbModule* (*)();

/// Loads the module and never unloads it. May be called from any thread. Throws Error(render) where
/// it cannot be loaded. `scrim-load` has a module of its own.
const VdbModule& vdbModule();

}  // namespace scrim
