// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/passes/row_spans.h>

#include <scrim/base/parallel.h>

namespace scrim {
namespace {

// Sorts the spans of a row and appends them to `all`, as few as possible.
void append(std::vector<CellSpan>& some, std::vector<CellSpan>& all) {
    std::erase_if(some, [](const CellSpan& span) { return span.empty(); });
    std::sort(some.begin(), some.end(), [](const CellSpan& a, const CellSpan& b) { return a.begin < b.begin; });
    const std::size_t first = all.size();
    for (const CellSpan& span : some) {
        if (all.size() > first && span.begin < all.back().end + RowSpans::kApart)
            all.back().end = std::max(all.back().end, span.end);
        else
            all.push_back(span);
    }
}

}  // namespace

RowSpans RowSpans::of(std::size_t rows, const std::function<void(std::size_t, std::vector<CellSpan>&)>& spansOf) {
    constexpr std::size_t kRows = 4096;  // that one thread makes at a time
    std::vector<std::vector<CellSpan>> parts((rows + kRows - 1) / kRows);
    RowSpans out;
    out.m_first.assign(rows + 1, 0);
    parallelFor(parts.size(), [&](std::size_t part) {
        std::vector<CellSpan> some;
        for (std::size_t row = part * kRows; row < std::min(rows, (part + 1) * kRows); ++row) {
            some.clear();
            spansOf(row, some);
            append(some, parts[part]);
            out.m_first[row + 1] = parts[part].size();
        }
    });
    for (std::size_t part = 0; part < parts.size(); ++part) {
        for (std::size_t row = part * kRows; row < std::min(rows, (part + 1) * kRows); ++row)
            out.m_first[row + 1] += out.m_spans.size();
        out.m_spans.insert(out.m_spans.end(), parts[part].begin(), parts[part].end());
    }
    return out;
}

std::vector<std::vector<int>> RowSpans::usedRows(std::size_t perSlice) const {
    std::vector<std::vector<int>> used(rows() / perSlice);
    for (std::size_t row = 0; row < rows(); ++row)
        if (!empty(row)) used[row / perSlice].push_back(static_cast<int>(row % perSlice));
    return used;
}

}  // namespace scrim
