// SPDX-License-Identifier: Apache-2.0
#include "support/point_make.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <sstream>

#include <openvdb/io/File.h>
#include <openvdb/openvdb.h>
#include <openvdb/points/PointAttribute.h>
#include <openvdb/points/PointConversion.h>

namespace scrim::test {
namespace {

openvdb::Vec3s vectorOf(const Vec3& v) {
    return openvdb::Vec3s(openvdb::Vec3d(v.x, v.y, v.z));
}

template <typename Value, typename Of>
void addAttribute(openvdb::points::PointDataGrid& grid, const openvdb::tools::PointIndexGrid& index,
                  const std::string& name, const std::vector<MadePoint>& points, const Of& of) {
    std::vector<Value> values;
    for (const MadePoint& point : points) values.push_back(of(point));
    openvdb::points::appendAttribute<Value>(grid.tree(), name);
    openvdb::points::populateAttribute(grid.tree(), index.tree(), name,
                                       openvdb::points::PointAttributeVector<Value>(values));
}

}  // namespace

void makePointsVdb(const std::string& path, const std::vector<MadePoint>& points, const std::string& name,
                   double voxel) {
    using openvdb::points::PointDataGrid;
    openvdb::initialize();
    std::vector<openvdb::Vec3s> places;
    for (const MadePoint& point : points) places.push_back(vectorOf(point.at));
    const openvdb::points::PointAttributeVector<openvdb::Vec3s> wrapped(places);
    const auto transform = openvdb::math::Transform::createLinearTransform(voxel);
    const auto index = openvdb::tools::createPointIndexGrid<openvdb::tools::PointIndexGrid>(wrapped, *transform);
    const auto grid =
        openvdb::points::createPointDataGrid<openvdb::points::NullCodec, PointDataGrid>(*index, wrapped, *transform);
    grid->setName(name);
    addAttribute<float>(*grid, *index, "pscale", points, [](const auto& p) { return static_cast<float>(p.radius); });
    addAttribute<openvdb::Vec3s>(*grid, *index, "v", points, [](const auto& p) { return vectorOf(p.velocity); });
    addAttribute<openvdb::Vec3s>(*grid, *index, "Cd", points, [](const auto& p) { return vectorOf(p.colour); });
    openvdb::io::File(path).write({grid});
}

std::string plyOf(const std::vector<MadePoint>& points, const std::string& format) {
    std::ostringstream out;
    out << "ply\nformat " << format << " 1.0\ncomment made\nelement vertex " << points.size() << "\n";
    for (const char* name : {"x", "y", "z", "radius", "vx", "vy", "vz"}) out << "property float " << name << "\n";
    for (const char* name : {"red", "green", "blue"}) out << "property uchar " << name << "\n";
    out << "end_header\n";
    const bool text = format == "ascii", big = format == "binary_big_endian";
    const auto add = [&](double value) {
        if (text) {
            out << static_cast<float>(value) << ' ';
            return;
        }
        auto bytes = std::bit_cast<std::array<char, sizeof(float)>>(static_cast<float>(value));
        if (big) std::reverse(bytes.begin(), bytes.end());
        out.write(bytes.data(), bytes.size());
    };
    for (const MadePoint& p : points) {
        for (const double value : {p.at.x, p.at.y, p.at.z, p.radius, p.velocity.x, p.velocity.y, p.velocity.z})
            add(value);
        for (const double value : {p.colour.x, p.colour.y, p.colour.z}) {
            const int byte = static_cast<int>(255 * value);
            if (text)
                out << byte << ' ';
            else
                out << static_cast<char>(byte);
        }
        if (text) out << '\n';
    }
    return out.str();
}

}  // namespace scrim::test
