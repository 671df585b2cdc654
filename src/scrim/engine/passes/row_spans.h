// SPDX-License-Identifier: Apache-2.0
// Which cells of each of many rows are used: a few spans, since a row may pass several volumes that are far apart.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <span>
#include <vector>

namespace scrim {

/// Elements behind each row that vectors may read or write.
inline constexpr int kRowSlack = 8;

struct CellSpan {
    int begin = 0, end = 0;
    bool empty() const { return begin >= end; }
    /// The smallest span that contains both.
    CellSpan with(const CellSpan& o) const {
        return empty() ? o : o.empty() ? *this : CellSpan{std::min(begin, o.begin), std::max(end, o.end)};
    }
};

/// For each row its spans, in ascending order. Those less than kApart cells apart are one, so that
/// vectors may write kRowSlack cells behind each without reaching the next.
class RowSpans {
  public:
    static constexpr int kApart = 2 * kRowSlack;

    /// Makes `rows` rows: spansOf(row, spans) appends to `spans`, in any order; those that are
    /// empty do not count. It is called in parallel.
    static RowSpans of(std::size_t rows, const std::function<void(std::size_t, std::vector<CellSpan>&)>& spansOf);

    std::span<const CellSpan> row(std::size_t row) const {
        return std::span(m_spans).subspan(m_first[row], m_first[row + 1] - m_first[row]);
    }
    /// The span around all of a row; empty if there are none.
    CellSpan around(std::size_t row) const {
        const std::span<const CellSpan> own = this->row(row);
        return own.empty() ? CellSpan() : CellSpan{own.front().begin, own.back().end};
    }
    std::size_t rows() const { return m_first.size() - 1; }
    /// For each `perSlice` rows after one another, those of them that have spans.
    std::vector<std::vector<int>> usedRows(std::size_t perSlice) const;
    /// The cells of all spans.
    std::size_t cells() const {
        std::size_t sum = 0;
        for (const CellSpan& span : m_spans) sum += std::size_t(span.end - span.begin);
        return sum;
    }
    bool empty(std::size_t row) const { return m_first[row] == m_first[row + 1]; }
    std::size_t bytes() const { return m_first.size() * sizeof(std::size_t) + m_spans.size() * sizeof(CellSpan); }

  private:
    std::vector<std::size_t> m_first{0};  // for each row, and behind the last, the index of its first span
    std::vector<CellSpan> m_spans;
};

}  // namespace scrim
