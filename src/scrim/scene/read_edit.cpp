// SPDX-License-Identifier: Apache-2.0
// Reads what a scene does to the grids of a volume: grids from several files, clip, resample, and
// expressions in OpenVDB AX.
#include <scrim/scene/read_sections.h>

#include <scrim/base/letter_case.h>

#include <fmt/format.h>

#include <algorithm>
#include <filesystem>

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
    std::string text = located(value, [&] { return axFileText(path); });
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
            if (mentions(value.name())) {
                variables.push_back({value.name(), readVariable(value, context.wholeFrame)});
                if (!variables.back().isFinite()) value.failExpecting("numbers that fit into floats");
            } else if (volume.source.empty()) {
                context.warnings->push_back(fmt::format("{}: the expression does not use '${}', which changes nothing",
                                                        value.where(), value.name()));
            }
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

/// Reads "FILE" or "FILE:GRID".
CombinedGrid::Part readPart(const TomlValue& value, const ReadContext& context, std::vector<FramePath>& sequences) {
    const std::string text = value.string();
    const std::string name = lowerCase(text);
    const std::size_t colon = name.ends_with(".vdb") || name.ends_with(".nvdb") ? std::string::npos : text.rfind(':');
    const std::string file = text.substr(0, colon);
    CombinedGrid::Part part{0, colon == std::string::npos ? "" : text.substr(colon + 1), value.where()};
    if (file.empty() || (colon != std::string::npos && part.grid.empty()))
        value.failExpecting("\"FILE\" or \"FILE:GRID\"");
    const FramePath path = context.path(value, file);
    const auto known = std::find_if(sequences.begin(), sequences.end(),
                                    [&](const FramePath& other) { return other.pattern == path.pattern; });
    part.file = static_cast<std::size_t>(known - sequences.begin());
    if (known == sequences.end()) sequences.push_back(path);
    if (sequences.size() > kMostGridFiles)
        value.fail(fmt::format("there are more than {} files; expected fewer", kMostGridFiles));
    return part;
}

CombinedGrid readGrid(const TomlValue& value, const ReadContext& context, std::vector<FramePath>& sequences) {
    CombinedGrid grid{value.name(), CombinedGrid::How::copied, {}};
    if (value.isString()) {
        grid.parts.push_back(readPart(value, context, sequences));
        return grid;
    }
    const CombineKeys& c = keysOf<CombineKeys>();
    const std::string form = R"("FILE:GRID", or { max = [...] }, { add = [...] } or { multiply = [...] })";
    if (!value.isTable()) value.failExpecting(form);
    TomlTable table = value.table(fmt::format("'{}' of {}", value.name(), k.grids.name), &c);
    std::optional<TomlValue> list;
    for (const auto& [key, how] : {std::pair(&c.max, CombinedGrid::How::max), std::pair(&c.add, CombinedGrid::How::add),
                                   std::pair(&c.multiply, CombinedGrid::How::multiply)})
        if (const auto found = table.find(*key)) {
            list = found;
            grid.how = how;
        }
    table.finish();
    if (!list) value.failExpecting(form);
    for (const TomlValue& item : list->items(0)) grid.parts.push_back(readPart(item, context, sequences));
    if (grid.parts.size() < 2) list->failExpecting(c.max.form);
    return grid;
}

PointLook readPoints(TomlTable table, const ReadContext& context) {
    const PointsKeys& p = keysOf<PointsKeys>();
    PointLook look;
    table.read(p, context.frame, look);
    if (const auto radius = table.find(p.radius)) look.radius = radius->number();
    if (const auto voxel = table.find(p.voxel)) look.voxel = voxel->number();
    if (const auto sharp = table.find(p.sharp)) look.sharp = sharp->boolean();
    table.finish();
    return look;
}

}  // namespace

std::vector<CombinedGrid> readGrids(const TomlValue& value, const ReadContext& context,
                                    std::vector<FramePath>& sequences) {
    std::vector<CombinedGrid> grids;
    if (!value.isTable()) value.failExpecting(k.grids.form);
    for (const TomlValue& grid : value.table(fmt::format("{}", k.grids), nullptr).all())
        grids.push_back(readGrid(grid, context, sequences));
    if (grids.empty()) value.failExpecting("at least one grid");
    return grids;
}

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

namespace {

/// Reads by how much voxels are divided for the shading of the density; 0 stands for "auto".
int readDetail(TomlTable& table, const SceneVolume& volume) {
    const DensityKeys& d = keysOf<DensityKeys>();
    const auto detail = table.find(k.detail);
    if (!detail) return 1;
    const bool isWord = detail->isString();
    if (isWord ? detail->string() != "auto" : !detail->isNumber()) detail->failExpecting(k.detail.form);
    const int times = isWord ? 0 : detail->integer();
    if (!isWord && times != 1 && times != 2 && times != 4 && times != 8) detail->failExpecting(k.detail.form);
    const bool noise = volume.displacement || volume.shading.noise;
    if (times == 0 && !noise)
        detail->fail(
            fmt::format("{} is \"auto\", and the volume has no noise to follow; expected {} or {} of {} beside "
                        "it, or a number",
                        k.detail, k.displacement, d.noise, k.density));
    if (times != 1 && !noise && !volume.shading.any() && volume.ramp.empty())
        detail->fail(
            fmt::format("{} needs shading, which it evaluates between voxels; expected {}, or {}, {}, {}, {} or "
                        "{} of {} beside it",
                        k.detail, k.displacement, d.noise, d.edge, d.remap, d.mask, d.ramp, k.density));
    return times;
}

}  // namespace

std::shared_ptr<const GridEdit> readEdit(TomlTable& table, const ReadContext& context, const SceneVolume& volume) {
    GridEdit edit = volume.edit ? *volume.edit : GridEdit();
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
    if (const auto points = table.find(k.points))
        edit.points = readPoints(points->table(fmt::format("{} of {}", k.points, table.description())), context);
    edit.detail = readDetail(table, volume);
    if (!edit.changesGrids() && edit.detail == 1) return nullptr;
    edit.density = volume.densityGrid;
    return std::make_shared<const GridEdit>(std::move(edit));
}

}  // namespace scrim
