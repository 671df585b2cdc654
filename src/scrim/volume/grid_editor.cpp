// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/grid_editor.h>

#include <scrim/base/error.h>
#include <scrim/volume/grid_choice.h>
#include <scrim/volume/openvdb_field.h>

#include <chrono>
#include <utility>

#include <fmt/format.h>
#include <openvdb/tools/Clip.h>

namespace scrim {
namespace {

using Clock = std::chrono::steady_clock;

/// Grids that an expression can make.
using MadeGrids = openvdb::TypeList<openvdb::FloatGrid, openvdb::Int32Grid, openvdb::BoolGrid, openvdb::Vec3SGrid>;

/// Most voxels of a refined grid, which takes 8 GB then.
constexpr double kMostVoxels = 1e9;

double secondsSince(Clock::time_point start) {
    return std::chrono::duration<double>(Clock::now() - start).count();
}

/// OpenVDB's word for AX's type.
std::string valueTypeOf(const std::string& axType) {
    return axType == "vec3f" ? "vec3s" : axType;
}

std::vector<std::string> namesOf(const EditedGrids& all) {
    std::vector<std::string> names;
    for (const auto& grid : all.grids)
        if (grid) names.push_back(grid->getName());
    return names;
}

openvdb::GridBase::Ptr* find(EditedGrids& all, const std::string& name) {
    for (auto& grid : all.grids)
        if (grid && grid->getName() == name) return &grid;
    return nullptr;
}

/// Voxels beyond the box that are kept, because what is reconstructed in it, and its gradient, depends on them.
constexpr double kReach = 3;

/// Leaves out the voxels that are so far outside of the box that nothing in it depends on them. The
/// box itself is cut out later, within voxels.
template <typename Grid>
void clip(Grid& grid, const Bounds& ws) {
    openvdb::BBoxd isBox;
    for (const Vec3& corner : ws.corners())
        isBox.expand(grid.transform().worldToIndex(openvdb::Vec3d(corner.x, corner.y, corner.z)));
    const auto bounded = [](double v) { return static_cast<int>(std::clamp(v, -1e9, 1e9)); };
    openvdb::CoordBBox near;
    for (int i = 0; i < 3; ++i) {
        near.min()[i] = bounded(std::floor(isBox.min()[i] - kReach));
        near.max()[i] = bounded(std::ceil(isBox.max()[i] + kReach));
    }
    grid.tree().clip(near);
    grid.pruneGrid();
}

/// The grid with voxels of 1 / factor of the edge, which fill the same space.
openvdb::GridBase::Ptr refined(const openvdb::GridBase& grid, double factor, const std::string& where) {
    if (!grid.transform().isLinear())
        throw Error(ErrorKind::input,
                    fmt::format("{}: grid '{}' has a transform that is not affine; 'resample' expects an affine one",
                                where, shortened(grid.getName(), 80)));
    const double voxels = static_cast<double>(grid.activeVoxelCount()) * factor * factor * factor;
    if (voxels > kMostVoxels)
        throw Error(ErrorKind::input, fmt::format("{}: grid '{}' would have {:.3g} voxels; expected at most {:g}",
                                                  where, shortened(grid.getName(), 80), voxels, kMostVoxels));
    const openvdb::GridBase::Ptr out = grid.copyGridWithNewTree();
    const openvdb::math::Transform::Ptr transform = grid.transform().copy();
    transform->preScale(1 / factor);
    transform->preTranslate(openvdb::Vec3d(-(factor - 1) / 2));
    out->setTransform(transform);
    interpolateInto(*out, grid);
    return out;
}

/// A grid of that type with the active voxels of `like`, all 0; null for types that cannot be made.
openvdb::GridBase::Ptr madeLike(const openvdb::FloatGrid& like, const std::string& valueType) {
    openvdb::GridBase::Ptr made;
    MadeGrids::foreach ([&](auto sample) {
        using Grid = std::decay_t<decltype(sample)>;
        if (sample.valueType() != valueType) return;
        const auto zero = openvdb::zeroVal<typename Grid::ValueType>();
        made = Grid::create(std::make_shared<typename Grid::TreeType>(like.tree(), zero, openvdb::TopologyCopy()));
    });
    if (made) made->setTransform(like.transform().copy());
    return made;
}

void addTo(std::string& list, const std::string& name) {
    list += (list.empty() ? "'" : ", '") + name + "'";
}

}  // namespace

GridEditor::GridEditor(GridEdit edit, const AxModule* ax) : m_edit(std::move(edit)) {
    for (const AxCode& code : m_edit.programs) {
        const auto start = Clock::now();
        AxCompiled compiled = ax->compile(code.text, m_edit.variables);
        if (!compiled.problems.empty()) {
            const AxProblem& first = compiled.problems.front();
            throw Error(ErrorKind::input,
                        fmt::format("{}: {}", code.placeOf(first.line, first.column), shortened(first.text)));
        }
        m_programs.push_back({&code, std::move(compiled.program), secondsSince(start)});
    }
}

std::vector<std::string> GridEditor::usedGrids() const {
    std::vector<std::string> names;
    for (const Program& program : m_programs)
        for (const AxUse& use : program.compiled->grids()) names.push_back(use.name);
    return names;
}

openvdb::GridBase::Ptr GridEditor::gridFor(const Program& program, const AxUse& use, EditedGrids& all,
                                           const std::string& file) const {
    const auto fail = [&](const std::string& problem) {
        throw Error(ErrorKind::input, fmt::format("{}: {}", program.code->placeOf(use.line, use.column), problem));
    };
    const std::string wanted = valueTypeOf(use.type);
    if (openvdb::GridBase::Ptr* const known = find(all, use.name)) {
        openvdb::GridBase::Ptr& grid = *known;
        if (grid->valueType() != wanted)
            fail(fmt::format("grid '{}' of {} holds {}, but the expression takes it for {}", use.name, file,
                             grid->valueType(), wanted));
        // A grid may share its voxels with another.
        if (use.writes && !grid->isTreeUnique()) grid = grid->deepCopyGrid();
        return grid;
    }
    if (!use.writes)
        fail(fmt::format("the expression reads grid '{}', which {} does not have; there is {}", use.name, file,
                         choices(namesOf(all))));
    std::vector<GridOffer> offers;
    for (const auto& grid : all.grids) offers.push_back(grid ? offerOf(*grid) : GridOffer{"", "", ""});
    auto density = chooseGrid(offers, {m_edit.density});
    if (!density) density = chooseGrid(offers, {});  // the expression makes the density
    const bool isWhole = density && density->component == GridRequest::kScalar && all.grids[density->grid];
    const openvdb::GridBase::Ptr like = isWhole ? inFloats(all.grids[density->grid]) : nullptr;
    if (!like) fail(fmt::format("there is no density in {}, whose voxels grid '{}' could get", file, use.name));
    openvdb::GridBase::Ptr made = madeLike(static_cast<const openvdb::FloatGrid&>(*like), wanted);
    if (!made)
        fail(fmt::format("grid '{}' would be of type {}; expected f@{} or v@{}", use.name, use.type, use.name,
                         use.name));
    made->setName(use.name);
    // The class decides which grid is the density: one that is made must not be preferred to the one it is made like.
    if (wanted == "float") made->setGridClass(like->getGridClass());
    all.grids.push_back(made);
    return made;
}

void GridEditor::run(const Program& program, EditedGrids& all, const std::string& file,
                     const MessageSink& messages) const {
    EditedGrids used;
    std::uint64_t voxels = 0;
    const std::vector<AxUse>& uses = program.compiled->grids();
    std::string read, written;
    for (const AxUse& use : uses) {
        if (find(all, use.name)) addTo(read, use.name);
        if (use.writes) addTo(written, use.name);
        used.grids.push_back(gridFor(program, use, all, file));
        if (use.writes) voxels += used.grids.back()->activeVoxelCount();
    }
    const auto start = Clock::now();
    try {
        program.compiled->run(used);
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& error) {
        throw Error(ErrorKind::input,
                    fmt::format("{}: ax cannot be run on {}: {}", program.code->where, file, shortened(error.what())));
    }
    notify(messages, Severity::info,
           fmt::format("{}: ax on {}: reads {}; writes {}; {} voxels in {:.2f} s, compiled in {:.2f} s",
                       program.code->where, file, read.empty() ? "none" : read, written.empty() ? "none" : written,
                       voxels, secondsSince(start), program.seconds));
}

void GridEditor::apply(EditedGrids& all, const std::string& file, const MessageSink& messages) const {
    // Expressions take whole numbers for what they are: i@id.
    const auto isUsedWhole = [&](const openvdb::GridBase& grid) {
        for (const Program& program : m_programs)
            for (const AxUse& use : program.compiled->grids())
                if (use.name == grid.getName() && use.type == grid.valueType() && !offerOf(grid).isReal()) return true;
        return false;
    };
    for (auto& grid : all.grids) {
        if (!grid || isUsedWhole(*grid)) continue;
        grid = inFloats(std::move(grid));
        if (grid->getGridClass() == openvdb::GRID_LEVEL_SET && offerOf(*grid).isScalar()) {
            if (!grid->isTreeUnique()) grid = grid->deepCopyGrid();
            levelSetIntoFog(*grid, file, messages);
        }
        if (!offerOf(*grid).isScalar() && !offerOf(*grid).isVector()) continue;  // it cannot become a field
        if (m_edit.clip) {
            if (!grid->isTreeUnique()) grid = grid->deepCopyGrid();
            grid->apply<FloatGrids>([&](auto& typed) { clip(typed, *m_edit.clip); });
        }
        if (m_edit.resample != 1) grid = refined(*grid, m_edit.resample, m_edit.where + ": " + file);
    }
    for (const Program& program : m_programs) run(program, all, file, messages);
}

}  // namespace scrim
