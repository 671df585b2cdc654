// SPDX-License-Identifier: Apache-2.0
// Reads what a scene does to the grids of a volume: clip, resample, and expressions in OpenVDB AX.
#include <scrim/scene/read_sections.h>
#include <scrim/volume/grid_edit.h>

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace scrim {
namespace {

const VolumeKeys& k = keysOf<VolumeKeys>();

constexpr std::uintmax_t kLongestCode = std::uintmax_t{1} << 20;  ///< bytes of a file of code

/// External variables that need no parameter.
const std::string kFrame = k.frame.name, kTime = "time", kSeed = keysOf<NoiseKeys>().seed.name;

std::string readCodeFile(const TomlValue& value, const std::string& path) {
    std::error_code error;
    if (!std::filesystem::exists(path, error)) value.fail(fmt::format("there is no file '{}'", path));
    if (!std::filesystem::is_regular_file(path, error)) value.fail(fmt::format("'{}' is not a file", path));
    if (std::filesystem::file_size(path, error) > kLongestCode)
        value.fail(fmt::format("'{}' is larger than 1 MB; expected code in OpenVDB AX", path));
    std::ifstream file(path, std::ios::binary);
    std::string text{std::istreambuf_iterator<char>(file), {}};
    if (!file) value.fail(fmt::format("'{}' cannot be read", path));
    if (text.find('\0') != std::string::npos) value.fail(fmt::format("'{}' is not text", path));
    return text;
}

std::optional<AxCode> readCode(TomlTable& table, const ReadContext& context) {
    if (const auto text = table.find(k.ax)) {
        const TextPlace place = text->textPlace();
        return AxCode{text->string(), text->where(), place.file, place.line, place.column};
    }
    const auto file = table.find(k.axFile);
    if (!file) return std::nullopt;
    const std::string path = context.path(*file).at(context.fileFrame());
    return AxCode{readCodeFile(*file, path), file->where(), path};
}

/// The value of a parameter at the frame: a number, or three.
std::vector<double> readVariable(const TomlValue& value, double frame) {
    bool isNumber = false;
    const Keyed<Vec3> keyed = value.keysOf<Vec3>([&](const TomlValue& one) {
        isNumber = one.isNumber();
        if (!isNumber && !one.isArray()) one.failExpecting("a number or three numbers, which may be keyed");
        return isNumber ? Vec3(one.number(Range()), 0, 0) : one.vec3();
    });
    const Vec3 v = keyed.at(frame);
    return isNumber ? std::vector{v.x} : std::vector{v.x, v.y, v.z};
}

/// The values of the variables that `code` mentions.
std::vector<AxVariable> readVariables(TomlTable& table, const ReadContext& context, const AxCode& code,
                                      const SceneVolume& volume) {
    std::vector<AxVariable> variables;
    const std::vector<std::string> mentioned = variablesIn(code.text);
    const auto mentions = [&](const std::string& name) {
        return std::find(mentioned.begin(), mentioned.end(), name) != mentioned.end();
    };
    if (mentions(kFrame)) variables.push_back({kFrame, {context.wholeFrame}});
    if (mentions(kTime)) variables.push_back({kTime, {context.wholeFrame / context.fps}});
    bool seeded = false;
    if (const auto parameters = table.find(k.parameters)) {
        TomlTable values = parameters->table(fmt::format("'{}' of {}", k.parameters.name, table.description()));
        for (const TomlValue& value : values.all()) {
            if (value.name() == kFrame || value.name() == kTime)
                value.fail(fmt::format("${} is the frame's own; expected a parameter of another name", value.name()));
            seeded = seeded || value.name() == kSeed;
            if (mentions(value.name()))
                variables.push_back({value.name(), readVariable(value, context.wholeFrame)});
            else if (volume.source.empty())
                value.fail(
                    fmt::format("the expression does not use '${0}'; expected it there, or no '{0}'", value.name()));
        }
    }
    if (mentions(kSeed) && !seeded) variables.push_back({kSeed, {0}});
    return variables;
}

Bounds readBox(const TomlValue& value) {
    const auto ends = value.items(2);
    const Bounds box{ends[0].vec3(), ends[1].vec3()};
    for (int i = 0; i < 3; ++i)
        if (!(box.lower[i] < box.upper[i]))
            value.failExpecting("two points, each coordinate of the second above that of the first");
    return box;
}

}  // namespace

std::vector<HalfSpace> readClip(TomlTable& table) {
    std::vector<HalfSpace> faces;
    if (const auto clip = table.find(k.clip)) {
        const Bounds box = readBox(*clip);
        for (int axis = 0; axis < 3; ++axis) {
            Vec3 normal(0);
            normal[axis] = 1;
            faces.push_back({normal, -box.lower[axis]});
            faces.push_back({-normal, box.upper[axis]});
        }
    }
    if (const auto plane = table.find(k.clipPlane)) {
        const auto parts = plane->items(4);
        const Vec3 outwards(parts[0].number(), parts[1].number(), parts[2].number());
        const double length = glm::length(outwards);
        if (!(length > 0)) plane->failExpecting("a normal [nx, ny, nz] that is not 0");
        faces.push_back({-outwards / length, parts[3].number() / length});
    }
    return faces;
}

std::vector<std::string> variablesOf(TomlTable& table, const ReadContext& context) {
    const auto code = readCode(table, context);
    return code ? variablesIn(code->text) : std::vector<std::string>();
}

std::shared_ptr<const GridEdit> readEdit(TomlTable& table, const ReadContext& context, const SceneVolume& volume) {
    GridEdit edit;
    const auto at = [&](const std::string& where) {
        if (edit.where.empty()) edit.where = where;
    };
    // What moves into the box comes from outside.
    if (const auto clip = table.find(k.clip); clip && !volume.displacement && !volume.velocity) {
        edit.clip = readBox(*clip);
        at(clip->where());
    }
    if (const auto resample = table.find(k.resample)) {
        edit.resample = resample->number();
        at(resample->where());
    }
    if (auto code = readCode(table, context)) {
        at(code->where);
        edit.variables = readVariables(table, context, *code, volume);
        edit.programs.push_back(std::move(*code));
    }
    if (!edit.clip && edit.resample == 1 && edit.programs.empty()) return nullptr;
    edit.density = volume.densityGrid;
    return std::make_shared<const GridEdit>(std::move(edit));
}

}  // namespace scrim
