// SPDX-License-Identifier: Apache-2.0
#include "describe.h"

#include "edit.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

namespace scan {
namespace {

constexpr int kMostBins = 4096;  // 12 bits: CT scans get a bin for each value

struct Histogram {
    double first = 0, width = 1;  // centre of the first bin
    std::vector<double> counts;
};

Histogram histogramOf(const Scan& scan) {
    const auto [least, most] = range(scan);
    const bool whole = scan.type.find("int") != std::string::npos && least == std::floor(least);
    Histogram out;
    out.first = least;
    int bins = 1;
    if (most > least) {
        bins = whole ? static_cast<int>(std::min(most - least + 1, double(kMostBins))) : kMostBins;
        out.width = (most - least) / (bins - 1);
    }
    out.counts.resize(static_cast<std::size_t>(bins));
    for (const float v : scan.values) {
        if (!std::isfinite(v)) continue;
        const auto bin = static_cast<int>(std::lround((double(v) - least) / out.width));
        ++out.counts[static_cast<std::size_t>(std::clamp(bin, 0, bins - 1))];
    }
    return out;
}

int emit(const scrim_host* host, const Histogram& histogram) {
    const double worldFromIndex[16] = {histogram.width, 0, 0, histogram.first, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};
    const int grid = host->add_grid(host, "histogram", worldFromIndex);
    if (grid < 0) return grid;
    for (std::size_t x = 0; x < histogram.counts.size(); x += 8) {
        std::array<float, 512> values{};
        for (std::size_t i = x; i < std::min(x + 8, histogram.counts.size()); ++i)
            values[(i - x) * 64] = static_cast<float>(histogram.counts[i]);
        const std::int32_t origin[3] = {static_cast<std::int32_t>(x), 0, 0};
        if (const int error = host->add_block(host, grid, origin, values.data()); error != 0) return error;
    }
    return 0;
}

int emitCorners(const scrim_host* host, const Scan& scan) {
    double worldFromIndex[16];
    worldFromIndexOf(scan, worldFromIndex);
    const std::string unit = scan.isSpaced ? scan.unit : "unknown steps";
    const std::string name =
        "samples of " + scan.type + (unit.empty() ? "" : " in " + unit) + (scan.space.empty() ? "" : ", " + scan.space);
    const int grid = host->add_grid(host, name.c_str(), worldFromIndex);
    if (grid < 0) return grid;
    std::int32_t last[3], origin[3], inside[3];
    bool apart = false;
    for (std::size_t k = 0; k < 3; ++k) {
        last[k] = static_cast<std::int32_t>(scan.size[k] - 1);
        inside[k] = last[k] % 8;
        origin[k] = last[k] - inside[k];
        apart = apart || origin[k] != 0;
    }
    std::array<float, 512> values{};
    values[0] = 1;
    if (apart) {
        const std::int32_t zero[3] = {0, 0, 0};
        if (const int error = host->add_block(host, grid, zero, values.data()); error != 0) return error;
        values[0] = 0;
    }
    values[static_cast<std::size_t>((inside[0] * 8 + inside[1]) * 8 + inside[2])] = 1;
    return host->add_block(host, grid, origin, values.data());
}

}  // namespace

int describe(const scrim_host* host, const Scan& scan) {
    if (const int error = emit(host, histogramOf(scan)); error != 0) return error;
    return emitCorners(host, scan);
}

}  // namespace scan
