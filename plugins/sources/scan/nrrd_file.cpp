// SPDX-License-Identifier: Apache-2.0
// Reads NRRD with Teem, in two passes: the header alone first, so that its declarations can be compared with the file's
// size before anything is allocated.
#include "scan.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cctype>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <mutex>
#include <optional>
#include <sstream>
#include <string_view>
#include <utility>

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

/// The three-dimensional part of a space that a header names.
struct Space {
    std::string name;         ///< after what is left-handed has been turned: "right-anterior-superior"
    bool leftHanded = false;  ///< the world is not, so that its first axis is turned round
};

/// The space of a header's line: one of anatomy, of which there are eight ("left-anterior-superior", "LAS", and the
/// same with time), or one that is only left- or right-handed; none where `text` is anything else.
std::optional<Space> spaceNamed(std::string text) {
    constexpr std::array<std::array<std::string_view, 2>, 3> kWords{
        {{"right", "left"}, {"anterior", "posterior"}, {"superior", "inferior"}}};
    text = lowerCase(std::move(text));
    std::erase_if(text, [](char c) { return c == '-' || c == ' '; });
    if (text == "3dlefthanded" || text == "3dlefthandedtime" || text == "3dl" || text == "3dlt")
        return Space{"3D-right-handed", true};
    for (unsigned n = 0; n < 8; ++n) {
        std::string words, letters, name;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            const std::string_view word = kWords[axis][n >> axis & 1];
            words += word;
            letters += word.front();
            // Each step away from right, anterior, superior changes the handedness.
            const unsigned turned = axis == 0 && std::popcount(n) % 2 == 1 ? 1 : 0;
            name += std::string(axis == 0 ? "" : "-") + std::string(kWords[axis][(n >> axis & 1) ^ turned]);
        }
        for (const std::string& known : {words, words + "time", letters, letters + "t"})
            if (text == known) return Space{name, std::popcount(n) % 2 == 1};
    }
    return {};
}

void checkFolder(const NrrdIoState& state, const std::string& path) {
    for (unsigned i = 0; i < state.dataFNArr->len; ++i) checkWithin(state.dataFN[i], path);
}

/// The text of a header, and what Scrim itself must know of it.
class Header {
  public:
    explicit Header(const std::string& path) : m_path(path) {
        constexpr std::streamsize kMost = 65536;
        std::ifstream file(path, std::ios::binary);
        m_text.resize(kMost);
        file.read(m_text.data(), kMost);
        m_text.resize(static_cast<std::size_t>(file.gcount()));
        const std::size_t blank = std::min(m_text.find("\n\n"), m_text.find("\n\r\n"));
        m_ends = blank != std::string::npos;
        m_text.resize(m_ends ? blank + 1 : m_text.size());
        m_detached = valueOf("data file") || valueOf("datafile");
        // Teem would take samples for a field, and end the process where that has too many numbers.
        if (!m_ends && !m_detached) refuse(path, "damaged: its header has no end, which is an empty line");
    }

    /// The value of a field, without the spaces around it; none where the header lacks it.
    std::optional<std::string> valueOf(std::string_view field) const {
        const auto [begin, end] = lineOf(field);
        if (begin == end) return {};
        std::string value = m_text.substr(begin + field.size() + 1, end - begin - field.size() - 1);
        while (!value.empty() && std::isspace(static_cast<unsigned char>(value.back()))) value.pop_back();
        value.erase(0, std::min(value.find_first_not_of(" \t"), value.size()));
        return value;
    }

    /// The file as Teem reads it, with the samples if they are in it; empty: as it is. Teem knows three of the eight
    /// spaces of anatomy, and needs the dimension of space before the first direction, which some writers leave out.
    std::string mended() const {
        const auto [begin, end] = lineOf("space");
        const bool unknown = begin != end && spaceNamed(*valueOf("space")) && !knownToTeem(*valueOf("space"));
        const bool lacking = begin == end && valueOf("space directions") && !valueOf("space dimension");
        if ((!unknown && !lacking) || (!m_ends && !m_detached)) return "";
        std::string text = m_text;
        if (unknown) text.erase(begin, end - begin);
        text.insert(text.find('\n') + 1, "space dimension: 3\n");
        if (m_detached) return text + "\n";
        std::ifstream file(m_path, std::ios::binary);
        file.seekg(static_cast<std::streamoff>(m_text.size()));
        std::ostringstream rest;
        rest << file.rdbuf();
        return text + std::move(rest).str();
    }

  private:
    static bool knownToTeem(const std::string& space) {
        return airEnumVal(nrrdSpace, space.c_str()) != nrrdSpaceUnknown;
    }
    /// Begin and end, with its line break, of the line "`field`: ...".
    std::pair<std::size_t, std::size_t> lineOf(std::string_view field) const {
        for (std::size_t begin = 0; begin < m_text.size();) {
            const std::size_t end = std::min(m_text.find('\n', begin), m_text.size() - 1) + 1;
            const std::string line = lowerCase(m_text.substr(begin, end - begin));
            // "key:=value" is no field.
            if (line.starts_with(field) && line.size() > field.size() + 1 && line[field.size()] == ':' &&
                line[field.size() + 1] != '=')
                return {begin, end};
            begin = end;
        }
        return {0, 0};
    }

    std::string m_path, m_text;
    bool m_ends = false, m_detached = false;
};

/// The file that holds the samples: `path` itself, or the one its header names.
std::string dataFile(const NrrdIoState& state, const std::string& path) {
    if (state.dataFNFormat != nullptr || state.dataFNArr->len > 1)
        refuse(path, fmt::format("its samples are in several files, expected one; join them (unu save -f nrrd -i {} -o "
                                 "WHOLE.nrrd does, or 3D Slicer)",
                                 std::filesystem::path(path).filename().string().substr(0, 200)));
    if (state.dataFNArr->len == 0) return path;
    // The folder is used as it was named: "a/../b" is not "b" where a is a link.
    const std::filesystem::path name = std::filesystem::path(state.dataFN[0]).lexically_normal();
    return (std::filesystem::path(path).parent_path() / name).string();
}

bool loaded(Nrrd* nrrd, NrrdIoState* state, const std::string& path, std::string& mendedText) {
    if (mendedText.empty()) return nrrdLoad(nrrd, path.c_str(), state) == 0;
    std::FILE* const file = fmemopen(mendedText.data(), mendedText.size(), "rb");
    if (file == nullptr) refuse(path, "not enough memory to read it");
    const StateOwner own(state == nullptr ? nrrdIoStateNew() : nullptr);
    NrrdIoState* const used = state == nullptr ? own.get() : state;
    // Teem looks for detached samples here.
    used->path = airStrdup(std::filesystem::path(path).parent_path().string().c_str());
    const bool done = nrrdRead(nrrd, file, used) == 0;
    std::fclose(file);
    return done;
}

void load(Nrrd* nrrd, NrrdIoState* state, const std::string& path, std::string& mendedText) {
    if (loaded(nrrd, state, path, mendedText)) return;
    const std::string reason = teemError();
    if (state != nullptr) {
        checkFolder(*state, path);
        dataFile(*state, path);
    }
    refuse(path, reason);
}

std::string typeName(int type) {
    return airEnumStr(nrrdType, type);
}

/// The axes of a header: three of space, and perhaps one that counts volumes or the parts of vectors.
struct Axes {
    std::array<unsigned, 3> space{0, 1, 2};
    unsigned component = 3;
    std::int64_t components = 1;
    Size size{};
    bool hasColours = false;  ///< the components are red, green and blue
};

/// The type of samples as the other readers name it; none where it is no number.
std::optional<SampleType> typeOf(int type) {
    using enum SampleType;
    constexpr std::array kTypes{int8, uint8, int16, uint16, int32, uint32, int64, uint64, float32, float64};
    if (type < nrrdTypeChar || type > nrrdTypeDouble) return {};
    return kTypes[static_cast<std::size_t>(type - nrrdTypeChar)];
}

/// True if an axis holds the parts of colours: by its kind, or as the first axis, without a kind, of pictures.
bool holdsColours(const Nrrd& nrrd, unsigned axis) {
    const int kind = nrrd.axis[axis].kind;
    if (nrrd.dim != 4 || nrrd.axis[axis].size != 3) return false;
    if (kind == nrrdKindRGBColor || kind == nrrdKind3Color) return true;
    const bool isPicture = nrrd.type == nrrdTypeUChar || nrrd.type == nrrdTypeUShort || nrrd.type == nrrdTypeFloat;
    return axis == 0 && kind == nrrdKindUnknown && isPicture;
}

/// The axis that is none of space: one without a direction beside three that have one, one whose kind says so, or the
/// last.
Axes axesOf(const Nrrd& nrrd, const std::string& path) {
    if (nrrd.dim != 3 && nrrd.dim != 4) refuse(path, fmt::format("has {} dimensions, expected 3 or 4", nrrd.dim));
    Axes axes;
    if (nrrd.dim == 4) {
        int undirected = 0;
        for (unsigned i = 4; i-- > 0;) {
            const NrrdAxisInfo& axis = nrrd.axis[i];
            if (axis.kind != nrrdKindUnknown && (!nrrdKindIsDomain(axis.kind) || axis.kind == nrrdKindTime))
                axes.component = i;
        }
        for (unsigned i = 0; i < 4 && nrrd.spaceDim == 3; ++i)
            if (!std::isfinite(nrrd.axis[i].spaceDirection[0])) undirected += 1, axes.component = i;
        const bool isStated = undirected > 0 || axes.component != 3 || nrrd.axis[3].kind != nrrdKindUnknown;
        if (!isStated && holdsColours(nrrd, 0)) axes.component = 0;
        axes.hasColours = holdsColours(nrrd, axes.component);
        if (undirected > 1) refuse(path, fmt::format("{} of its 4 axes have no direction, expected one", undirected));
        axes.components = static_cast<std::int64_t>(nrrd.axis[axes.component].size);
        for (unsigned i = 0, k = 0; i < 4; ++i)
            if (i != axes.component) axes.space[k++] = i;
    }
    for (std::size_t k = 0; k < 3; ++k) axes.size[k] = static_cast<std::int64_t>(nrrd.axis[axes.space[k]].size);
    return axes;
}

/// Refuses a header whose samples cannot be in the file.
void checkBytes(const Nrrd& nrrd, const Axes& axes, const NrrdIoState& state, const std::string& path) {
    const Size& size = axes.size;
    const std::int64_t one = sampleCount(size, path);
    const std::int64_t count = sampleCount({one, axes.components, 1}, path);
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
void place(const Nrrd& nrrd, const Axes& axes, const std::optional<Space>& space, Scan& scan) {
    const bool spatial = nrrd.spaceDim == 3 || nrrd.spaceDim == 4;  // the fourth is time
    for (int axis = 0; axis < 3; ++axis) {
        const NrrdAxisInfo& info = nrrd.axis[axes.space[static_cast<std::size_t>(axis)]];
        const bool directed = spatial && std::isfinite(info.spaceDirection[0]);
        for (int row = 0; row < 3; ++row) {
            const double along = std::isfinite(info.spacing) && info.spacing != 0 ? std::abs(info.spacing) : 1;
            scan.axes[axis][row] = directed ? info.spaceDirection[row] : row == axis ? along : 0;
        }
    }
    for (int row = 0; row < 3; ++row)
        if (spatial && std::isfinite(nrrd.spaceOrigin[row])) scan.origin[row] = nrrd.spaceOrigin[row];
    scan.space = space ? space->name : nrrd.space != nrrdSpaceUnknown ? airEnumStr(nrrdSpace, nrrd.space) : "";
    if (!space || !space->leftHanded) return;
    for (int axis = 0; axis < 3; ++axis) scan.axes[axis][0] = -scan.axes[axis][0];
    scan.origin[0] = -scan.origin[0];
}

}  // namespace

Scan readNrrd(const std::string& path, std::int64_t component) {
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
    const Header own(path);
    std::string text = own.mended();
    load(header.get(), state.get(), path, text);
    checkFolder(*state, path);
    const Axes axes = axesOf(*header, path);
    const bool hasColours = axes.hasColours && component < 0;
    if (!hasColours) checkComponent(component, axes.components, path);
    if (header->type == nrrdTypeBlock || nrrdTypeSize[header->type] == 0)
        refuse(path, fmt::format("holds samples of type '{}', expected numbers", typeName(header->type)));
    checkBytes(*header, axes, *state, path);

    const NrrdOwner nrrd(nrrdNew());
    load(nrrd.get(), nullptr, path, text);
    Scan scan;
    scan.size = axes.size;
    const std::optional<std::string> space = own.valueOf("space");
    place(*nrrd, axes, space ? spaceNamed(*space) : std::nullopt, scan);
    const SampleType type = typeOf(nrrd->type).value_or(SampleType::float64);
    scan.type = hasColours ? colourTypeOf(type) : nameOf(type);
    const auto sample = nrrdFLookup[nrrd->type];
    std::array<std::size_t, 5> stride{1, 1, 1, 1, 1};
    for (unsigned i = 0; i < nrrd->dim; ++i) stride[i + 1] = stride[i] * nrrd->axis[i].size;
    const std::size_t part = stride[axes.component],
                      first = static_cast<std::size_t>(std::max<std::int64_t>(component, 0)) * part;
    const std::array<std::size_t, 3> step{stride[axes.space[0]], stride[axes.space[1]], stride[axes.space[2]]};
    std::vector<float> all;
    all.reserve(static_cast<std::size_t>(sampleCount(scan.size, path)) * (hasColours ? 3 : 1));
    for (std::size_t z = 0; z < nrrd->axis[axes.space[2]].size; ++z)
        for (std::size_t y = 0; y < nrrd->axis[axes.space[1]].size; ++y)
            for (std::size_t x = 0; x < nrrd->axis[axes.space[0]].size; ++x)
                for (std::size_t c = 0; c < (hasColours ? 3 : 1); ++c)
                    all.push_back(sample(nrrd->data, first + c * part + x * step[0] + y * step[1] + z * step[2]));
    if (hasColours)
        addColours(all, type, scan);
    else
        scan.values = std::move(all);
    return scan;
}

}  // namespace scan
