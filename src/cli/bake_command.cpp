// SPDX-License-Identifier: Apache-2.0
#include "bake_command.h"

#include "console.h"
#include "progress.h"
#include "scene_input.h"

#include <scrim/base/atomic_file.h>
#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/scene/frame_path.h>
#include <scrim/shot/bake_shot.h>
#include <scrim/shot/shot_files.h>
#include <scrim/shot/shot_text.h>
#include <scrim/volume/vdb_write.h>

#include <fmt/format.h>

#include <cstdlib>
#include <filesystem>

namespace scrim::cli {
namespace {

/// "'key' (float), 'rim' (vec3s); 1,234 active voxels".
std::string gridsText(const std::vector<VdbGrid>& grids) {
    std::string text;
    std::size_t voxels = 0;
    for (const VdbGrid& grid : grids) {
        text += fmt::format("{}'{}' ({})", text.empty() ? "" : ", ", grid.name, grid.colour ? "vec3s" : "float");
        for (const auto& active : grid.active) voxels += active.count();
    }
    return text + fmt::format("; {} active voxels in all", voxels);
}

/// The one input, and the path of its frames.
SceneInput inputOf(const SceneOptions& options) {
    if (options.inputs.size() > 1) throw Error(ErrorKind::usage, "bake: expected one scene, since there is one output");
    if (options.crop) throw Error(ErrorKind::usage, "--crop: light is baked at voxels, not at pixels; remove --crop");
    if (options.baked.empty() && !options.printScene)
        throw Error(ErrorKind::usage, "bake: expected -o LIGHT.vdb, the file to write");
    if (!options.printScene && lowerExtension(options.baked) != ".vdb")
        throw Error(ErrorKind::usage, fmt::format("the output '{}' does not end in '.vdb'", shortened(options.baked)));
    std::vector<SceneInput> inputs = openInputs(options);
    if (inputs.size() > 1)
        throw Error(ErrorKind::usage, "bake: the stage changes between these frames; bake them one by one");
    return std::move(inputs.front());
}

void claim(const SceneInput& input, const SceneOptions& options, const FramePath& output) {
    FileClaims claims;
    const std::vector<int>& frames = input.frames();
    if (frames.size() > 1 && !output.outputHasFrame())
        throw Error(
            ErrorKind::usage,
            fmt::format("all {} frames would be written to '{}'; put the frame into its name: {}", frames.size(),
                        output.pattern, std::filesystem::path(output.pattern).replace_extension(".####.vdb").string()));
    const char* const environment = std::getenv("OCIO");
    claims.reads(options.ocio.empty() && environment != nullptr ? environment : options.ocio, "the OpenColorIO config");
    for (const SceneFile& file : filesReadBy(input.shot(), frames)) claims.reads(file.path, file.role);
    for (const int frame : frames) {
        claims.writesAlone(output.outputAt(frame), "--output");
        const AtomicFile probe(output.outputAt(frame));
    }
    for (const std::string& folder : claims.folders()) removeAbandonedFiles(folder);
}

void bake(const SceneOptions& options) {
    Console console(options.verbose, options.quiet);
    SceneInput input = inputOf(options);
    if (options.printScene) return printOut(input.printedToml(renderOptionsOf(options, console.sink())));
    const FramePath output = pathFrom("--output", options.baked);
    claim(input, options, output);
    Progress progress(options.progress, console);
    progress.setFrameCount(static_cast<int>(input.frames().size()));
    const BakeRequest request{options.bakedLights, options.emission, options.indirect};
    for (const int frame : input.frames()) {
        progress.beginFrame(frame);
        RenderOptions baking = renderOptionsOf(options, console.sink());
        baking.progress = progress.stage(0, 1);
        baking.change = [&input](Scene& scene) { input.change(scene); };
        const BakedShot baked = bakeShot(input.shot(), frame, request, baking);
        progress.endFrame();
        if (baked.skipped) continue;
        const std::string path = output.outputAt(frame);
        writeVdbGrids(path, baked.grids, baked.metadata);
        console.line(fmt::format("frame {}: {}: {}", frame, path, gridsText(baked.grids)));
    }
}

}  // namespace

void bakeCommand(const SceneOptions& options) {
    TaskArena(options.threads).run([&] { bake(options); });
}

}  // namespace scrim::cli
