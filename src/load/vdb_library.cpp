// SPDX-License-Identifier: Apache-2.0
// Replaces the module for OpenVDB, since this program is linked to OpenVDB itself. It only reads.
#include <scrim/volume/vdb_module.h>

namespace scrim {

const VdbModule& vdbModule() {
    static const VdbModule module{readVdbContent, readEditedVdbContent, editedContent, makeGridEditor, nullptr,
                                  nullptr};
    return module;
}

}  // namespace scrim
