// SPDX-License-Identifier: Apache-2.0
// A job renders frames of a run, one after the other. Several jobs may do so side by side.
#pragma once

#include "display_server.h"
#include "options.h"
#include "progress.h"
#include "run_reports.h"
#include "scene_input.h"

#include <atomic>
#include <cstddef>
#include <future>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

namespace scrim::cli {

/// What the jobs of a run share.
struct RenderRun {
    Console& console;
    Progress& progress;
    RunReports& reports;
    int jobs = 1;
    std::atomic<bool> stopped = false;  ///< no job begins another frame
};

/// A frame whose files are written while the next one is rendered.
struct FrameBeingWritten {
    const SceneInput* input;
    std::size_t place;
    ShotFrame frame;
    std::vector<std::pair<Severity, std::string>> messages = {};
    std::future<void> done = {};  // the last member: its destructor waits for the thread
};

class RenderJob {
  public:
    /// `options`: with the threads and the memory of this job. `inputs`: all of the run, for this job alone. `number`:
    /// of the job, from 0 on; of the frames of all inputs, it renders every run.jobs-th, from this one on. All must
    /// outlive the job.
    RenderJob(RenderRun& run, const SceneOptions& options, std::vector<SceneInput>& inputs, int number)
        : m_run(run), m_options(options), m_inputs(inputs), m_number(number) {}

    /// Shows pictures on a server while they are made.
    void showOn(DisplayServer& display) { m_display = &display; }

    /// Renders all frames of the job, and writes their files. What throws ends the job; a frame that was rendered
    /// before is still written.
    void render();

  private:
    /// A frame of the run.
    struct Task {
        SceneInput* input;
        int frame;
        std::size_t place;  ///< in the order of the run
    };

    std::vector<Task> tasks();
    bool existsAlready(const SceneInput& input, int frame);
    bool hasPreview(const std::string& path) const;
    void completeFrame(SceneInput& input, int frame);
    void renderFrame(const std::vector<Task>& tasks, std::size_t i);
    std::optional<int> frameAfter(const std::vector<Task>& tasks, std::size_t i);
    RenderOptions optionsOf(const SceneInput& input, int frame, std::optional<int> next);
    void announce(int frame, double seconds);
    static void write(const SceneInput& input, ShotFrame& frame, const MessageSink& messages);
    bool mayWriteBeside(const SceneInput& input, const ShotFrame& frame) const;
    void finishWriting();
    void warnOfLostDisplay();

    RenderRun& m_run;
    const SceneOptions& m_options;
    std::vector<SceneInput>& m_inputs;
    int m_number;
    std::set<std::string> m_whole;       // pictures that existed before
    DisplayServer* m_display = nullptr;  // null: none, or it was lost
    std::unique_ptr<FrameBeingWritten> m_beside;
};

}  // namespace scrim::cli
