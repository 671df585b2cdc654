// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/deep_image.h>

#include <scrim/base/parallel.h>

#include <algorithm>
#include <cmath>

namespace scrim {
namespace {

using Shown = std::array<double, 4>;

Shown asDouble(const std::array<float, 4>& shown) {
    return {shown[0], shown[1], shown[2], shown[3]};
}

// Distributes a piece's contribution over its length: of its opacity a, the first fraction x of the
// length contributes (1 - (1 - a)^x) / a, and the same fraction of its colour. An opaque piece
// would be opaque from its beginning; it is treated as one of slightly less.
class Between {
  public:
    Between(const Shown& before, const Shown& after) : m_before(before), m_after(after) {
        constexpr double kMostOpaque = 1 - 1e-6;
        const double open = 1 - before[3];
        m_alpha = open > 0 ? std::min((after[3] - before[3]) / open, kMostOpaque) : 0;
        if (m_alpha >= kLeastOpaque) m_decay = std::log1p(-m_alpha);
    }

    Shown operator()(double x) const {
        const double share = m_alpha < kLeastOpaque ? x : std::min((1 - std::exp(x * m_decay)) / m_alpha, 1.0);
        Shown shown;
        for (std::size_t c = 0; c < 4; ++c) shown[c] = m_before[c] + share * (m_after[c] - m_before[c]);
        return shown;
    }

  private:
    static constexpr double kLeastOpaque = 1e-7;  // below it the curvature is lost in float rounding
    Shown m_before, m_after;
    double m_alpha = 0, m_decay = 0;
};

// Evaluates a curve at depths that do not decrease.
class CurveReader {
  public:
    explicit CurveReader(std::span<const DeepPiece> curve) : m_curve(curve) {}

    Shown before(double depth) {
        while (m_next < m_curve.size() && double(m_curve[m_next].end) <= depth)
            m_passed = asDouble(m_curve[m_next++].shown);
        if (m_next == m_curve.size() || double(m_curve[m_next].begin) >= depth) return m_passed;
        const DeepPiece& piece = m_curve[m_next];
        return Between(m_passed, asDouble(piece.shown))((depth - piece.begin) / (double(piece.end) - piece.begin));
    }

  private:
    std::span<const DeepPiece> m_curve;
    std::size_t m_next = 0;
    Shown m_passed{};
};

struct Tolerances {
    double colour, alpha;
};

bool near(const Shown& a, const Shown& b, const Tolerances& tolerances) {
    for (std::size_t c = 0; c < 3; ++c)
        if (!(std::abs(a[c] - b[c]) <= tolerances.colour)) return false;
    return std::abs(a[3] - b[3]) <= tolerances.alpha;
}

// True if one piece can replace the pieces [first, last] within the tolerances. This is tested
// wherever one of them begins or ends, starting in the middle, where it most likely fails.
bool standsFor(const DeepCurve& curve, std::size_t first, std::size_t last, const Tolerances& tolerances) {
    const Between between(first > 0 ? asDouble(curve[first - 1].shown) : Shown{}, asDouble(curve[last].shown));
    const double begin = curve[first].begin, scale = 1 / (curve[last].end - begin);
    const auto holdsAfter = [&](std::size_t i) {
        const Shown shown = asDouble(curve[i].shown);
        if (!near(between((curve[i].end - begin) * scale), shown, tolerances)) return false;
        const float next = curve[i + 1].begin;
        return next == curve[i].end || near(between((next - begin) * scale), shown, tolerances);
    };
    if (last > first + 2 && !holdsAfter((first + last) / 2)) return false;
    for (std::size_t i = first; i < last; ++i)
        if (!holdsAfter(i)) return false;
    return true;
}

}  // namespace

std::array<double, 4> shownBefore(std::span<const DeepPiece> curve, double depth) {
    return CurveReader(curve).before(depth);
}

DeepCurve sumOf(const std::vector<DeepTerm>& terms) {
    if (terms.size() == 1 && terms[0].colour == 1 && terms[0].alpha == 1)
        return {terms[0].curve.begin(), terms[0].curve.end()};
    std::vector<float> depths;
    for (const DeepTerm& term : terms) {
        const auto middle = static_cast<std::ptrdiff_t>(depths.size());
        for (const DeepPiece& piece : term.curve) depths.insert(depths.end(), {piece.begin, piece.end});
        std::inplace_merge(depths.begin(), depths.begin() + middle, depths.end());
    }
    depths.erase(std::unique(depths.begin(), depths.end()), depths.end());
    std::vector<Shown> sums(depths.size(), Shown{});
    for (const DeepTerm& term : terms) {
        CurveReader reader(term.curve);
        for (std::size_t i = 0; i < depths.size(); ++i) {
            const Shown shown = reader.before(depths[i]);
            for (std::size_t c = 0; c < 4; ++c) sums[i][c] += (c < 3 ? term.colour : term.alpha) * shown[c];
        }
    }
    DeepCurve curve;
    for (std::size_t i = 1; i < depths.size(); ++i) {
        if (sums[i] == sums[i - 1]) continue;
        DeepPiece& piece = curve.emplace_back(DeepPiece{depths[i - 1], depths[i], {}});
        for (std::size_t c = 0; c < 4; ++c) piece.shown[c] = static_cast<float>(sums[i][c]);
    }
    return curve;
}

DeepCurve merged(const DeepCurve& curve, double tolerance) {
    if (!(tolerance > 0) || curve.size() < 2) return curve;
    const std::array<float, 4>& all = curve.back().shown;
    const Tolerances tolerances{tolerance * std::max({all[0], all[1], all[2]}), tolerance};
    DeepCurve out;
    for (std::size_t first = 0; first < curve.size();) {
        // The run is doubled as long as one piece can replace it, and then extended by ever smaller steps.
        std::size_t last = first, step = 1;
        for (; last + step < curve.size() && standsFor(curve, first, last + step, tolerances); step *= 2) last += step;
        for (; step > 0; step /= 2)
            if (last + step < curve.size() && standsFor(curve, first, last + step, tolerances)) last += step;
        out.push_back({curve[first].begin, curve[last].end, curve[last].shown});
        first = last + 1;
    }
    return out;
}

DeepCurve tidied(const DeepCurve& curve) {
    // Behind so little transmittance nothing can be distinguished: alpha has 24 bits.
    constexpr float kOpaque = 1 - 1e-4f;
    DeepCurve out;
    for (DeepPiece piece : curve) {
        if (!out.empty()) piece.begin = std::max(piece.begin, out.back().end);
        const bool hidden = !out.empty() && out.back().shown[3] > kOpaque;
        if (!out.empty() && (hidden || !(piece.end > piece.begin))) {
            out.back().shown = piece.shown;
            continue;
        }
        if (!(piece.end > piece.begin)) piece.end = std::nextafter(piece.begin, HUGE_VALF);
        out.push_back(piece);
    }
    return out;
}

std::span<const DeepPiece> DeepImage::curve(int x, int y) const {
    const Row& row = rows[std::size_t(y - window.y0)];
    const auto at = std::size_t(x - window.x0);
    return std::span(row.pieces).subspan(row.first[at], row.first[at + 1] - row.first[at]);
}

std::size_t DeepImage::pieceCount() const {
    std::size_t count = 0;
    for (const Row& row : rows) count += row.pieces.size();
    return count;
}

std::size_t DeepImage::bytes() const {
    std::size_t bytes = rows.capacity() * sizeof(Row);
    for (const Row& row : rows)
        bytes += row.pieces.capacity() * sizeof(DeepPiece) + row.first.capacity() * sizeof(std::uint32_t);
    return bytes;
}

DeepImage deepImage(const PixelWindow& window, const std::function<DeepCurve(int x, int y)>& curveAt) {
    DeepImage image{window, {}};
    image.rows.resize(std::size_t(window.height()));
    parallelFor(image.rows.size(), [&](std::size_t r) {
        DeepImage::Row& row = image.rows[r];
        row.first.push_back(0);
        for (int x = window.x0; x < window.x1; ++x) {
            const DeepCurve curve = curveAt(x, window.y0 + static_cast<int>(r));
            row.pieces.insert(row.pieces.end(), curve.begin(), curve.end());
            row.first.push_back(static_cast<std::uint32_t>(row.pieces.size()));
        }
        row.pieces.shrink_to_fit();
    });
    return image;
}

}  // namespace scrim
