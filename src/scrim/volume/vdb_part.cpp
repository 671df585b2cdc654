// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/vdb_part.h>

#include <scrim/volume/grid_choice.h>

#include <algorithm>
#include <set>
#include <utility>

namespace scrim {

namespace {

constexpr std::size_t kWindow = 256 << 10;  // bytes that are read at once
constexpr std::size_t kVersionAt = 8;       // behind the magic number

/// The first `size` bytes of the file with another version. OpenVDB would print a warning about a
/// newer version than it knows, which the confined process must not; the caller warns.
std::string headOf(const VdbBytes& file, std::uint64_t size, std::uint32_t version) {
    std::string head(size, '\0');
    file.copy(0, size, head.data());
    return head.replace(kVersionAt, sizeof version, reinterpret_cast<const char*>(&version), sizeof version);
}

}  // namespace

std::optional<std::vector<std::size_t>> neededGrids(const VdbLayout& layout, const std::vector<GridRequest>& requests,
                                                    const std::vector<std::string>& others) {
    if (!layout.hasOffsets) return {};
    const std::vector<GridOffer> offers = offersOf(layout);
    std::set<std::size_t> needed;
    // What no grid is called may be an attribute of points.
    const auto insertPoints = [&] {
        for (std::size_t i = 0; i < offers.size(); ++i)
            if (offers[i].isPoints()) needed.insert(i);
    };
    for (const GridRequest& request : requests) {
        const auto choice = chooseGrid(offers, withoutList(request));
        if (!choice)
            insertPoints();
        else if (!isList(request.part) || offers[choice->grid].isPoints())  // a grid of voxels has no list
            needed.insert(choice->grid);
    }
    for (const std::string& name : others)
        if (const auto i = chooseNamed(offers, name))
            needed.insert(*i);
        else
            insertPoints();
    for (const std::size_t i : needed)
        if (layout.grids[i].instance) return {};
    return std::vector<std::size_t>(needed.begin(), needed.end());
}

VdbStream::VdbStream(const VdbBytes& file, std::uint64_t begin, std::uint64_t end) : m_file(file), m_window(kWindow) {
    add(begin, end);
}

VdbStream::VdbStream(const VdbBytes& file, std::uint32_t version) : m_file(file), m_window(kWindow) {
    std::string head = headOf(file, kVersionAt + sizeof version, version);
    const std::uint64_t behind = head.size();
    add(std::move(head));
    add(behind, file.size());
}

VdbStream::VdbStream(const VdbBytes& file, std::uint32_t version, const VdbLayout& layout,
                     const std::vector<std::size_t>& places)
    : m_file(file), m_window(kWindow) {
    std::string head = headOf(file, layout.gridsBegin, version);
    const auto count = static_cast<std::int32_t>(places.size());
    head.append(reinterpret_cast<const char*>(&count), sizeof count);
    add(std::move(head));
    for (const std::size_t i : places) add(layout.grids[i].begin, layout.grids[i].end);
}

void VdbStream::add(std::string bytes) {
    const std::uint64_t size = bytes.size();
    m_pieces.push_back({std::move(bytes), 0, size});
    m_size += size;
}

void VdbStream::add(std::uint64_t begin, std::uint64_t end) {
    m_pieces.push_back({"", begin, end - begin});
    m_size += end - begin;
}

VdbStream::int_type VdbStream::underflow() {
    std::uint64_t in = m_windowEnd;  // the piece
    for (const Piece& piece : m_pieces) {
        if (in >= piece.size) {
            in -= piece.size;
            continue;
        }
        const std::uint64_t size = std::min<std::uint64_t>(m_window.size(), piece.size - in);
        if (piece.bytes.empty())
            m_file.copy(piece.at + in, size, m_window.data());
        else
            piece.bytes.copy(m_window.data(), size, in);
        m_windowEnd += size;
        setg(m_window.data(), m_window.data(), m_window.data() + size);
        return traits_type::to_int_type(*gptr());
    }
    return traits_type::eof();
}

VdbStream::pos_type VdbStream::seekoff(off_type offset, std::ios_base::seekdir from, std::ios_base::openmode) {
    const auto size = static_cast<off_type>(m_size), end = static_cast<off_type>(m_windowEnd);
    const off_type base = from == std::ios_base::beg   ? 0
                          : from == std::ios_base::cur ? static_cast<off_type>(position())
                                                       : size;
    if (offset < -base || offset > size - base) return pos_type(off_type(-1));
    const off_type at = base + offset, begin = end - (egptr() - eback());
    if (at >= begin && at <= end) {
        setg(eback(), eback() + (at - begin), egptr());
    } else {
        m_windowEnd = static_cast<std::uint64_t>(at);
        setg(m_window.data(), m_window.data(), m_window.data());
    }
    return pos_type(at);
}

}  // namespace scrim
