// SPDX-License-Identifier: Apache-2.0
#include "merge_command.h"

#include "console.h"
#include "file_claims.h"
#include "interrupt.h"

#include <scrim/base/atomic_file.h>
#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/image/exr.h>
#include <scrim/image/exr_merge.h>
#include <scrim/image/whole_picture.h>
#include <scrim/shot/shot_text.h>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace scrim::cli {
namespace {

/// Names the incomplete pictures, one on each line, and fails where there are any.
void check(const MergeOptions& options) {
    std::size_t broken = 0;
    for (const std::string& path : options.tiles) {
        throwIfInterrupted();
        if (isWholeExr(path)) continue;
        ++broken;
        printOut(path + "\n");
    }
    flushOut();
    if (broken > 0)
        throw Error(ErrorKind::input,
                    fmt::format("{} of {} pictures are missing or incomplete", broken, options.tiles.size()));
}

void merge(const MergeOptions& options) {
    if (options.output.empty()) throw Error(ErrorKind::usage, "merge: expected -o WHOLE.exr, the file to write");
    if (lowerExtension(options.output) != ".exr")
        throw Error(ErrorKind::usage, fmt::format("the output '{}' does not end in '.exr'", shortened(options.output)));
    FileClaims claims;
    for (const std::string& tile : options.tiles) claims.reads(tile, "the tile");
    claims.writesAlone(options.output, "--output");
    for (const std::string& folder : claims.folders()) removeAbandonedFiles(folder);
    setExrThreads(threadCount());
    const MergedExr merged = mergeExr(options.tiles, options.output, options.compression, throwIfInterrupted);
    Console console(false, options.quiet);
    if (merged.lossyTwice)
        console.warning(
            fmt::format("{}: the tiles have lossy compression, which is applied once more; render tiles with lossless "
                        "compression, and merge them with --compression dwaa",
                        options.output));
    if (!merged.notFinite.empty())
        console.warning(fmt::format("{}: contains infinite or NaN values, which come from '{}'", options.output,
                                    shortened(merged.notFinite)));
    if (!merged.leftOut.empty())
        console.warning(fmt::format("{}: dropped attributes that describe single tiles: {}", options.output,
                                    fmt::join(merged.leftOut, ", ")));
    const PixelWindow& window = merged.window;
    console.line(fmt::format("{}: {} {} tiles, {} x {} pixels at {},{}", options.output, options.tiles.size(),
                             merged.deep ? "deep" : "flat", window.width(), window.height(), window.x0, window.y0));
}

}  // namespace

void mergeCommand(const MergeOptions& options) {
    if (options.check && !options.output.empty()) throw Error(ErrorKind::usage, "--check writes nothing; remove -o");
    options.check ? check(options) : merge(options);
}

}  // namespace scrim::cli
