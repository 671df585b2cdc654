// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/grid_combiner.h>

#include <scrim/base/error.h>
#include <scrim/volume/openvdb_field.h>

#include <algorithm>
#include <array>
#include <utility>

#include <fmt/format.h>

namespace scrim {
namespace {

using How = CombinedGrid::How;

/// Most voxels of a grid that is interpolated at the voxels of another.
constexpr double kMostVoxels = 1e9;

constexpr std::array<const char*, 4> kWords{"", "max of", "sum of", "product of"};

/// "a.vdb: 'density'"
std::string textOf(const GridEdit& edit, const CombinedGrid::Part& part, const openvdb::GridBase& grid) {
    return fmt::format("{}: '{}'", shortened(edit.files[part.file]), shortened(grid.getName(), 80));
}

[[noreturn]] void fail(const CombinedGrid::Part& part, const std::string& problem) {
    throw Error(ErrorKind::input, fmt::format("{}: {}", part.where, problem));
}

bool isStaggered(const openvdb::GridBase& grid) {
    return grid.getGridClass() == openvdb::GRID_STAGGERED;
}

float largest(float a, float b) {
    return std::max(a, b);
}
/// The reader admits no vectors here.
openvdb::Vec3s largest(const openvdb::Vec3s& a, const openvdb::Vec3s&) {
    return a;
}

/// Combines `b` into `a`, which have the same voxels. `b` is empty then.
template <typename Grid>
void combineInto(Grid& a, Grid& b, How how) {
    using Value = typename Grid::ValueType;
    const Value zero = openvdb::zeroVal<Value>();
    a.tree().combineExtended(b.tree(), [&](openvdb::CombineArgs<Value>& args) {
        const Value x = args.aIsActive() ? args.a() : zero, y = args.bIsActive() ? args.b() : zero;
        args.setResult(how == How::max ? largest(x, y) : how == How::add ? Value(x + y) : Value(x * y));
        args.setResultIsActive(how == How::multiply ? args.aIsActive() && args.bIsActive()
                                                    : args.aIsActive() || args.bIsActive());
    });
}

/// `grid` at the voxels of a grid with that transform.
template <typename Grid>
typename Grid::Ptr atVoxelsOf(const openvdb::math::Transform& transform, const Grid& grid,
                              const CombinedGrid::Part& part, const std::string& text) {
    if (!grid.transform().isLinear() || !transform.isLinear())
        fail(part, fmt::format("{} has other voxels than the first grid, and a transform that is not affine; expected "
                               "affine ones, or the same voxels",
                               text));
    const double voxels = static_cast<double>(grid.activeVoxelCount()) * grid.transform().baseMap()->determinant() /
                          transform.baseMap()->determinant();
    if (std::abs(voxels) > kMostVoxels)
        fail(part, fmt::format("{} would have {:.3g} voxels of the first grid's size; expected at most {:g}", text,
                               std::abs(voxels), kMostVoxels));
    typename Grid::Ptr out = Grid::create(openvdb::zeroVal<typename Grid::ValueType>());
    out->setTransform(transform.copy());
    interpolateInto(*out, grid);
    return out;
}

/// `grid` with floats for numbers, as fog, and with voxels of its own.
openvdb::GridBase::Ptr prepared(const openvdb::GridBase::Ptr& grid, const std::string& file,
                                const MessageSink& messages) {
    openvdb::GridBase::Ptr own = inFloats(grid);
    if (own == grid) own = grid->deepCopyGrid();
    levelSetIntoFog(*own, file, messages);
    return own;
}

/// Combines parts of one type.
template <typename Grid>
std::string combineAll(const GridEdit& edit, const CombinedGrid& grid,
                       const std::vector<openvdb::GridBase::Ptr>& parts) {
    Grid& first = static_cast<Grid&>(*parts.front());
    std::string text;
    for (std::size_t i = 0; i < parts.size(); ++i) {
        const CombinedGrid::Part& part = grid.parts[i];
        const std::string name = textOf(edit, part, *parts[i]);
        text += (i == 0 ? "" : ", ") + name;
        if (i == 0) continue;
        auto next = openvdb::gridPtrCast<Grid>(parts[i]);
        if (next->transform() != first.transform()) {
            next = atVoxelsOf(first.transform(), *next, part, name);
            text += " (interpolated)";
        }
        combineInto(first, *next, grid.how);
    }
    return text;
}

}  // namespace

std::size_t choosePart(const std::vector<GridOffer>& offers, const CombinedGrid& grid, const CombinedGrid::Part& part,
                       const std::string& path) {
    const std::string& name = part.grid.empty() ? grid.name : part.grid;
    if (const auto i = chooseNamed(offers, name)) return *i;
    if (part.grid.empty() && offers.size() == 1) return 0;
    fail(part, fmt::format("{}: {}", shortened(path), whyNoGrid(offers, {name})));
}

std::vector<const CombinedGrid*> gridsCalled(const GridEdit& edit, const std::string& wanted) {
    std::vector<const CombinedGrid*> found;
    const auto add = [&](const auto& fits) {
        for (const CombinedGrid& grid : edit.grids)
            if (fits(grid.name)) found.push_back(&grid);
    };
    add([&](const std::string& name) {
        return name == (wanted.empty() ? "density" : wanted) || name.starts_with(wanted + ".") ||
               wanted.starts_with(name + "[");
    });
    if (wanted.empty() && found.empty()) add([](const std::string&) { return true; });
    return found;
}

openvdb::GridBase::Ptr combine(const GridEdit& edit, const CombinedGrid& grid,
                               std::vector<openvdb::GridBase::Ptr> parts, const MessageSink& messages) {
    std::string text;
    openvdb::GridBase::Ptr out = parts.front();
    if (grid.how == How::copied) {
        text = textOf(edit, grid.parts.front(), *out);
        out = out->copyGrid();  // it shares its voxels
    } else {
        for (std::size_t i = 0; i < parts.size(); ++i) {
            const CombinedGrid::Part& part = grid.parts[i];
            const GridOffer offer = offerOf(*parts[i]);
            const bool fits = offer.isScalar() || (offer.isVector() && grid.how != How::max);
            if (!fits || offer.isScalar() != offerOf(*parts.front()).isScalar())
                fail(part, fmt::format("{} holds {} values; expected {}", textOf(edit, part, *parts[i]),
                                       shortened(offer.valueType(), 80),
                                       grid.how == How::max ? "numbers" : "numbers, or vectors in all of them"));
            if (offer.isVector() && isStaggered(*parts[i]) != isStaggered(*parts.front()))
                fail(part, fmt::format("{} is {}staggered, unlike the first grid; expected both or none",
                                       textOf(edit, part, *parts[i]), isStaggered(*parts[i]) ? "" : "not "));
            parts[i] = prepared(parts[i], edit.files[part.file], messages);
        }
        out = parts.front();
        text = fmt::format("the {} {}", kWords[static_cast<std::size_t>(grid.how)],
                           out->isType<openvdb::FloatGrid>() ? combineAll<openvdb::FloatGrid>(edit, grid, parts)
                                                             : combineAll<openvdb::Vec3SGrid>(edit, grid, parts));
    }
    const bool asNamed = grid.how == How::copied && (!grid.parts.front().grid.empty() || out->getName() == grid.name);
    out->setName(grid.name);
    if (!asNamed)
        notify(messages, Severity::info,
               fmt::format("{}: grid '{}' is {}", grid.parts.front().where, shortened(grid.name, 80), text));
    return out;
}

}  // namespace scrim
