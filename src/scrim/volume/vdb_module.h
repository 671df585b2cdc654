// SPDX-License-Identifier: Apache-2.0
// Internal: what needs OpenVDB. Its library has 67,000 names to be bound at every start, which takes four times as long
// as all the rest. So the library is not linked to it: a module is, which is loaded where this process reads or writes
// .vdb files itself, and so is the program `scrim-load`, which reads them for it.
#pragma once

#include <scrim/volume/vdb_bytes.h>
#include <scrim/volume/vdb_file.h>
#include <scrim/volume/vdb_write.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

namespace scrim {

/// What VdbFile is made of.
struct VdbFile::Content {
    virtual ~Content() = default;
    virtual VdbFileInfo info() const = 0;
    virtual std::vector<std::string> usableGrids() const = 0;
    virtual SparseField field(const GridRequest& request, const MessageSink& messages) const = 0;
    virtual SparseField lastField(const GridRequest& request, const MessageSink& messages) = 0;
};

/// Each as the function that calls it: VdbFile::open (null: for no requests, but all of the file), writeVdb and
/// writeVdbGrids.
std::unique_ptr<VdbFile::Content> readVdbContent(const VdbBytes& file, const std::vector<GridRequest>* requests);
void writeVdbContent(const std::string& path, const std::vector<SparseField>& fields);
void writeVdbGridContent(const std::string& path, const std::vector<VdbGrid>& grids,
                         const std::vector<std::pair<std::string, std::string>>& metadata);

struct VdbModule {
    decltype(&readVdbContent) read = nullptr;
    decltype(&writeVdbContent) write = nullptr;
    decltype(&writeVdbGridContent) writeGrids = nullptr;
};

/// The one function that the module exports. Its name changes with whatever stands above.
#define SCRIM_VDB_MODULE_SYMBOL "scrim_vdb_module_2"
using VdbModuleFunction = const VdbModule* (*)();

/// Loads the module, for good. May be called from any thread. Throws Error(render) where it cannot be loaded. In
/// `scrim-load` it is part of the program.
const VdbModule& vdbModule();

}  // namespace scrim
