// SPDX-License-Identifier: Apache-2.0
#include "ax_together.h"

#include <openvdb_ax/ast/Parse.h>
#include <openvdb_ax/ast/Scanners.h>
#include <openvdb_ax/compiler/Logger.h>

#include <openvdb/tools/Prune.h>
#include <openvdb/tree/LeafManager.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace scrim {
namespace {

/// True if positions in single precision tell the grid's voxels apart, so that AX finds each voxel by its place.
bool placesAreExact(const openvdb::GridBase& grid) {
    if (!grid.transform().isLinear()) return false;
    const openvdb::CoordBBox box = grid.evalActiveVoxelBoundingBox();
    if (box.empty()) return false;
    const openvdb::Vec3d size = grid.voxelSize();
    double far = 0;
    for (int i = 0; i < 8; ++i) {
        const openvdb::Coord corner(i & 1 ? box.max().x() : box.min().x(), i & 2 ? box.max().y() : box.min().y(),
                                    i & 4 ? box.max().z() : box.min().z());
        const openvdb::Vec3d ws = grid.indexToWorld(corner);
        far = std::max({far, std::abs(ws.x()), std::abs(ws.y()), std::abs(ws.z())});
    }
    return far < std::min({size.x(), size.y(), size.z()}) * (1 << 20);
}

/// Gives `grid` the active voxels of `from`, with the value that `valueOf` takes from each.
template <typename Grid, typename Tree, typename ValueOf>
void unpack(const Tree& from, Grid& grid, const ValueOf& valueOf) {
    using Value = typename Grid::ValueType;
    const bool hadTiles = grid.tree().activeTileCount() > 0;
    const auto tree =
        std::make_shared<typename Grid::TreeType>(from, Value(grid.background()), openvdb::TopologyCopy());
    openvdb::tree::LeafManager<const Tree> leaves(from);
    openvdb::tree::LeafManager<typename Grid::TreeType> out(*tree);
    tbb::parallel_for(std::size_t{0}, leaves.leafCount(), [&](std::size_t i) {
        for (auto value = leaves.leaf(i).cbeginValueOn(); value; ++value)
            out.leaf(i).setValueOnly(value.pos(), valueOf(*value));
    });
    auto tile = from.cbeginValueOn();
    tile.setMaxDepth(decltype(tile)::LEAF_DEPTH - 1);
    auto other = tree->beginValueOn();
    other.setMaxDepth(decltype(other)::LEAF_DEPTH - 1);
    for (; tile && other; ++tile, ++other) other.setValue(valueOf(*tile));
    if (hadTiles) openvdb::tools::prune(*tree);
    grid.setTree(tree);
}

}  // namespace

ax::ast::Tree::Ptr Together::rewritten(const std::string& code) const {
    std::string before, after;
    for (std::size_t i = 0; i < m_written.size(); ++i) {
        const bool one = m_written[i].type == "float";
        const std::string name = variable(i);
        before += fmt::format("{} {} = {}@{};", m_written[i].type, name, one ? "f" : "v", m_written[i].name);
        after += one ? name + "," : fmt::format("{0}.x,{0}.y,{0}.z,", name);
    }
    for (int size = m_floats; size != 4 && size != 16; ++size) after += "0.0f,";
    after.pop_back();
    ax::Logger unheard([](const std::string&) {}, [](const std::string&) {});
    const auto parsed =
        ax::ast::parse(fmt::format("{}\n{}\n{}@{} = {{{}}};", before, code, type(), kGrid, after).c_str(), unheard);
    if (!parsed) return nullptr;
    ax::ast::Tree::Ptr tree(parsed->copy());
    std::vector<const ax::ast::Keyword*> words;
    ax::ast::collectNodeType<ax::ast::Keyword>(*tree, words);
    for (const auto* word : words)
        if (word->keyword() == ax::ast::tokens::RETURN) return nullptr;  // nothing would be written after it
    std::vector<const ax::ast::Attribute*> attributes;
    ax::ast::collectNodeType<ax::ast::Attribute>(*tree, attributes);
    std::vector<std::size_t> seen(m_written.size());
    for (const auto* attribute : attributes) {
        const auto use = std::find_if(m_written.begin(), m_written.end(),
                                      [&](const AxUse& written) { return written.name == attribute->name(); });
        if (use == m_written.end()) continue;
        const auto i = std::size_t(use - m_written.begin());
        // The first use is the one that reads it. `replace` deletes the attribute.
        if (seen[i]++ > 0 && !const_cast<ax::ast::Attribute*>(attribute)->replace(new ax::ast::Local(variable(i))))
            return nullptr;
    }
    return tree;
}

template <typename Value>
void Together::runAs(const openvdb::GridPtrVec& grids, const openvdb::GridPtrVec& written) const {
    using Grid = openvdb::Grid<typename openvdb::FloatTree::ValueConverter<Value>::Type>;
    openvdb::GridPtrVec all = grids;
    const auto topologyOf = [](const auto& tree) {
        return Grid::create(
            std::make_shared<typename Grid::TreeType>(tree, openvdb::zeroVal<Value>(), openvdb::TopologyCopy()));
    };
    const openvdb::GridBase& first = *written.front();
    typename Grid::Ptr packed = first.isType<openvdb::FloatGrid>()
                                    ? topologyOf(static_cast<const openvdb::FloatGrid&>(first).tree())
                                    : topologyOf(static_cast<const openvdb::Vec3SGrid&>(first).tree());
    packed->setTransform(first.transform().copy());
    packed->setName(kGrid);
    all.push_back(packed);
    m_executable->execute(all);
    const typename Grid::TreeType& tree = packed->tree();
    int at = 0;
    for (const auto& grid : written) {
        if (grid->isType<openvdb::FloatGrid>()) {
            unpack(tree, static_cast<openvdb::FloatGrid&>(*grid), [at](const Value& v) { return v.asPointer()[at]; });
            at += 1;
        } else {
            unpack(tree, static_cast<openvdb::Vec3SGrid&>(*grid),
                   [at](const Value& v) { return openvdb::Vec3s(v.asPointer() + at); });
            at += 3;
        }
    }
}

bool Together::run(const openvdb::GridPtrVec& grids) const {
    if (!m_executable) return false;
    openvdb::GridPtrVec written;
    for (const AxUse& use : m_written)
        written.push_back(
            *std::find_if(grids.begin(), grids.end(), [&](const auto& grid) { return grid->getName() == use.name; }));
    const auto voxels = [](const openvdb::GridBase& grid, const auto& task) {
        return grid.isType<openvdb::FloatGrid>() ? task(static_cast<const openvdb::FloatGrid&>(grid).tree())
                                                 : task(static_cast<const openvdb::Vec3SGrid&>(grid).tree());
    };
    const openvdb::GridBase& first = *written.front();
    if (!placesAreExact(first)) return false;
    for (const auto& grid : written)
        if (grid->transform() != first.transform() || !voxels(first, [&](const auto& a) {
                return voxels(*grid, [&](const auto& b) { return a.hasSameTopology(b); });
            }))
            return false;
    // Each type costs half a minute of compilation.
    if (m_floats <= 4)
        runAs<openvdb::math::Vec4<float>>(grids, written);
    else
        runAs<openvdb::math::Mat4<float>>(grids, written);
    return true;
}

}  // namespace scrim
