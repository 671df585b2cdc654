// SPDX-License-Identifier: Apache-2.0
#include "file_claims.h"

#include <scrim/base/error.h>

#include <fmt/format.h>

#include <filesystem>

namespace scrim::cli {

void FileClaims::reads(const std::string& path, const std::string& role) {
    if (!path.empty()) m_read.emplace(identityOf(path), role);
}

std::string FileClaims::writes(const std::string& path, const std::string& role) {
    const FileIdentity identity = identityOf(path);
    if (const auto read = m_read.find(identity); read != m_read.end())
        throw Error(ErrorKind::usage, fmt::format("{} '{}' would overwrite {}, which is read; write to another file",
                                                  role, shortened(path), read->second));
    const auto [writer, isNew] = m_written.emplace(identity, role);
    if (!isNew) return writer->second;
    m_folders.insert(std::filesystem::path(linkTarget(path)).parent_path().string());
    return {};
}

void FileClaims::writesAlone(const std::string& path, const std::string& role) {
    const std::string other = writes(path, role);
    if (!other.empty())
        throw Error(ErrorKind::usage,
                    fmt::format("'{}' would be written twice, for {} and for {}", shortened(path), other, role));
}

std::set<std::string> FileClaims::folders() const {
    return m_folders;
}

}  // namespace scrim::cli
