// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/grid_edit.h>

#include <scrim/base/error.h>
#include <scrim/base/open_file.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <string_view>

namespace scrim {
namespace {

using Json = nlohmann::ordered_json;

Json toJson(const Vec3& v) {
    return {v.x, v.y, v.z};
}

Vec3 vectorFrom(const Json& j) {
    return {j.at(0).get<double>(), j.at(1).get<double>(), j.at(2).get<double>()};
}

Json toJson(const CombinedGrid& grid) {
    Json parts = Json::array();
    for (const CombinedGrid::Part& part : grid.parts)
        parts.push_back({{"file", part.file}, {"grid", part.grid}, {"where", part.where}});
    return {{"name", grid.name}, {"how", static_cast<int>(grid.how)}, {"parts", parts}};
}

CombinedGrid combinedGridFrom(const Json& j, std::size_t files) {
    CombinedGrid grid{j.at("name").get<std::string>(), static_cast<CombinedGrid::How>(j.at("how").get<int>()), {}};
    for (const Json& part : j.at("parts")) {
        grid.parts.push_back({part.at("file").get<std::size_t>(), part.at("grid").get<std::string>(),
                              part.at("where").get<std::string>()});
        if (grid.parts.back().file >= files)
            throw Error(ErrorKind::usage, "not an edit of grids: there is no such file");
    }
    if (grid.parts.empty()) throw Error(ErrorKind::usage, "not an edit of grids: a grid has no parts");
    return grid;
}

bool isNamePart(char c) {
    return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '_';
}

}  // namespace

bool AxVariable::isFinite() const {
    return std::all_of(value.begin(), value.end(), [](double v) { return std::isfinite(static_cast<float>(v)); });
}

std::string axFileText(const std::string& path) {
    constexpr std::string_view kMark = "\xef\xbb\xbf";
    std::string text = bytesOf(path);
    if (text.starts_with(kMark)) text.erase(0, kMark.size());
    return text;
}

std::string AxCode::placeOf(int axLine, int axColumn) const {
    if (file.empty()) return fmt::format("{}: line {}, column {}", where, axLine, axColumn);
    const std::string place =
        fmt::format("{}:{}:{}", file, line + axLine - 1, axLine == 1 ? column + axColumn - 1 : axColumn);
    return where.starts_with(file + ":") ? place : where + ": " + place;
}

std::string toText(const GridEdit& edit) {
    Json programs = Json::array(), variables = Json::array(), grids = Json::array();
    for (const CombinedGrid& grid : edit.grids) grids.push_back(toJson(grid));
    for (const AxCode& code : edit.programs)
        programs.push_back({{"text", code.text},
                            {"where", code.where},
                            {"file", code.file},
                            {"line", code.line},
                            {"column", code.column}});
    for (const AxVariable& variable : edit.variables)
        variables.push_back({{"name", variable.name}, {"value", variable.value}});
    Json out{{"grids", grids},       {"files", edit.files},    {"resample", edit.resample}, {"density", edit.density},
             {"programs", programs}, {"variables", variables}, {"where", edit.where}};
    const PointLook& look = edit.points;
    if (look != PointLook())
        out["points"] = {look.radius,
                         look.scale,
                         look.voxel,
                         look.discs ? 1.0 : 0.0,
                         look.open,
                         look.close,
                         look.sharp ? (*look.sharp ? 1.0 : 0.0) : -1.0};
    if (edit.clip) out["clip"] = {toJson(edit.clip->lower), toJson(edit.clip->upper)};
    return out.dump(-1, ' ', false, Json::error_handler_t::replace);
}

GridEdit gridEditFrom(const std::string& text) {
    try {
        const Json j = Json::parse(text);
        GridEdit edit;
        edit.files = j.at("files").get<std::vector<std::string>>();
        for (const Json& grid : j.at("grids")) edit.grids.push_back(combinedGridFrom(grid, edit.files.size()));
        if (j.contains("clip")) edit.clip = Bounds{vectorFrom(j.at("clip").at(0)), vectorFrom(j.at("clip").at(1))};
        if (j.contains("points")) {
            const auto at = [&](std::size_t i) { return j.at("points").at(i).get<double>(); };
            edit.points = {at(0), at(1), at(2), at(3) != 0, {}, at(4), at(5)};
            if (at(6) >= 0) edit.points.sharp = at(6) > 0;
        }
        edit.resample = j.at("resample").get<double>();
        edit.density = j.at("density").get<std::string>();
        edit.where = j.at("where").get<std::string>();
        for (const Json& code : j.at("programs"))
            edit.programs.push_back({code.at("text").get<std::string>(), code.at("where").get<std::string>(),
                                     code.at("file").get<std::string>(), code.at("line").get<int>(),
                                     code.at("column").get<int>()});
        for (const Json& variable : j.at("variables"))
            edit.variables.push_back(
                {variable.at("name").get<std::string>(), variable.at("value").get<std::vector<double>>()});
        return edit;
    } catch (const nlohmann::json::exception& error) {
        throw Error(ErrorKind::usage, shortened(std::string("not an edit of grids: ") + error.what()));
    }
}

std::vector<std::string> variablesIn(const std::string& code) {
    std::vector<std::string> names;
    for (std::size_t at = code.find('$'); at != std::string::npos; at = code.find('$', at)) {
        const std::size_t begin = ++at;
        while (at < code.size() && isNamePart(code[at])) ++at;
        const std::string name = code.substr(begin, at - begin);
        if (!name.empty() && std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
    }
    return names;
}

}  // namespace scrim
