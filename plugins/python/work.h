// SPDX-License-Identifier: Apache-2.0
// Runs work of the library in a thread of its own, so that Python's other threads go on and the waiting thread can
// notice signals.
//
// The worker thread touches no Python object: it stores progress and messages here, and the waiting thread passes them
// to Python.
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

    /// Starts `task`. The objects that it refers to must outlive this object.
    explicit Work(std::function<void(Work&)> task);
    /// Cancels the work and waits for it.
    ~Work();
    Work(const Work&) = delete;
    Work& operator=(const Work&) = delete;

    /// The finished fraction, 0 to 1.
    double progress() const { return m_progress; }
    bool done() const { return m_done; }
    void cancel() { m_cancelled = true; }
    /// Waits for at most `time`; returns true if the work is done. The caller must not hold the interpreter's lock.
    bool waitFor(std::chrono::milliseconds time);
    void join();
    /// Throws whatever the task threw.
    void rethrow() const;
    std::vector<Message> takeMessages();

    // The following are for the task, which passes them to the library.
    ProgressSink progressSink();
    Checkpoint checkpoint();
    MessageSink messageSink();

    /// To be called at the end of the interpreter: cancels everything that still runs and waits for it.
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
