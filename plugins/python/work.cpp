// SPDX-License-Identifier: Apache-2.0
#include "work.h"

#include <scrim/base/error.h>

#include <set>

namespace scrim::python {
namespace {

std::mutex g_mutex;
std::set<Work*>& running() {
    static std::set<Work*>* const all = new std::set<Work*>;  // never destroyed, since jobs may outlive static objects
    return *all;
}

}  // namespace

Work::Work(std::function<void(Work&)> task) : m_thread([this, task = std::move(task)] { run(task); }) {
    const std::scoped_lock lock(g_mutex);
    running().insert(this);
}

Work::~Work() {
    {
        const std::scoped_lock lock(g_mutex);
        running().erase(this);
    }
    cancel();
    join();
}

void Work::run(const std::function<void(Work&)>& task) {
    std::exception_ptr error;
    try {
        task(*this);
    } catch (...) {
        error = std::current_exception();
    }
    const std::scoped_lock lock(m_mutex);
    m_error = error;
    m_done = true;
    m_ended.notify_all();
}

bool Work::waitFor(std::chrono::milliseconds time) {
    std::unique_lock lock(m_mutex);
    return m_ended.wait_for(lock, time, [this] { return m_done.load(); });
}

void Work::join() {
    const std::scoped_lock lock(m_joining);
    if (m_thread.joinable()) m_thread.join();
}

void Work::rethrow() const {
    if (m_error) std::rethrow_exception(m_error);
}

std::vector<Work::Message> Work::takeMessages() {
    const std::scoped_lock lock(m_mutex);
    return std::exchange(m_messages, {});
}

ProgressSink Work::progressSink() {
    return [this](double done) {
        m_progress = done;
        return !m_cancelled;
    };
}

Checkpoint Work::checkpoint() {
    return [this] {
        if (m_cancelled) throw Error(ErrorKind::interrupted, "the work was cancelled");
    };
}

MessageSink Work::messageSink() {
    return [this](Severity severity, const std::string& text) {
        const std::scoped_lock lock(m_mutex);
        m_messages.emplace_back(severity, text);
    };
}

void Work::endAll() {
    // No work is started or destroyed meanwhile, except by threads that wait for the interpreter's lock, which is not
    // held here.
    const std::scoped_lock lock(g_mutex);
    for (Work* work : running()) work->cancel();
    for (Work* work : running()) work->join();
}

}  // namespace scrim::python
