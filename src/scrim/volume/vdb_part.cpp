// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/vdb_part.h>

#include <scrim/volume/grid_choice.h>

#include <cstdint>
#include <cstring>
#include <set>

namespace scrim {

std::optional<std::vector<std::size_t>> neededGrids(const VdbLayout& layout, const std::vector<GridRequest>& requests,
                                                    const std::vector<std::string>& others) {
    if (!layout.hasOffsets) return {};
    const std::vector<GridOffer> offers = offersOf(layout);
    std::set<std::size_t> needed;
    for (const GridRequest& request : requests)
        if (const auto choice = chooseGrid(offers, request)) needed.insert(choice->grid);
    for (const std::string& name : others)
        if (const auto i = chooseNamed(offers, name)) needed.insert(*i);
    for (const std::size_t i : needed)
        if (layout.grids[i].instance) return {};
    return std::vector<std::size_t>(needed.begin(), needed.end());
}

std::vector<char> partOfFile(const VdbBytes& file, const VdbLayout& layout, const std::vector<std::size_t>& places) {
    const auto count = static_cast<std::int32_t>(places.size());
    std::uint64_t size = layout.gridsBegin + sizeof count;
    for (const std::size_t i : places) size += layout.grids[i].end - layout.grids[i].begin;
    std::vector<char> bytes(size);
    file.copy(0, layout.gridsBegin, bytes.data());
    std::memcpy(bytes.data() + layout.gridsBegin, &count, sizeof count);
    std::uint64_t at = layout.gridsBegin + sizeof count;
    for (const std::size_t i : places) {
        const std::uint64_t length = layout.grids[i].end - layout.grids[i].begin;
        file.copy(layout.grids[i].begin, length, bytes.data() + at);
        at += length;
    }
    return bytes;
}

std::vector<char> allOfFile(const VdbBytes& file) {
    std::vector<char> bytes(file.size());
    file.copy(0, file.size(), bytes.data());
    return bytes;
}

}  // namespace scrim
