// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/shot_frame.h>

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/base/system_error.h>
#include <scrim/base/timed.h>
#include <scrim/scene/frame_path.h>
#include <scrim/shot/frame_output.h>
#include <scrim/shot/frame_report.h>
#include <scrim/shot/shot_text.h>

#include <fmt/format.h>

#include <set>
#include <utility>

namespace scrim {
namespace {

void checkExr(const std::string& file, const std::string& what) {
    if (lowerExtension(file) != ".exr")
        throw Error(ErrorKind::usage, fmt::format("the {} '{}' does not end in '.exr'", what, shortened(file)));
}

void warnOfClamped(std::size_t values, const std::string& file, const std::string& key, const MessageSink& messages) {
    if (values > 0)
        notify(messages, Severity::warning,
               fmt::format("{}: {} values beyond the range of half floats were clamped; {} = \"float\" keeps them",
                           file, values, key));
}

/// Runs `task` with `threads` threads. Whatever it throws becomes an Error.
template <typename Task>
void withThreads(int threads, const Task& task) {
    withErrors([&] { TaskArena(threads).run(task); });
}

}  // namespace

ShotFrame::ShotFrame(std::unique_ptr<Content> content) : m_content(std::move(content)) {}
ShotFrame::ShotFrame(ShotFrame&&) noexcept = default;
ShotFrame& ShotFrame::operator=(ShotFrame&&) noexcept = default;
ShotFrame::~ShotFrame() = default;

bool ShotFrame::skipped() const {
    return m_content->skipped;
}
const Image& ShotFrame::image() const {
    return m_content->image;
}
const ShotReport& ShotFrame::report() const {
    return m_content->report;
}

std::vector<std::string> ShotFrame::layerNames() const {
    std::vector<std::string> names;
    for (const ShotLayer& layer : m_content->layers) names.push_back(layer.name);
    return names;
}

const ShotLayer& ShotFrame::layer(const std::string& name) const {
    for (const ShotLayer& layer : m_content->layers)
        if (layer.name == name) return layer;
    throw Error(ErrorKind::usage,
                fmt::format("the frame has no layer '{}'; expected {}", shortened(name, 80), choices(layerNames())));
}

void ShotFrame::requirePicture() const {
    if (skipped())
        throw Error(ErrorKind::usage, fmt::format("frame {} was skipped: there is no picture", report().frame));
}

std::string ShotFrame::pathOf(const std::string& path, const std::string& fromScene, const std::string& what) const {
    requirePicture();
    if (!path.empty()) return expandFrame(path, report().frame);
    if (fromScene.empty()) throw Error(ErrorKind::usage, fmt::format("the scene has no name for the {}", what));
    return fromScene;
}

void ShotFrame::write(const std::string& path, const MessageSink& messages) {
    ShotReport& report = m_content->report;
    const SceneOutput& output = m_content->scene.output;
    const std::string file = pathOf(path, output.file, "picture");
    checkExr(file, "picture");
    std::set<std::string> written{file};
    for (const OutputFile& more : output.files)
        if (path.empty() && !written.insert(more.file).second)
            throw Error(ErrorKind::usage, fmt::format("'{}' would be written twice", more.file));
    const auto write = [&](const OutputFile& what, const std::string& to) {
        withThreads(report.threads, [&] {
            const std::size_t clamped = timed(report.seconds.write, [&] { return writeFrame(*m_content, what, to); });
            warnOfClamped(clamped, to, "type", messages);
        });
    };
    OutputFile all = output;
    if (!path.empty()) all.layers = output.allLayers();
    write(all, file);
    report.file = file;
    for (const OutputFile& more : output.files)
        if (path.empty()) write(more, more.file);
    report.peakBytes = peakResidentBytes();
}

bool ShotFrame::hasDeep() const {
    return m_content->deep.has_value();
}

void ShotFrame::writeDeep(const std::string& path, const MessageSink& messages) {
    ShotReport& report = m_content->report;
    const std::string file = pathOf(path, m_content->scene.output.deep.file, "deep picture");
    checkExr(file, "deep picture");
    if (!hasDeep()) throw Error(ErrorKind::usage, "the frame has no deep picture: the scene does not request one");
    withThreads(report.threads, [&] {
        const std::size_t clamped = timed(report.seconds.write, [&] { return writeFrameDeep(*m_content, file); });
        warnOfClamped(clamped, file, "deep_type", messages);
    });
    report.peakBytes = peakResidentBytes();
}

Image ShotFrame::backplate() const {
    return backplateOf(*m_content);
}

void ShotFrame::preview(const std::string& path) {
    ShotReport& report = m_content->report;
    const std::string file = pathOf(path, m_content->scene.output.preview.file, "preview");
    withThreads(report.threads, [&] { timed(report.seconds.write, [&] { writeFramePreview(*m_content, file); }); });
    report.peakBytes = peakResidentBytes();
}

}  // namespace scrim
