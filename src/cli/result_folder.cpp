// SPDX-License-Identifier: Apache-2.0
#include "result_folder.h"

#include <scrim/base/atomic_file.h>
#include <scrim/base/error.h>

#include <fmt/format.h>

#include <filesystem>
#include <system_error>
#include <utility>

namespace scrim::cli {

ResultFolder::ResultFolder(std::string path) : m_path(std::move(path)) {
    std::error_code ignored;
    if (make()) std::filesystem::remove(m_path, ignored);
}

void ResultFolder::claim(const std::string& path, std::initializer_list<const char*> names, FileClaims& claims) {
    for (const char* name : names)
        claims.writesAlone((std::filesystem::path(path) / name).string(), "a result of the study");
    removeAbandonedFiles(path);
}

void ResultFolder::write(const std::string& name, const std::string& text) const {
    make();
    writeWholeFile((std::filesystem::path(m_path) / name).string(), text);
}

bool ResultFolder::make() const {
    std::error_code error;
    const bool made = std::filesystem::create_directories(m_path, error);
    if (error) throw Error(ErrorKind::output, fmt::format("cannot make the folder '{}': {}", m_path, error.message()));
    return made;
}

}  // namespace scrim::cli
