// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/depth_store.h>

#include <scrim/base/error.h>
#include <scrim/guard/load_fields.h>

#include <fmt/format.h>

namespace scrim {
namespace {

[[noreturn]] void refuse(const std::string& file, const std::string& problem) {
    throw Error(ErrorKind::input, fmt::format("cannot read '{}': {}", file, problem));
}

/// Checks that the window that serves as picture has the scene's size, and puts its origin in place.
void place(const SceneHoldout& holdout, const Int2& resolution, FileDepth& depth) {
    if (holdout.dataWindow) {
        depth.x0 = depth.y0 = 0;
        depth.fullWidth = depth.width;
        depth.fullHeight = depth.height;
    }
    if (depth.fullWidth == resolution.x && depth.fullHeight == resolution.y) return;
    throw Error(ErrorKind::input,
                fmt::format("the {} window of '{}' is {} x {}; expected {} x {}, the resolution of the picture",
                            holdout.dataWindow ? "data" : "display", holdout.file, depth.fullWidth, depth.fullHeight,
                            resolution.x, resolution.y));
}

bool areSame(const SceneHoldout& a, const SceneHoldout& b) {
    return a.file == b.file && a.channel == b.channel && a.alongRay == b.alongRay && a.background == b.background &&
           a.dataWindow == b.dataWindow;
}

}  // namespace

void DepthStore::loadInto(Scene& scene, const LoadOptions& load, const Checkpoint& checkpoint) {
    SceneHoldout& holdout = scene.output.holdout;
    if (holdout.file.empty()) {  // there is none, or it was made in code
        m_known = {};
        return;
    }
    if (!areSame(m_known, holdout) || scene.camera.resolution != m_resolution) m_known = {};
    try {
        if (!m_known.picture) {
            FileDepth depth = readDepth(holdout.file, holdout.channel, load, checkpoint);
            if (!depth.problem.empty()) refuse(holdout.file, shortened(depth.problem, 1000));
            place(holdout, scene.camera.resolution, depth);
            m_known = holdout;
            m_resolution = scene.camera.resolution;
            m_known.picture =
                std::make_shared<const DepthPicture>(depthPictureOf(depth, {holdout.alongRay, holdout.background}));
        }
    } catch (const Error& error) {
        if (error.kind() == ErrorKind::interrupted) throw;
        const std::string where = holdout.where.empty() ? "" : holdout.where + ": ";
        throw Error(error.kind(), fmt::format("{}holdout: {}", where, error.what()));
    }
    holdout.picture = m_known.picture;
}

}  // namespace scrim
