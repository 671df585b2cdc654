// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/point_grid.h>

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/geometry/bounds.h>
#include <scrim/volume/openvdb_field.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <memory>

#include <fmt/format.h>
#include <openvdb/points/PointDataGrid.h>

namespace scrim {
namespace {

using openvdb::points::AttributeArray;
using openvdb::points::PointDataGrid;
using openvdb::points::UnknownCodec;
using Leaf = PointDataGrid::TreeType::LeafNodeType;

/// Attributes that tell how large and how dense a point is.
bool isOwn(const std::string& name) {
    for (const char* own : {"pscale", "radius", "width", "widths", "density"})
        if (name == own) return true;
    return false;
}

/// Appends the values of a leaf's points to `out`.
using Append = std::function<void(const Leaf&, const AttributeArray&, std::vector<float>& out)>;

template <typename Value>
Append appending() {
    return [](const Leaf& leaf, const AttributeArray& array, std::vector<float>& out) {
        const openvdb::points::AttributeHandle<Value, UnknownCodec> values(array);
        for (auto i = leaf.beginIndexOn(); i; ++i) {
            const Value value = values.get(*i);
            if constexpr (openvdb::VecTraits<Value>::IsVec)
                for (int c = 0; c < 3; ++c) out.push_back(static_cast<float>(value[c]));
            else
                out.push_back(static_cast<float>(value));
        }
    };
}

struct Type {
    int width;
    Append append;
};

/// The readers of types, by OpenVDB's word for them.
const std::map<std::string, Type>& typesOf() {
    static const std::map<std::string, Type> types{
        {"float", {1, appending<float>()}},
        {"double", {1, appending<double>()}},
        {"half", {1, appending<openvdb::math::half>()}},
        {"int32", {1, appending<std::int32_t>()}},
        {"vec3s", {3, appending<openvdb::Vec3f>()}},
        {"vec3d", {3, appending<openvdb::Vec3d>()}},
    };
    return types;
}

/// Null for arrays of other types.
const Type* readerOf(const AttributeArray& array) {
    const auto found = typesOf().find(array.valueType());
    return found == typesOf().end() || array.stride() != 1 ? nullptr : &found->second;
}

/// Refuses leaves whose voxels name points that their arrays do not hold.
void checkLeaf(const Leaf& leaf) {
    openvdb::Index before = 0;
    bool ascends = true;
    for (openvdb::Index i = 0; i < Leaf::SIZE; ++i) {
        const auto end = static_cast<openvdb::Index>(leaf.getValue(i));
        ascends = ascends && end >= before;
        before = end;
    }
    for (const auto& [name, place] : leaf.attributeSet().descriptor().map())
        ascends = ascends && leaf.constAttributeArray(place).size() == before;
    if (!ascends) throw Error(ErrorKind::input, "truncated or damaged: a voxel names points that are not there");
}

}  // namespace

bool isPointGrid(const openvdb::GridBase& grid) {
    return grid.isType<PointDataGrid>();
}

PointCloud pointsOf(const openvdb::GridBase& base, const std::function<bool(const std::string&)>& wanted) {
    const auto& grid = static_cast<const PointDataGrid&>(base);
    PointCloud cloud;
    cloud.name = grid.getName();
    const openvdb::Vec3d size = grid.transform().voxelSize();
    cloud.spacing = (size.x() + size.y() + size.z()) / 3;
    std::map<std::string, const Type*> known;
    bool first = true;
    for (const Leaf* const leaf : leavesOf(grid)) {
        checkLeaf(*leaf);
        const auto& set = leaf->attributeSet();
        if (first) {
            first = false;
            for (const auto& [name, place] : set.descriptor().map()) {
                const Type* const type = readerOf(*set.getConst(place));
                if (name == "P" || type == nullptr || (!isOwn(name) && !wanted(name))) continue;
                known[name] = type;
                cloud.attributes.push_back({name, type->width, {}});
            }
        }
        const AttributeArray* const places = set.getConst("P");
        if (places == nullptr || places->valueType() != "vec3s")
            throw Error(ErrorKind::input, "damaged: its points have no places ('P')");
        const openvdb::points::AttributeHandle<openvdb::Vec3f, UnknownCodec> at(*places);
        for (auto i = leaf->beginIndexOn(); i; ++i) {
            const openvdb::Vec3d ws = grid.transform().indexToWorld(at.get(*i) + i.getCoord().asVec3d());
            cloud.positions.emplace_back(ws.x(), ws.y(), ws.z());
        }
        for (PointAttribute& attribute : cloud.attributes) {
            const AttributeArray* const array = set.getConst(attribute.name);
            const Type& type = *known.at(attribute.name);
            if (array == nullptr || readerOf(*array) != &type)
                throw Error(ErrorKind::input, fmt::format("damaged: some of its points have another '{}'",
                                                          shortened(attribute.name, 80)));
            type.append(*leaf, *array, attribute.values);
        }
    }
    return cloud;
}

std::string attributesOf(const openvdb::GridBase& base) {
    std::string text;
    const auto leaf = static_cast<const PointDataGrid&>(base).tree().cbeginLeaf();
    if (!leaf) return text;
    const auto& set = leaf->attributeSet();
    std::map<std::string, std::string> all;
    for (const auto& [name, place] : set.descriptor().map()) all[name] = set.getConst(place)->valueType();
    all.erase("P");
    for (const auto& [name, type] : all)
        text += fmt::format("{}{} ({})", text.empty() ? "" : ", ", shortened(name, 80), shortened(type, 40));
    return text;
}

std::string attributesOf(const PointCloud& cloud) {
    std::string text;
    for (const PointAttribute& one : cloud.attributes)
        text += fmt::format("{}{} ({})", text.empty() ? "" : ", ", shortened(one.name, 80),
                            one.width == 3 ? "vec3s" : "float");
    return text;
}

void describePoints(const PointCloud& cloud, GridInfo& info) {
    info.points = cloud.positions.size();
    Bounds ws;
    for (const Vec3& at : cloud.positions)
        if (std::isfinite(at.x) && std::isfinite(at.y) && std::isfinite(at.z)) ws.include(at);
    if (!ws.empty()) {
        info.wsLower = ws.lower;
        info.wsUpper = ws.upper;
    }
    const auto radii = ownRadii(cloud);
    if (!radii) return;
    std::vector<double> finite;
    for (const float value : radii->attribute->values)
        if (std::isfinite(value)) finite.push_back(radii->scale * double(value));
    if (finite.empty()) return;
    const auto [least, most] = std::minmax_element(finite.begin(), finite.end());
    info.minValue = *least;
    info.maxValue = *most;
}

namespace {

/// Fills a grid whose leaves are those of `blocks`; `valueOf` makes a voxel's value of the sums.
template <typename Grid, typename ValueOf>
openvdb::GridBase::Ptr filled(const PointRaster& raster, const PointBlocks& blocks, const PointAttribute* attribute,
                              const ValueOf& valueOf) {
    auto grid = Grid::create(openvdb::zeroVal<typename Grid::ValueType>());
    std::vector<typename Grid::TreeType::LeafNodeType*> leaves;
    for (const Int3& origin : blocks.origins)
        leaves.push_back(grid->tree().touchLeaf(openvdb::Coord(origin.x, origin.y, origin.z)));
    parallelFor(leaves.size(), [&](std::size_t block) {
        PointRaster::Sums sums;
        raster.fill(blocks, block, attribute, sums);
        for (std::size_t i = 0; i < kBlockVoxels; ++i)
            if (sums.density[i] > 0) leaves[block]->setValueOn(static_cast<openvdb::Index>(i), valueOf(sums, i));
    });
    return grid;
}

}  // namespace

openvdb::GridBase::Ptr gridOf(const PointRaster& raster, const PointBlocks& blocks, const PointAttribute* attribute,
                              const std::string& name) {
    using Sums = PointRaster::Sums;
    openvdb::GridBase::Ptr grid;
    if (attribute != nullptr && attribute->width == 3)
        grid = filled<openvdb::Vec3SGrid>(raster, blocks, attribute, [](const Sums& sums, std::size_t i) {
            return openvdb::Vec3s(sums.means[0][i], sums.means[1][i], sums.means[2][i]);
        });
    else
        grid = filled<openvdb::FloatGrid>(raster, blocks, attribute, [&](const Sums& sums, std::size_t i) {
            return attribute == nullptr ? sums.density[i] : sums.means[0][i];
        });
    placeGrid(*grid, name, raster.wsFromIs());
    if (attribute == nullptr) grid->setGridClass(openvdb::GRID_FOG_VOLUME);
    return grid;
}

}  // namespace scrim
