// SPDX-License-Identifier: Apache-2.0
#include "edit.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace scan {
namespace {

/// A scan of which all but size, place and samples is that of `scan`.
Scan alike(const Scan& scan) {
    Scan out;
    out.type = scan.type;
    out.space = scan.space;
    out.unit = scan.unit;
    out.isSpaced = scan.isSpaced;
    return out;
}

/// Makes the values of `out`, and its colours, of those of `scan`: `made` makes one vector of one.
template <typename Make>
void makeAll(const Scan& scan, const Make& made, Scan& out) {
    out.values = made(scan.values);
    for (std::size_t c = 0; c < 3; ++c)
        if (!scan.colours[c].empty()) out.colours[c] = made(scan.colours[c]);
}

}  // namespace

Scan cropped(const Scan& scan, const Size& from, const Size& to) {
    Scan out = alike(scan);
    for (std::size_t k = 0; k < 3; ++k) out.size[k] = to[k] - from[k];
    out.axes = scan.axes;
    out.origin = scan.origin + scan.axes * glm::dvec3(from[0], from[1], from[2]);
    const auto made = [&](const std::vector<float>& all) {
        std::vector<float> kept;
        kept.reserve(static_cast<std::size_t>(out.size[0] * out.size[1] * out.size[2]));
        for (std::int64_t z = from[2]; z < to[2]; ++z)
            for (std::int64_t y = from[1]; y < to[1]; ++y) {
                const auto row = all.begin() + static_cast<std::ptrdiff_t>(scan.indexOf(from[0], y, z));
                kept.insert(kept.end(), row, row + static_cast<std::ptrdiff_t>(out.size[0]));
            }
        return kept;
    };
    makeAll(scan, made, out);
    return out;
}

Scan halved(const Scan& scan, int axis) {
    const auto a = static_cast<std::size_t>(axis);
    Scan out = alike(scan);
    out.size = scan.size;
    out.size[a] = (scan.size[a] + 1) / 2;
    out.axes = scan.axes;
    out.origin = scan.origin;
    if (scan.size[a] > 1) {
        out.axes[axis] *= 2.0;
        out.origin += 0.5 * scan.axes[axis];
    }
    const auto made = [&](const std::vector<float>& all) {
        std::vector<float> means;
        means.reserve(static_cast<std::size_t>(out.size[0] * out.size[1] * out.size[2]));
        Size p{};
        for (p[2] = 0; p[2] < out.size[2]; ++p[2])
            for (p[1] = 0; p[1] < out.size[1]; ++p[1])
                for (p[0] = 0; p[0] < out.size[0]; ++p[0]) {
                    Size first = p;
                    first[a] *= 2;
                    Size second = first;
                    second[a] = std::min(second[a] + 1, scan.size[a] - 1);
                    means.push_back(0.5f * all[scan.indexOf(first[0], first[1], first[2])] +
                                    0.5f * all[scan.indexOf(second[0], second[1], second[2])]);
                }
        return means;
    };
    makeAll(scan, made, out);
    return out;
}

void map(Scan& scan, const Mapping& mapping) {
    double least =
        mapping.keepsUnits && mapping.window ? std::max(mapping.threshold, (*mapping.window)[0]) : mapping.threshold;
    if (mapping.offset != 0) least = std::max(least, -mapping.offset);
    for (float& value : scan.values) {
        if (value <= least) {
            value = 0;
            continue;
        }
        double v = value;
        if (mapping.window && !std::isnan(v)) {
            const auto& [low, high] = *mapping.window;
            v = mapping.keepsUnits ? std::clamp(v, low, high) : std::clamp((v - low) / (high - low), 0.0, 1.0);
        }
        value = static_cast<float>((v + mapping.offset) * mapping.scale);
    }
}

std::array<double, 2> range(const Scan& scan) {
    double least = std::numeric_limits<double>::infinity(), most = -least;
    for (const float v : scan.values)
        if (std::isfinite(v)) {
            least = std::min<double>(least, v);
            most = std::max<double>(most, v);
        }
    return least <= most ? std::array{least, most} : std::array{0.0, 0.0};
}

}  // namespace scan
