// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/loaded_source.h>

#include <scrim/base/error.h>
#include <scrim/volume/source_host.h>

#include <cstring>
#include <sstream>

#include <dlfcn.h>
#include <fmt/format.h>

namespace scrim {
namespace {

constexpr const char* kFilePrefix = "scrim_source_";
constexpr const char* kFileSuffix = ".so";
constexpr std::uint32_t kMaxParameters = 1000;  ///< a description with more parameters is damaged

[[noreturn]] void refuse(const std::string& path, const std::string& reason) {
    throw Error(ErrorKind::input, shortened(path + ": " + reason, 600));
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

/// The descriptions of all parameters. Their stride is the size of the source's own structure,
/// which may be larger than ours.
std::vector<ParameterDescription> describeAll(const scrim_source& source, const std::string& path) {
    std::vector<ParameterDescription> out;
    if (source.parameter_count == 0) return out;
    if (source.parameters == nullptr || source.parameter_count > kMaxParameters ||
        source.parameter_size < sizeof(scrim_parameter) || source.parameter_size % alignof(scrim_parameter) != 0)
        refuse(path,
               fmt::format("its {} parameters of {} bytes are invalid", source.parameter_count, source.parameter_size));
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

const scrim_source* load(const std::string& path) {
    void* library = ::dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL);
    if (library == nullptr) {
        const char* reason = ::dlerror();
        refuse(path, "cannot be loaded: " + copied(reason));
    }
    void* symbol = ::dlsym(library, SCRIM_SOURCE_SYMBOL);
    if (symbol == nullptr) refuse(path, "is not a volume source: it does not export " SCRIM_SOURCE_SYMBOL);

    const scrim_source* abi = reinterpret_cast<scrim_source_function>(symbol)();
    if (abi == nullptr) refuse(path, "its " SCRIM_SOURCE_SYMBOL " returns no description");
    if (abi->abi_version != SCRIM_SOURCE_ABI)
        refuse(path,
               fmt::format("is made for version {} of the interface, expected {}", abi->abi_version, SCRIM_SOURCE_ABI));
    if (abi->struct_size < sizeof(scrim_source))
        refuse(path, fmt::format("its description has {} bytes, expected at least {}", abi->struct_size,
                                 sizeof(scrim_source)));
    if (abi->generate == nullptr) refuse(path, "its description lacks 'generate'");
    const std::string name = sourceNameOf(path);
    if (abi->name == nullptr || name != abi->name)
        refuse(path, fmt::format("calls itself '{}', expected '{}' as in its file name", copied(abi->name), name));
    return abi;
}

}  // namespace

std::string sourceNameOf(const std::string& path) {
    const std::string file = path.substr(path.rfind('/') + 1);
    const std::size_t before = std::strlen(kFilePrefix), after = std::strlen(kFileSuffix);
    if (!file.starts_with(kFilePrefix) || !file.ends_with(kFileSuffix) || file.size() < before + after) return "";
    return file.substr(before, file.size() - before - after);
}

LoadedSource::LoadedSource(const std::string& path) : m_abi(load(path)) {
    m_description.name = m_abi->name;
    m_description.description = copied(m_abi->description);
    m_description.path = path;
    m_description.parameters = describeAll(*m_abi, path);
}

std::vector<SparseField> LoadedSource::run(const SourceParameters& parameters, const MessageSink& messages,
                                           const ProgressSink& progress, BlockMemory& memory, bool alone) const {
    const std::string where = "source '" + m_description.name + "'";
    const ParameterValues values = parseParameters(m_description.parameters, parameters, where);
    SourceHost host(where, messages, progress, alone);
    int code = 0;
    try {
        code = m_abi->generate(host.abi(), values.values.data());
    } catch (...) {
        // The interface leaves this undefined, but where the run-time can carry the exception, a
        // reason is better than an abort.
        throw Error(ErrorKind::input, where + ": it threw an exception; a source must not throw");
    }
    return host.finish(code, memory);
}

}  // namespace scrim
