// SPDX-License-Identifier: Apache-2.0
#include "info_text.h"

#include <scrim/base/error.h>
#include <scrim/geometry/bounds.h>

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <map>
#include <tuple>
#include <utility>

#include <glm/geometric.hpp>

namespace scrim::cli {
namespace {

std::string vectorText(const Vec3& v) {
    return fmt::format("[{:.6g}, {:.6g}, {:.6g}]", v.x, v.y, v.z);
}
std::string vectorText(const Int3& v) {
    return fmt::format("[{}, {}, {}]", v.x, v.y, v.z);
}

bool isEmpty(const GridInfo& grid) {
    return grid.isUpper.x < grid.isLower.x;
}

std::string boundsText(const GridInfo& grid) {
    if (isEmpty(grid)) return "empty";
    const auto size = [&](int axis) { return std::int64_t{grid.isUpper[axis]} - grid.isLower[axis] + 1; };
    return fmt::format("{} to {} ({} x {} x {})", vectorText(grid.isLower), vectorText(grid.isUpper), size(0), size(1),
                       size(2));
}

/// World-space box around the cells of the active voxels.
Bounds wsBounds(const GridInfo& grid) {
    if (isEmpty(grid) || !grid.affine) return {};
    return transformed(grid.wsFromIs, {Vec3(grid.isLower) - 0.5, Vec3(grid.isUpper) + 0.5});
}

std::string boundsText(const Bounds& ws) {
    if (ws.empty()) return "empty";
    return fmt::format("{} to {} ({:.6g} x {:.6g} x {:.6g})", vectorText(ws.lower), vectorText(ws.upper), ws.size().x,
                       ws.size().y, ws.size().z);
}

void addRow(std::string& text, const char* name, const std::string& value) {
    text += fmt::format("    {:<14} {}\n", name, value);
}

std::string gridText(const GridInfo& g) {
    std::string text = fmt::format("\n  grid '{}'\n", shortened(g.name));
    const auto row = [&text](const char* name, const std::string& value) { addRow(text, name, value); };
    row("type", g.valueType + (g.savedAsHalf ? ", saved as half" : ""));
    row("class", g.gridClass);
    if (!g.problem.empty()) {
        row("not read", g.problem);
        return text;
    }
    if (g.points > 0 || !g.attributes.empty()) {
        row("points", fmt::format("{}", g.points));
        row("radii", g.maxValue > 0 ? fmt::format("{:.6g} to {:.6g}", g.minValue, g.maxValue)
                                    : "none (pscale, radius or width)");
        row("attributes", g.attributes.empty() ? "none" : g.attributes);
        row("world bounds", boundsText(Bounds{g.wsLower, g.wsUpper}));
        row("usable", "as balls of their radii");
        return text;
    }
    row("active voxels", fmt::format("{}, and {} tiles", g.activeVoxels, g.activeTiles));
    row("voxel size", vectorText(g.voxelSize) + (g.affine ? "" : " in the middle (not affine)"));
    row("bounds", boundsText(g));
    if (g.affine) {
        row("world bounds", boundsText(wsBounds(g)));
        row("translation", vectorText(Vec3(g.wsFromIs[3])));
    }
    if (g.usable) {
        row("values", fmt::format("{:.6g} to {:.6g}", g.minValue, g.maxValue));
        row("NaN or inf", fmt::format("{}", g.nonFinite));
        row("negative", fmt::format("{}", g.negative));
    }
    row("codec", g.codec.empty() ? "unknown" : g.codec);
    if (g.colour) row("usable", "as a colour");
    if (!g.usable && !g.colour) row("usable", "no: neither numbers nor vectors of them");
    return text;
}

/// One grid of a sequence, over all frames.
struct GridRange {
    std::string valueType;
    std::size_t files = 0;
    std::uint64_t fewest = ~std::uint64_t{0}, most = 0;  ///< active voxels
    Bounds ws;
    bool affine = true, usable = false;
    double least = 0, largest = 0;
    int leastFrame = 0, largestFrame = 0;
    std::uint64_t nonFinite = 0, negative = 0;
    bool valued = false;

    void add(const GridInfo& g, int frame) {
        ++files;
        valueType = g.valueType;
        fewest = std::min(fewest, g.activeVoxels);
        most = std::max(most, g.activeVoxels);
        ws.include(wsBounds(g));
        affine = affine && g.affine;
        usable = usable || g.usable;
        nonFinite += g.nonFinite;
        negative += g.negative;
        if (!g.usable || isEmpty(g)) return;
        if (!valued || g.minValue < least) std::tie(least, leastFrame) = std::pair(g.minValue, frame);
        if (!valued || g.maxValue > largest) std::tie(largest, largestFrame) = std::pair(g.maxValue, frame);
        valued = true;
    }
};

std::string rangeText(const std::string& name, const GridRange& g, std::size_t files) {
    std::string text = fmt::format("\n  grid '{}'\n", shortened(name));
    const auto row = [&text](const char* of, const std::string& value) { addRow(text, of, value); };
    row("type", g.valueType);
    row("in", g.files == files ? "all files" : fmt::format("{} of {} files", g.files, files));
    row("active voxels", fmt::format("{} to {}", g.fewest, g.most));
    if (g.affine) row("world bounds", boundsText(g.ws));
    if (g.valued)
        row("values",
            fmt::format("{:.6g} (frame {}) to {:.6g} (frame {})", g.least, g.leastFrame, g.largest, g.largestFrame));
    if (g.usable) {
        row("NaN or inf", fmt::format("{}", g.nonFinite));
        row("negative", fmt::format("{}", g.negative));
    }
    return text;
}

}  // namespace

std::string infoText(const VdbFileInfo& info) {
    std::string text = fmt::format("{}\n  {:<16} {}\n  {:<16} ", info.path, "bytes", info.fileBytes, "file version");
    text += !info.pointFormat.empty() ? fmt::format("points of {}\n", info.pointFormat)
            : info.isNano
                ? fmt::format("NanoVDB {}.{}\n", info.libraryMajor, info.libraryMinor)
                : fmt::format("{}, written by OpenVDB {}.{}\n", info.fileVersion, info.libraryMajor, info.libraryMinor);
    for (const auto& [name, value] : info.metadata) text += fmt::format("  {:<16} {}\n", name, value);
    for (const GridInfo& grid : info.grids) text += gridText(grid);
    return text;
}

std::string sequenceText(const std::string& pattern, const std::vector<int>& frames,
                         const std::vector<VdbFileInfo>& files) {
    std::uint64_t bytes = 0;
    std::vector<std::string> names;  // in the order of their first appearance
    std::map<std::string, GridRange> ranges;
    for (std::size_t i = 0; i < files.size(); ++i) {
        bytes += files[i].fileBytes;
        std::map<std::string, int> seen;  // grids that share a name within a file are counted separately
        for (const GridInfo& grid : files[i].grids) {
            const int before = seen[grid.name]++;
            const std::string name = before == 0 ? grid.name : fmt::format("{}[{}]", grid.name, before);
            if (!ranges.contains(name)) names.push_back(name);
            ranges[name].add(grid, frames[i]);
        }
    }
    std::string text = fmt::format(
        "{}\n  {:<16} {}, frames {} to {}{}\n  {:<16} {} in all\n", pattern, "files", files.size(), frames.front(),
        frames.back(), frames.back() - frames.front() + 1 == static_cast<int>(frames.size()) ? "" : ", with gaps",
        "bytes", bytes);
    for (const std::string& name : names) text += rangeText(name, ranges.at(name), files.size());
    return text;
}

std::string infoText(const ScanInfo& info) {
    constexpr int kColumns = 60, kRows = 6;
    const Mat3 axes(info.wsFromIs);
    const ScanMaterials materials = materialsOf(info);
    std::string text = fmt::format("{}\n  {:<16} {}\n", info.path, "bytes", info.fileBytes);
    const auto row = [&text](const char* name, const std::string& value) {
        text += fmt::format("  {:<16} {}\n", name, value);
    };
    row("samples", fmt::format("{} x {} x {} of {}", info.size.x, info.size.y, info.size.z, info.sampleType));
    const std::string spacing = vectorText(Vec3(glm::length(axes[0]), glm::length(axes[1]), glm::length(axes[2])));
    row("spacing",
        spacing + (info.unit.empty() ? "" : " " + info.unit) + (info.isSpaced ? "" : ", since the file does not say"));
    if (info.sampleType.starts_with("RGB of "))
        row("colours", "albedo = { grid = \"color\", colorspace = \"lin_rec709\" } takes them");
    row("space", info.space.empty() ? "the file does not say" : info.space);
    row("world bounds", boundsText(transformed(info.wsFromIs, {Vec3(-0.5), Vec3(info.size) - 0.5})));
    row("translation", vectorText(Vec3(info.wsFromIs[3])));
    row("values", fmt::format("{:.6g} to {:.6g}{}", info.minValue, info.maxValue,
                              materials.hounsfield ? ", probably Hounsfield units" : ""));
    text += fmt::format("\n{}\n", histogramText(info, kColumns, kRows));
    const std::string least = fmt::format("{:.5g}", info.minValue), most = fmt::format("{:.5g}", info.maxValue);
    text += fmt::format("{}{:>{}}\n", least, most, kColumns - static_cast<int>(least.size()));
    std::string marks(kColumns, ' ');
    for (const auto& [value, mark] : {std::pair(materials.soft, 'a'), std::pair(materials.solid, 'b')}) {
        const double part =
            info.maxValue > info.minValue ? (value - info.minValue) / (info.maxValue - info.minValue) : 0;
        marks[static_cast<std::size_t>(std::clamp(part * kColumns, 0.0, kColumns - 1.0))] = mark;
    }
    marks.erase(marks.find_last_not_of(' ') + 1);
    text += fmt::format("{}\n  (heights by the logarithm of the count)\n\n", marks);
    row("a  veil from", fmt::format("{:.4g}", materials.soft));
    row("b  surface from", fmt::format("{:.4g}{}", materials.solid, materials.hounsfield ? "" : " (by the histogram)"));
    return text + fmt::format("\n  scrim render {} -o picture.exr --preview picture.png\n", info.path);
}

}  // namespace scrim::cli
