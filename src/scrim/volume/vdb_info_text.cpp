// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/vdb_info_text.h>

#include <scrim/base/error.h>

#include <nlohmann/json.hpp>

namespace scrim {

namespace {

using nlohmann::json;

json vector(const Vec3& v) {
    return json::array({v.x, v.y, v.z});
}
json vector(const Int3& v) {
    return json::array({v.x, v.y, v.z});
}

template <typename Vector>
Vector vectorFrom(const json& j) {
    using Part = typename Vector::value_type;
    return Vector(j.at(0).get<Part>(), j.at(1).get<Part>(), j.at(2).get<Part>());
}

/// A matrix row by row, as in all text.
json matrix(const Mat4& m) {
    json rows = json::array();
    for (int row = 0; row < 4; ++row) rows.push_back({m[0][row], m[1][row], m[2][row], m[3][row]});
    return rows;
}

Mat4 matrixFrom(const json& j) {
    Mat4 m;
    for (int row = 0; row < 4; ++row)
        for (int column = 0; column < 4; ++column)
            m[column][row] = j.at(std::size_t(row)).at(std::size_t(column)).get<double>();
    return m;
}

json grid(const GridInfo& g) {
    return {{"name", g.name},
            {"type", g.valueType},
            {"class", g.gridClass},
            {"codec", g.codec},
            {"saved_as_half", g.savedAsHalf},
            {"active_voxels", g.activeVoxels},
            {"active_tiles", g.activeTiles},
            {"voxel_size", vector(g.voxelSize)},
            {"affine", g.affine},
            {"world_from_index", matrix(g.wsFromIs)},
            {"index_lower", vector(g.isLower)},
            {"index_upper", vector(g.isUpper)},
            {"min_value", g.minValue},
            {"max_value", g.maxValue},
            {"non_finite", g.nonFinite},
            {"negative", g.negative},
            {"usable", g.usable},
            {"problem", g.problem},
            {"points", g.points},
            {"attributes", g.attributes},
            {"world_lower", vector(g.wsLower)},
            {"world_upper", vector(g.wsUpper)},
            {"colour", g.colour}};
}

GridInfo gridFrom(const json& j) {
    GridInfo g;
    j.at("name").get_to(g.name);
    j.at("type").get_to(g.valueType);
    j.at("class").get_to(g.gridClass);
    j.at("codec").get_to(g.codec);
    j.at("saved_as_half").get_to(g.savedAsHalf);
    j.at("active_voxels").get_to(g.activeVoxels);
    j.at("active_tiles").get_to(g.activeTiles);
    g.voxelSize = vectorFrom<Vec3>(j.at("voxel_size"));
    j.at("affine").get_to(g.affine);
    g.wsFromIs = matrixFrom(j.at("world_from_index"));
    g.isLower = vectorFrom<Int3>(j.at("index_lower"));
    g.isUpper = vectorFrom<Int3>(j.at("index_upper"));
    j.at("min_value").get_to(g.minValue);
    j.at("max_value").get_to(g.maxValue);
    j.at("non_finite").get_to(g.nonFinite);
    j.at("negative").get_to(g.negative);
    j.at("usable").get_to(g.usable);
    j.at("problem").get_to(g.problem);
    j.at("points").get_to(g.points);
    j.at("attributes").get_to(g.attributes);
    g.wsLower = vectorFrom<Vec3>(j.at("world_lower"));
    g.wsUpper = vectorFrom<Vec3>(j.at("world_upper"));
    j.at("colour").get_to(g.colour);
    return g;
}

}  // namespace

std::string toJson(const VdbFileInfo& info) {
    json metadata = json::array();
    for (const auto& [key, value] : info.metadata) metadata.push_back({key, value});
    json grids = json::array();
    for (const GridInfo& g : info.grids) grids.push_back(grid(g));
    const json all = {{"path", info.path},
                      {"file_version", info.fileVersion},
                      {"library_version", {info.libraryMajor, info.libraryMinor}},
                      {"nanovdb", info.isNano},
                      {"point_format", info.pointFormat},
                      {"file_bytes", info.fileBytes},
                      {"metadata", metadata},
                      {"grids", grids}};
    return all.dump(-1, ' ', /*ensure_ascii=*/false, json::error_handler_t::replace);
}

VdbFileInfo vdbFileInfoFromJson(const std::string& text) {
    try {
        const json all = json::parse(text);
        VdbFileInfo info;
        all.at("path").get_to(info.path);
        all.at("file_version").get_to(info.fileVersion);
        all.at("library_version").at(0).get_to(info.libraryMajor);
        all.at("nanovdb").get_to(info.isNano);
        all.at("point_format").get_to(info.pointFormat);
        all.at("library_version").at(1).get_to(info.libraryMinor);
        all.at("file_bytes").get_to(info.fileBytes);
        for (const json& entry : all.at("metadata"))
            info.metadata.emplace_back(entry.at(0).get<std::string>(), entry.at(1).get<std::string>());
        for (const json& entry : all.at("grids")) info.grids.push_back(gridFrom(entry));
        return info;
    } catch (const json::exception& error) {
        throw Error(ErrorKind::input, shortened(std::string("not a file description: ") + error.what()));
    }
}

}  // namespace scrim
