// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/vdb_version.h>

#include <openvdb/version.h>

namespace scrim {

std::string openVdbVersion() {
    // This is the version compiled against; asking the library itself would load it.
    return OPENVDB_LIBRARY_VERSION_STRING;
}

std::uint32_t vdbFileVersion() {
    return openvdb::OPENVDB_FILE_VERSION;
}

std::vector<std::string> vdbCodecs() {
    std::vector<std::string> codecs;
#if defined(OPENVDB_USE_ZLIB)
    codecs.emplace_back("zip");
#endif
#if defined(OPENVDB_USE_BLOSC)
    codecs.emplace_back("blosc");
#endif
    return codecs;
}

}  // namespace scrim
