// SPDX-License-Identifier: Apache-2.0
#include "info_command.h"

#include "console.h"
#include "internal_load.h"
#include "interrupt.h"

#include <scrim/base/error.h>
#include <scrim/volume/load_fields.h>
#include <scrim/volume/vdb_info_text.h>

#include <fmt/format.h>

namespace scrim::cli {
namespace {

std::string vectorText(const Vec3& v) {
    return fmt::format("[{:.6g}, {:.6g}, {:.6g}]", v.x, v.y, v.z);
}
std::string vectorText(const Int3& v) {
    return fmt::format("[{}, {}, {}]", v.x, v.y, v.z);
}

std::string boundsText(const GridInfo& grid) {
    if (grid.isUpper.x < grid.isLower.x) return "empty";
    const Int3 size = grid.isUpper - grid.isLower + 1;
    return fmt::format("{} to {} ({} x {} x {})", vectorText(grid.isLower), vectorText(grid.isUpper), size.x, size.y,
                       size.z);
}

std::string gridText(const GridInfo& g) {
    std::string text = fmt::format("\n  grid '{}'\n", shortened(g.name));
    const auto row = [&text](const char* name, const std::string& value) {
        text += fmt::format("    {:<14} {}\n", name, value);
    };
    row("type", g.valueType + (g.savedAsHalf ? ", saved as half" : ""));
    row("class", g.gridClass);
    row("active voxels", fmt::format("{}, and {} tiles", g.activeVoxels, g.activeTiles));
    row("voxel size", vectorText(g.voxelSize) + (g.affine ? "" : " in the middle (not affine)"));
    row("bounds", boundsText(g));
    if (g.usable) {
        row("values", fmt::format("{:.6g} to {:.6g}", g.minValue, g.maxValue));
        row("NaN or inf", fmt::format("{}", g.nonFinite));
        row("negative", fmt::format("{}", g.negative));
    }
    row("codec", g.codec.empty() ? "unknown" : g.codec);
    if (g.colour) row("usable", "as a colour");
    if (!g.usable && !g.colour) row("usable", "no: not float, half or double");
    return text;
}

std::string fileText(const VdbFileInfo& info) {
    std::string text =
        fmt::format("{}\n  {:<16} {}\n  {:<16} {}, written by OpenVDB {}.{}\n", info.path, "bytes", info.fileBytes,
                    "file version", info.fileVersion, info.libraryMajor, info.libraryMinor);
    for (const auto& [name, value] : info.metadata) text += fmt::format("  {:<16} {}\n", name, value);
    for (const GridInfo& grid : info.grids) text += gridText(grid);
    return text;
}

}  // namespace

void infoCommand(const InfoOptions& options) {
    const LoadOptions loading = guardedLoading(0, 0, options.verbose);
    std::string text;
    for (const std::string& file : options.files) {
        const VdbFileInfo info = loadInfo(file, loading, throwIfInterrupted);
        if (!text.empty()) text += options.json ? ",\n" : "\n";
        text += options.json ? toJson(info) : fileText(info);
    }
    if (options.json) text = (options.files.size() > 1 ? "[" + text + "]" : text) + "\n";
    printOut(text);
}

}  // namespace scrim::cli
