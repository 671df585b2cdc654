// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/vdb_module.h>

#include <scrim/base/installed.h>
#include <scrim/volume/vdb_write.h>

namespace scrim {

const VdbModule& vdbModule() {
    static const VdbModule* const module = reinterpret_cast<VdbModuleFunction>(
        moduleFunction("scrim_vdb.so", SCRIM_VDB_MODULE_SYMBOL, "reads and writes volumes"))();
    return *module;
}

void writeVdb(const std::string& path, const std::vector<SparseField>& fields) {
    vdbModule().write(path, fields);
}

void writeVdbGrids(const std::string& path, const std::vector<VdbGrid>& grids,
                   const std::vector<std::pair<std::string, std::string>>& metadata) {
    vdbModule().writeGrids(path, grids, metadata);
}

}  // namespace scrim
