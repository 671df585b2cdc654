// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/direct_fields.h>

#include <scrim/base/error.h>
#include <scrim/volume/field_builder.h>
#include <scrim/volume/field_choice.h>
#include <scrim/volume/vdb_leaves.h>
#include <scrim/volume/vdb_tree.h>

#include <algorithm>
#include <deque>
#include <exception>
#include <set>
#include <string>

namespace scrim {
namespace {

/// What is wanted of one grid.
struct Wanted {
    std::vector<GridRequest> requests;
    std::vector<FieldChoice> fields;  ///< one for each request
    bool asFog = false;               ///< a level set is to become fog
};

/// All of the field that `choice` means but its values, which are those of the leaves, block by block.
FieldPieces frameOf(const VdbTree& tree, const FieldChoice& choice) {
    FieldPieces pieces;
    pieces.name = fieldName(tree.name, choice);
    pieces.wsFromIs = tree.wsFromIs;
    pieces.blockOrigins = tree.leaves;
    for (const VdbTree::Tile& tile : tree.tiles)
        pieces.tiles.push_back(
            {tile.origin, tile.edge, choice(tile.value.at(std::size_t(std::max(choice.component, 0))))});
    return pieces;
}

/// True where a grid of so many channels has such components.
bool hasAll(const VdbTree& tree, const Wanted& wanted) {
    return std::all_of(wanted.fields.begin(), wanted.fields.end(), [&](const FieldChoice& field) {
        return (tree.format.channels == 1) == (field.component == GridRequest::kScalar);
    });
}

/// The fields of grid `place` that are wanted; none where it needs OpenVDB.
std::vector<SparseField> fieldsOf(const VdbBytes& file, const VdbLayout& layout, std::size_t place,
                                  const Wanted& wanted, BlockMemory& memory) {
    const VdbLayout::Grid& grid = layout.grids.at(place);
    const std::optional<VdbTree> tree = readVdbTree(file, layout, grid);
    if (!tree || !hasAll(*tree, wanted) || (tree->isLevelSet && wanted.asFog)) return {};
    std::deque<FieldFill> fields;
    for (const FieldChoice& choice : wanted.fields) fields.emplace_back(frameOf(*tree, choice), memory);
    const auto visit = [&](std::size_t leaf, const LeafValues& values) {
        for (std::size_t f = 0; f < fields.size(); ++f) {
            values.fill(std::max(wanted.fields[f].component, 0), wanted.fields[f], fields[f].block(leaf));
            fields[f].filled(leaf);
        }
    };
    std::vector<SparseField> out;
    if (!readLeaves(file, tree->leavesAt, grid.end, tree->leaves.size(), tree->format, visit)) return out;
    for (std::size_t f = 0; f < fields.size(); ++f) {
        out.push_back(fields[f].finish());
        if (tree->isStaggered) placeOnFaces(out.back(), wanted.fields[f]);
    }
    return out;
}

/// The same without errors about the file.
std::vector<SparseField> soundFieldsOf(const VdbBytes& file, const VdbLayout& layout, std::size_t place,
                                       const Wanted& wanted, BlockMemory& memory) {
    try {
        return fieldsOf(file, layout, place, wanted, memory);
    } catch (const Error& error) {
        if (error.kind() != ErrorKind::input) throw;
        return {};
    } catch (const std::exception&) {
        return {};
    }
}

/// False where the grid that a request means surely needs OpenVDB, so that nothing is read in vain.
bool mayBeDirect(const VdbLayout& layout, const std::vector<GridOffer>& offers, const GridRequest& request) {
    const auto choice = chooseGrid(offers, request);
    if (!choice || layout.isNano || !layout.points.empty() || isList(request.part)) return false;
    const GridOffer& offer = offers[choice->grid];
    const bool isFog = request.component == GridRequest::kScalar && offer.gridClass == "level set";
    return (offer.type == kVdbFloats || offer.type == kVdbVectors) && !isFog;
}

}  // namespace

std::map<GridRequest, SparseField> directFields(const VdbBytes& file, const VdbLayout& layout,
                                                const std::vector<GridOffer>& offers,
                                                const std::vector<GridRequest>& requests, BlockMemory& memory) {
    std::map<std::size_t, Wanted> grids;
    for (const GridRequest& request : std::set<GridRequest>(requests.begin(), requests.end())) {
        const auto choice = chooseGrid(offers, request);
        if (!choice || isList(request.part)) continue;
        Wanted& wanted = grids[choice->grid];
        wanted.requests.push_back(request);
        wanted.fields.push_back({choice->component, request.part});
        wanted.asFog = wanted.asFog || (request.component == GridRequest::kScalar &&
                                        choice->component == GridRequest::kScalar && request.part == GridPart::whole);
    }
    std::map<GridRequest, SparseField> direct;
    for (const auto& [place, wanted] : grids) {
        std::vector<SparseField> fields = soundFieldsOf(file, layout, place, wanted, memory);
        for (std::size_t i = 0; i < fields.size(); ++i) direct.emplace(wanted.requests[i], std::move(fields[i]));
    }
    return direct;
}

std::optional<std::vector<SparseField>> readWithoutOpenVdb(const VdbBytes& file,
                                                           const std::vector<GridRequest>& requests,
                                                           const MessageSink& messages, BlockMemory& memory) {
    const VdbLayout layout = checkVdbLayout(file);
    const std::vector<GridOffer> offers = offersOf(layout);
    for (const GridRequest& request : requests)
        if (!mayBeDirect(layout, offers, request)) return {};
    const std::map<GridRequest, SparseField> direct = directFields(file, layout, offers, requests, memory);
    std::vector<SparseField> fields;
    for (const GridRequest& request : requests) {
        const auto found = direct.find(request);
        if (found == direct.end()) return {};
        fields.push_back(found->second);
    }
    std::set<std::string> said;
    for (const SparseField& field : fields)
        reportCleaning(field, file.path(), [&](Severity severity, const std::string& text) {
            if (said.insert(text).second) notify(messages, severity, text);
        });
    return fields;
}

}  // namespace scrim
