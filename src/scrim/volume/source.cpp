// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/source.h>

#include <scrim/base/error.h>
#include <scrim/base/installed.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <map>
#include <sstream>

#include <fmt/format.h>

namespace scrim {

namespace {

namespace fs = std::filesystem;

/// Sources by name, each with the path where it is found first.
std::map<std::string, std::string> sourceFiles() {
    std::map<std::string, std::string> files;
    for (const std::string& folder : sourceFolders()) {
        std::error_code error;
        for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
            const std::string path = entry->path().string(), name = sourceNameOf(path);
            if (!name.empty()) files.emplace(name, path);
        }
    }
    return files;
}

}  // namespace

std::vector<std::string> sourceFolders() {
    std::vector<std::string> folders;
    const auto add = [&](const fs::path& folder) {
        const std::string text = folder.lexically_normal().string();
        if (!text.empty() && std::find(folders.begin(), folders.end(), text) == folders.end()) folders.push_back(text);
    };
    if (const char* path = std::getenv("SCRIM_PLUGIN_PATH")) {
        std::istringstream list(path);
        for (std::string folder; std::getline(list, folder, ':');)
            if (!folder.empty()) add(folder);
    }
    std::error_code error;
    const fs::path program = fs::read_symlink("/proc/self/exe", error);
    if (!error) add(program.parent_path().parent_path() / "lib/scrim/sources");
    if (!libraryFolder().empty()) add(besideLibrary("sources"));
    return folders;
}

std::string sourceFile(const std::string& name) {
    const auto files = sourceFiles();
    if (const auto found = files.find(name); found != files.end()) return found->second;
    std::vector<std::string> names;
    for (const auto& [other, path] : files) names.push_back(other);
    throw Error(ErrorKind::input, shortened(fmt::format("no volume source '{}' in {}; there is {}", shortened(name, 80),
                                                        fmt::join(sourceFolders(), ", "), choices(names)),
                                            1000));
}

std::vector<SourceDescription> listSources(const MessageSink& messages) {
    std::vector<SourceDescription> sources;
    for (const auto& [name, path] : sourceFiles()) {
        try {
            sources.push_back(LoadedSource(path).description());
        } catch (const Error& error) {
            notify(messages, Severity::warning, error.what());
        }
    }
    return sources;
}

SourceDescription describeSource(const std::string& name) {
    return LoadedSource(sourceFile(name)).description();
}

std::vector<SparseField> generate(const std::string& name, const SourceParameters& parameters,
                                  const MessageSink& messages, const ProgressSink& progress) {
    BlockMemory memory;
    return LoadedSource(sourceFile(name)).run(parameters, messages, progress, memory);
}

}  // namespace scrim
