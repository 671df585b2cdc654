// SPDX-License-Identifier: Apache-2.0
// The module `scrim_vdb`: the parts of the library that need OpenVDB.
#include <scrim/volume/vdb_module.h>

extern "C" __attribute__((visibility("default"))) const scrim::VdbModule* scrim_vdb_module_7() {
    static const scrim::VdbModule module{scrim::readVdbContent,  scrim::readEditedVdbContent,
                                         scrim::editedContent,   scrim::makeGridEditor,
                                         scrim::writeVdbContent, scrim::writeVdbGridContent};
    return &module;
}
