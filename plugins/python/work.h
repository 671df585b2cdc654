// SPDX-License-Identifier: Apache-2.0
// Work of the library in a thread of its own, so that Python's threads go on, and whoever waits for it hears of
// signals.
//
// No object of Python is touched in that thread: it leaves progress and messages here, and the thread that waits takes
// them to Python.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/shot/shot_options.h>

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <string>
#include <thread>
#include <utility>
#include <vector>

namespace scrim::python {

class Work {
  public:
    using Message = std::pair<Severity, std::string>;

    /// Starts `task`. It must not outlive what it refers to.
    explicit Work(std::function<void(Work&)> task);
    /// Cancels it and waits.
    ~Work();
    Work(const Work&) = delete;
    Work& operator=(const Work&) = delete;

    /// The finished part, 0 to 1.
    double progress() const { return m_progress; }
    bool done() const { return m_done; }
    void cancel() { m_cancelled = true; }
    /// Whether it is done. Never holds the interpreter's lock: neither must the caller.
    bool waitFor(std::chrono::milliseconds time);
    void join();
    /// Throws what the task threw.
    void rethrow() const;
    std::vector<Message> takeMessages();

    // For the task: what it hands to the library.
    ProgressSink progressSink();
    Checkpoint checkpoint();
    MessageSink messageSink();

    /// At the end of the interpreter: all that still runs is cancelled and waited for.
    static void endAll();

  private:
    void run(const std::function<void(Work&)>& task);

    std::atomic<double> m_progress{0};
    std::atomic<bool> m_cancelled{false}, m_done{false};
    std::mutex m_mutex, m_joining;
    std::condition_variable m_ended;
    std::vector<Message> m_messages;
    std::exception_ptr m_error;
    std::thread m_thread;
};

}  // namespace scrim::python
