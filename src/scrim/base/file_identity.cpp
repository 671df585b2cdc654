// SPDX-License-Identifier: Apache-2.0
#include <scrim/base/file_identity.h>

#include <filesystem>
#include <system_error>

#include <sys/stat.h>

namespace scrim {

FileIdentity identityOf(const std::string& path) {
    std::error_code error;
    std::filesystem::path place = std::filesystem::absolute(linkTarget(path), error), rest;
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

std::string linkTarget(const std::string& path) {
    constexpr int kMostLinks = 40;  // as Linux has it
    std::filesystem::path place = path;
    for (int links = 0; links <= kMostLinks; ++links) {
        std::error_code isNone;
        const std::filesystem::path next = std::filesystem::read_symlink(place, isNone);
        if (isNone) return place.string();
        place = place.parent_path() / next;
    }
    return path;
}

}  // namespace scrim
