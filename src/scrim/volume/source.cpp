// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/source.h>

#include <scrim/base/error.h>
#include <scrim/volume/source_host.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <map>
#include <sstream>

#include <dlfcn.h>
#include <fmt/format.h>

namespace scrim {

namespace {

namespace fs = std::filesystem;

constexpr const char* kFilePrefix = "scrim_source_";
constexpr const char* kFileSuffix = ".so";
constexpr std::uint32_t kMaxParameters = 1000;  ///< more than that is a damaged description

struct LoadedSource {
    const scrim_source* abi = nullptr;
    SourceDescription description;
};

[[noreturn]] void refuse(const std::string& path, const std::string& reason) {
    throw Error(ErrorKind::input, shortened(path + ": " + reason, 600));
}

/// Sources by name, with the path of the first found.
std::map<std::string, std::string> sourceFiles() {
    std::map<std::string, std::string> files;
    for (const std::string& folder : sourceFolders()) {
        std::error_code error;
        for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error)) {
            const std::string file = entry->path().filename().string();
            if (!file.starts_with(kFilePrefix) || !file.ends_with(kFileSuffix)) continue;
            const std::size_t begin = std::strlen(kFilePrefix);
            const std::string name = file.substr(begin, file.size() - begin - std::strlen(kFileSuffix));
            if (!name.empty()) files.emplace(name, entry->path().string());
        }
    }
    return files;
}

std::string fileOf(const std::string& name) {
    const auto files = sourceFiles();
    if (const auto found = files.find(name); found != files.end()) return found->second;
    std::vector<std::string> names;
    for (const auto& [other, path] : files) names.push_back(other);
    throw Error(ErrorKind::input, shortened(fmt::format("no volume source '{}' in {}; there is {}", shortened(name, 80),
                                                        fmt::join(sourceFolders(), ", "), choices(names)),
                                            1000));
}

std::string copied(const char* text) {
    return text != nullptr ? shortened(text) : "";
}

ParameterDescription describe(const scrim_parameter& p, const std::string& path) {
    ParameterDescription out;
    if (p.name == nullptr || *p.name == '\0') refuse(path, "one of its parameters has no name");
    out.name = shortened(p.name, 80);
    if (p.type < SCRIM_NUMBER || p.type > SCRIM_BOOL)
        refuse(path, fmt::format("its parameter '{}' has the unknown type {}", out.name, p.type));
    out.type = static_cast<ParameterType>(p.type);
    if (p.default_text == nullptr) refuse(path, "its parameter '" + out.name + "' has no default");
    out.defaultText = p.default_text;
    out.minimum = p.minimum;
    out.maximum = p.maximum;
    if (!(out.minimum <= out.maximum)) refuse(path, "its parameter '" + out.name + "' has an empty range");
    out.help = copied(p.help);
    if (p.choices != nullptr) {
        std::istringstream list(p.choices);
        for (std::string choice; std::getline(list, choice, '|');) out.choices.push_back(choice);
    }
    return out;
}

/// Parameters lie as far apart as the source's own structure is large, which may be larger than ours.
std::vector<ParameterDescription> describeAll(const scrim_source& source, const std::string& path) {
    std::vector<ParameterDescription> out;
    if (source.parameter_count == 0) return out;
    if (source.parameters == nullptr || source.parameter_count > kMaxParameters ||
        source.parameter_size < sizeof(scrim_parameter) || source.parameter_size % alignof(scrim_parameter) != 0)
        refuse(path, fmt::format("its {} parameters of {} bytes make no sense", source.parameter_count,
                                 source.parameter_size));
    const auto* bytes = reinterpret_cast<const unsigned char*>(source.parameters);
    for (std::uint32_t i = 0; i < source.parameter_count; ++i) {
        const void* at = bytes + std::size_t{i} * source.parameter_size;
        out.push_back(describe(*static_cast<const scrim_parameter*>(at), path));
        for (std::size_t j = 0; j + 1 < out.size(); ++j)
            if (out[j].name == out.back().name) refuse(path, "it has two parameters called '" + out.back().name + "'");
    }
    parseParameters(out, {}, path + ": default");
    return out;
}

/// Loads `path` for good: what has been loaded once may have started threads or registered handlers, and is
/// never unloaded.
LoadedSource load(const std::string& name, const std::string& path) {
    void* library = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) {
        const char* reason = ::dlerror();
        refuse(path, "cannot be loaded: " + copied(reason));
    }
    void* symbol = ::dlsym(library, SCRIM_SOURCE_SYMBOL);
    if (symbol == nullptr) refuse(path, "is not a volume source: it does not export " SCRIM_SOURCE_SYMBOL);

    LoadedSource out;
    out.abi = reinterpret_cast<scrim_source_function>(symbol)();
    if (out.abi == nullptr) refuse(path, "its " SCRIM_SOURCE_SYMBOL " returns no description");
    if (out.abi->abi_version != SCRIM_SOURCE_ABI)
        refuse(path, fmt::format("is made for version {} of the interface, expected {}", out.abi->abi_version,
                                 SCRIM_SOURCE_ABI));
    if (out.abi->struct_size < sizeof(scrim_source))
        refuse(path, fmt::format("its description has {} bytes, expected at least {}", out.abi->struct_size,
                                 sizeof(scrim_source)));
    if (out.abi->generate == nullptr) refuse(path, "its description lacks 'generate'");
    if (out.abi->name == nullptr || name != out.abi->name)
        refuse(path, fmt::format("calls itself '{}', expected '{}' as in its file name", copied(out.abi->name), name));
    out.description.name = name;
    out.description.description = copied(out.abi->description);
    out.description.path = path;
    out.description.parameters = describeAll(*out.abi, path);
    return out;
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
    // Any address inside this library does.
    static const char here = 0;
    Dl_info info{};
    if (::dladdr(&here, &info) != 0 && info.dli_fname != nullptr) {
        const fs::path library = fs::weakly_canonical(info.dli_fname, error);
        if (!error) add(library.parent_path() / "scrim/sources");
    }
    return folders;
}

std::vector<SourceDescription> listSources(const MessageSink& messages) {
    std::vector<SourceDescription> sources;
    for (const auto& [name, path] : sourceFiles()) {
        try {
            sources.push_back(load(name, path).description);
        } catch (const Error& error) {
            notify(messages, Severity::warning, error.what());
        }
    }
    return sources;
}

SourceDescription describeSource(const std::string& name) {
    return load(name, fileOf(name)).description;
}

std::vector<SparseField> generate(const std::string& name,
                                  const std::vector<std::pair<std::string, std::string>>& parameters,
                                  const MessageSink& messages, const ProgressSink& progress) {
    const LoadedSource source = load(name, fileOf(name));
    const std::string where = "source '" + name + "'";
    const ParameterValues values = parseParameters(source.description.parameters, parameters, where);
    SourceHost host(where, messages, progress);
    int code = 0;
    try {
        code = source.abi->generate(host.abi(), values.values.data());
    } catch (...) {
        // Undefined by the interface, but where the run-time allows it a reason is better than an abort.
        throw Error(ErrorKind::input, where + ": it threw an exception, which sources must not");
    }
    return host.finish(code);
}

}  // namespace scrim
