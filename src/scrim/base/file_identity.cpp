// SPDX-License-Identifier: Apache-2.0
#include <scrim/base/file_identity.h>

#include <filesystem>
#include <system_error>

#include <sys/stat.h>

namespace scrim {

FileIdentity identityOf(const std::string& path) {
    std::error_code error;
    std::filesystem::path place = std::filesystem::absolute(path, error), rest;
    for (;;) {
        struct stat status {};
        if (::stat(place.c_str(), &status) == 0)
            return {static_cast<std::uint64_t>(status.st_dev), static_cast<std::uint64_t>(status.st_ino),
                    rest.lexically_normal().string()};
        if (!place.has_relative_path()) return {0, 0, path};
        rest = rest.empty() ? place.filename() : place.filename() / rest;
        place = place.parent_path();
    }
}

}  // namespace scrim
