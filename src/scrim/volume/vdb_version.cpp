// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/vdb_version.h>

#include <openvdb/io/Archive.h>
#include <openvdb/version.h>

namespace scrim {

std::string openVdbVersion() {
    return openvdb::getLibraryVersionString();
}

std::uint32_t vdbFileVersion() {
    return openvdb::OPENVDB_FILE_VERSION;
}

std::vector<std::string> vdbCodecs() {
    std::vector<std::string> codecs;
    if (openvdb::io::Archive::hasZLibCompression()) codecs.emplace_back("zip");
    if (openvdb::io::Archive::hasBloscCompression()) codecs.emplace_back("blosc");
    return codecs;
}

}  // namespace scrim
