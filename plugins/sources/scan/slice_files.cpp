// SPDX-License-Identifier: Apache-2.0
#include "slice_files.h"

#include "scan.h"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string_view>

namespace scan {
namespace {

// The first line of a file that holds a folder's files (scrim_source.h).
constexpr std::string_view kFolderMark = "scrim folder\n";

bool isDirectory(const std::string& path) {
    std::error_code ignored;
    return std::filesystem::is_directory(path, ignored);
}

/// The files in `path`, which holds those of a folder in the form that scrim_source.h describes.
std::vector<SliceFile> bundledFiles(const std::string& path) {
    std::vector<SliceFile> files;
    std::ifstream in(path, std::ios::binary);
    const std::int64_t all = fileBytes(path);
    in.seekg(static_cast<std::streamoff>(kFolderMark.size()));
    std::int64_t bytes = 0;
    for (std::string name; in >> bytes && in.get() == ' ' && std::getline(in, name);) {
        const auto begin = static_cast<std::int64_t>(in.tellg());
        if (bytes < 0 || bytes > all - begin) refuse(path, "the folder's files are incomplete");
        files.push_back({name, path, begin, bytes});
        in.seekg(begin + bytes);
    }
    return files;
}

/// True where `name` is `pattern`, in which each '*' stands for any characters.
bool matches(std::string_view name, std::string_view pattern) {
    const std::size_t star = pattern.find('*');
    if (star == std::string_view::npos) return name == pattern;
    if (!name.starts_with(pattern.substr(0, star))) return false;
    pattern.remove_prefix(star + 1);
    for (std::size_t at = star; at <= name.size(); ++at)
        if (matches(name.substr(at), pattern)) return true;
    return false;
}

}  // namespace

std::string SliceFile::contents(std::int64_t most) const {
    std::ifstream in(path, std::ios::binary);
    in.seekg(begin);
    if (bytes < 0 && most < 0) {
        std::ostringstream all;
        all << in.rdbuf();
        return std::move(all).str();
    }
    const std::int64_t wanted = bytes < 0 ? most : most < 0 ? bytes : std::min(bytes, most);
    std::string text(static_cast<std::size_t>(wanted), '\0');
    in.read(text.data(), wanted);
    text.resize(static_cast<std::size_t>(in.gcount()));
    return text;
}

bool beginsAsDicom(const std::string& bytes) {
    return bytes.size() >= 132 && bytes.compare(128, 4, "DICM") == 0;
}

bool beginsAsTiff(const std::string& bytes) {
    // Little or big endian, with offsets of 4 bytes or (BigTIFF) 8.
    for (const std::string_view start : {"II\x2a\0", "MM\0\x2a", "II\x2b\0", "MM\0\x2b"})
        if (bytes.size() >= 4 && std::string_view(bytes).substr(0, 4) == std::string_view(start.data(), 4)) return true;
    return false;
}

bool isFolder(const std::string& path) {
    if (isDirectory(path)) return true;
    std::error_code ignored;
    if (!std::filesystem::is_regular_file(path, ignored)) return false;  // a pipe would never begin
    return SliceFile{"", path}.contents(static_cast<std::int64_t>(kFolderMark.size())) == kFolderMark;
}

std::vector<SliceFile> filesIn(const std::string& folder) {
    if (!isDirectory(folder)) return bundledFiles(folder);
    std::vector<SliceFile> files;
    for (const auto& entry : std::filesystem::directory_iterator(folder))
        if (entry.is_regular_file()) files.push_back({entry.path().filename().string(), entry.path().string()});
    std::sort(files.begin(), files.end(), [](const auto& a, const auto& b) { return a.name < b.name; });
    return files;
}

bool isPattern(const std::string& path) {
    std::error_code ignored;
    const bool isThere = std::filesystem::exists(path, ignored);
    return std::filesystem::path(path).filename().string().find('*') != std::string::npos &&
           (!isThere || isFolder(path));
}

std::vector<SliceFile> filesMatching(const std::string& path) {
    const std::filesystem::path own(path);
    const std::string folder = own.has_parent_path() ? own.parent_path().string() : ".";
    std::vector<SliceFile> files;
    if (isFolder(path))
        files = filesIn(path);
    else if (isDirectory(folder))
        files = filesIn(folder);
    std::erase_if(files, [&](const SliceFile& file) { return !matches(file.name, own.filename().string()); });
    return files;
}

}  // namespace scan
