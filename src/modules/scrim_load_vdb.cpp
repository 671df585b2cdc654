// SPDX-License-Identifier: Apache-2.0
// The module of the program `scrim-load`: the parts of it that need OpenVDB. It only reads.
#include <scrim/volume/vdb_module.h>

#include <openvdb/openvdb.h>

extern "C" __attribute__((visibility("default"))) const scrim::VdbModule* scrim_vdb_module_7() {
    openvdb::initialize();
    static const scrim::VdbModule module{scrim::readVdbContent,
                                         scrim::readEditedVdbContent,
                                         scrim::editedContent,
                                         scrim::makeGridEditor,
                                         nullptr,
                                         nullptr};
    return &module;
}
