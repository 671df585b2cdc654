// SPDX-License-Identifier: Apache-2.0
// Reads NRRD with Teem, in two passes: the header alone first, so that its declarations can be compared with the file's
// size before anything is allocated.
#include "scan.h"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <string_view>

#include <fmt/format.h>
#include <teem/nrrd.h>

namespace scan {
namespace {

struct Free {
    void operator()(Nrrd* nrrd) const { nrrdNuke(nrrd); }
    void operator()(NrrdIoState* state) const { nrrdIoStateNix(state); }
};
using NrrdOwner = std::unique_ptr<Nrrd, Free>;
using StateOwner = std::unique_ptr<NrrdIoState, Free>;

/// The innermost of the lines "[nrrd] function: text" that Teem has gathered.
std::string teemError() {
    char* gathered = biffGetDone(NRRD);
    std::string text = gathered != nullptr ? gathered : "";
    std::free(gathered);
    while (!text.empty() && text.back() == '\n') text.pop_back();
    text.erase(0, text.rfind('\n') + 1);
    const std::size_t colon = text.find(": ");
    return colon == std::string::npos ? text : text.substr(colon + 2);
}

/// Refuses headers that name files elsewhere: an untrusted header must not choose any file of the disk.
void checkFolder(const NrrdIoState& state, const std::string& path) {
    for (unsigned i = 0; i < state.dataFNArr->len; ++i) {
        const std::string_view name = state.dataFN[i];
        if (name.find('/', name.starts_with("./") ? 2 : 0) != name.npos)
            refuse(path,
                   fmt::format("its samples are in '{}', expected a file in its own folder", name.substr(0, 200)));
    }
}

/// Teem needs the dimension of space before the first direction in it, and some writers leave it out. Returns the file
/// with that line added; empty where it is not missing, or where the samples are in a separate file.
std::string mended(const std::string& path) {
    constexpr std::streamsize kMostOfHeader = 65536;
    std::ifstream file(path, std::ios::binary);
    std::string text(kMostOfHeader, '\0');
    file.read(text.data(), kMostOfHeader);
    text.resize(static_cast<std::size_t>(file.gcount()));
    const std::size_t end = text.find("\n\n"), first = text.find('\n');
    if (end == std::string::npos) return "";
    const auto has = [&](const char* key) { return text.find(key) < end; };
    if (!has("\nspace directions:") || has("\nspace:") || has("\nspace dimension:") || has("\ndata file:") ||
        has("\ndatafile:"))
        return "";
    file.clear();
    for (std::string more(kMostOfHeader, '\0'); file.read(more.data(), kMostOfHeader) || file.gcount() > 0;)
        text.append(more, 0, static_cast<std::size_t>(file.gcount()));
    return text.insert(first + 1, "space dimension: 3\n");
}

bool loaded(Nrrd* nrrd, NrrdIoState* state, const std::string& path, std::string& mendedText) {
    if (mendedText.empty()) return nrrdLoad(nrrd, path.c_str(), state) == 0;
    std::FILE* const file = fmemopen(mendedText.data(), mendedText.size(), "rb");
    if (file == nullptr) refuse(path, "not enough memory to read it");
    const bool done = nrrdRead(nrrd, file, state) == 0;
    std::fclose(file);
    return done;
}

void load(Nrrd* nrrd, NrrdIoState* state, const std::string& path, std::string& mendedText) {
    if (loaded(nrrd, state, path, mendedText)) return;
    const std::string reason = teemError();
    if (state != nullptr) checkFolder(*state, path);
    refuse(path, reason);
}

/// The file that holds the samples: `path` itself, or the one its header names.
std::string dataFile(const NrrdIoState& state, const std::string& path) {
    if (state.dataFNFormat != nullptr || state.dataFNArr->len > 1)
        refuse(path, "its samples are in several files, expected one");
    if (state.dataFNArr->len == 0) return path;
    // The folder is used as it was named: "a/../b" is not "b" where a is a link.
    const std::filesystem::path name = std::filesystem::path(state.dataFN[0]).lexically_normal();
    return (std::filesystem::path(path).parent_path() / name).string();
}

std::string typeName(int type) {
    return airEnumStr(nrrdType, type);
}

/// The name of a sample type, as in the parameter for raw files.
std::string sampleTypeOf(int type) {
    constexpr const char* kNames[] = {"int8",   "uint8", "int16",  "uint16", "int32",
                                      "uint32", "int64", "uint64", "float",  "double"};
    return type >= nrrdTypeChar && type <= nrrdTypeDouble ? kNames[type - nrrdTypeChar] : typeName(type);
}

/// Refuses a header whose samples cannot be in the file.
void checkBytes(const Nrrd& nrrd, const NrrdIoState& state, const std::string& path) {
    const Size size{static_cast<std::int64_t>(nrrd.axis[0].size), static_cast<std::int64_t>(nrrd.axis[1].size),
                    static_cast<std::int64_t>(nrrd.axis[2].size)};
    const std::int64_t count = sampleCount(size, path);
    const std::int64_t bytes = count * static_cast<std::int64_t>(nrrdTypeSize[nrrd.type]);
    const std::string file = dataFile(state, path);
    const std::int64_t stored = fileBytes(file);
    // As text, a sample takes a digit and a separator.
    const std::int64_t least = state.encoding == nrrdEncodingRaw     ? bytes
                               : state.encoding == nrrdEncodingAscii ? 2 * count - 1
                               : state.encoding == nrrdEncodingHex   ? 2 * bytes
                                                                     : 0;
    if (least > stored)
        refuse(path, fmt::format("{} of {} need at least {} bytes as {}, and {} has {}", textOf(size),
                                 typeName(nrrd.type), least, state.encoding->name, file, stored));
    if (least == 0) checkRatio(stored, bytes, path);
}

/// Sets steps and origin: from "space directions" if there are any, else from spacings along the axes.
void place(const Nrrd& nrrd, Scan& scan) {
    for (int axis = 0; axis < 3; ++axis) {
        const NrrdAxisInfo& info = nrrd.axis[axis];
        const bool directed = nrrd.spaceDim == 3 && std::isfinite(info.spaceDirection[0]);
        for (int row = 0; row < 3; ++row) {
            const double along = std::isfinite(info.spacing) && info.spacing != 0 ? std::abs(info.spacing) : 1;
            scan.axes[axis][row] = directed ? info.spaceDirection[row] : row == axis ? along : 0;
        }
    }
    for (int row = 0; row < 3; ++row)
        if (nrrd.spaceDim == 3 && std::isfinite(nrrd.spaceOrigin[row])) scan.origin[row] = nrrd.spaceOrigin[row];
}

}  // namespace

Scan readNrrd(const std::string& path) {
    fileBytes(path);
    // Teem would also accept pictures and other formats, which it recognises by their first bytes.
    std::string magic(4, '\0');
    std::ifstream(path, std::ios::binary).read(magic.data(), 4);
    if (magic != "NRRD") refuse(path, "is not an NRRD file: it does not begin with 'NRRD'");

    static std::mutex mutex;  // Teem gathers the errors of all threads in one place
    const std::lock_guard lock(mutex);
    const NrrdOwner header(nrrdNew());
    const StateOwner state(nrrdIoStateNew());
    state->skipData = AIR_TRUE;
    std::string text = mended(path);
    load(header.get(), state.get(), path, text);
    checkFolder(*state, path);
    if (header->dim != 3) refuse(path, fmt::format("has {} dimensions, expected 3", header->dim));
    if (header->type == nrrdTypeBlock || nrrdTypeSize[header->type] == 0)
        refuse(path, fmt::format("holds samples of type '{}', expected numbers", typeName(header->type)));
    checkBytes(*header, *state, path);

    const NrrdOwner nrrd(nrrdNew());
    load(nrrd.get(), nullptr, path, text);
    Scan scan;
    for (std::size_t axis = 0; axis < 3; ++axis) scan.size[axis] = static_cast<std::int64_t>(nrrd->axis[axis].size);
    place(*nrrd, scan);
    scan.type = sampleTypeOf(nrrd->type);
    if (nrrd->space != nrrdSpaceUnknown) scan.space = airEnumStr(nrrdSpace, nrrd->space);
    scan.values.resize(static_cast<std::size_t>(sampleCount(scan.size, path)));
    const auto sample = nrrdFLookup[nrrd->type];
    for (std::size_t i = 0; i < scan.values.size(); ++i) scan.values[i] = sample(nrrd->data, i);
    return scan;
}

}  // namespace scan
