// SPDX-License-Identifier: Apache-2.0
// The module `scrim._scrim`: errors, waiting, and the bindings of the other files.
#include "bindings.h"

#include <scrim/base/version.h>

#include <algorithm>
#include <exception>

#include <nanobind/stl/string.h>

namespace scrim::python {
namespace {

constexpr std::chrono::milliseconds kPause{20};  // the longest delay before a signal is noticed

const char* classOf(ErrorKind kind) {
    switch (kind) {
        case ErrorKind::render:
            return "RenderError";
        case ErrorKind::usage:
            return "UsageError";
        case ErrorKind::input:
            return "InputError";
        case ErrorKind::output:
            return "OutputError";
        case ErrorKind::memory:
            return "OutOfMemoryError";
        case ErrorKind::interrupted:
            return "Cancelled";
        case ErrorKind::accuracy:
            return "AccuracyError";
    }
    return "Error";
}

void translate(const std::exception_ptr& thrown, void*) {
    try {
        std::rethrow_exception(thrown);
    } catch (const Error& error) {
        const nb::object type = nb::module_::import_("scrim._errors").attr(classOf(error.kind()));
        // File names are bytes, and need not be UTF-8.
        const nb::object text = nb::steal(PyUnicode_DecodeFSDefault(error.what()));
        PyErr_SetObject(type.ptr(), text.ptr());
    }
}

void passOn(const std::vector<Work::Message>& messages) {
    if (messages.empty()) return;
    const nb::object log = nb::module_::import_("logging").attr("getLogger")("scrim");
    for (const auto& [severity, text] : messages)
        log.attr(severity == Severity::warning ? "warning" : "info")("%s", text);
}

/// Waits for one pause, then informs Python. Returns true when there is nothing to wait for any more.
bool awaitOnce(Work& work, nb::handle progress, std::chrono::milliseconds pause, double& told) {
    bool done = false;
    {
        const nb::gil_scoped_release release;
        done = work.waitFor(pause);
    }
    if (PyErr_CheckSignals() != 0) throw nb::python_error();
    passOn(work.takeMessages());
    if (progress.is_valid() && !progress.is_none() && work.progress() != told) progress(told = work.progress());
    return done;
}

}  // namespace

bool await(Work& work, nb::handle progress, std::optional<double> seconds) {
    using Clock = std::chrono::steady_clock;
    const auto start = Clock::now();
    double told = -1;
    try {
        for (;;) {
            auto pause = kPause;
            if (seconds) {
                const std::chrono::duration<double> left(*seconds -
                                                         std::chrono::duration<double>(Clock::now() - start).count());
                pause = std::clamp(std::chrono::duration_cast<std::chrono::milliseconds>(left),
                                   std::chrono::milliseconds(0), kPause);
            }
            if (awaitOnce(work, progress, pause, told)) return true;
            if (seconds && std::chrono::duration<double>(Clock::now() - start).count() >= *seconds) return false;
        }
    } catch (...) {
        work.cancel();
        {
            const nb::gil_scoped_release release;
            work.join();
        }
        throw;
    }
}

void doAndWait(std::function<void(Work&)> task, nb::handle progress) {
    Work work(std::move(task));
    await(work, progress);
    work.rethrow();
}

Busy::Busy(std::shared_ptr<ShotState> shot, const std::string& with) : m_shot(std::move(shot)) {
    const std::scoped_lock lock(m_shot->mutex);
    if (!m_shot->busy.empty())
        throw Error(ErrorKind::usage, m_shot->shot.path() + ": the shot is at work on " + m_shot->busy +
                                          "; wait for it, or open the shot once more to do two things at a time");
    m_shot->busy = with;
}

Busy::~Busy() {
    const std::scoped_lock lock(m_shot->mutex);
    m_shot->busy.clear();
}

nb::object fromJson(const std::string& text) {
    return nb::module_::import_("json").attr("loads")(text);
}

std::string pathText(nb::handle path) {
    const nb::object bytes = nb::module_::import_("os").attr("fsencode")(path);
    char* data = nullptr;
    Py_ssize_t size = 0;
    if (PyBytes_AsStringAndSize(bytes.ptr(), &data, &size) != 0) throw nb::python_error();
    std::string text(data, static_cast<std::size_t>(size));
    // The system takes a path up to its first NUL: a file of another name would be read, or written over.
    if (text.find('\0') != std::string::npos)
        throw Error(ErrorKind::usage, "the path " + nb::cast<std::string>(nb::str(nb::repr(path))) +
                                          " holds a NUL; expected one without");
    return text;
}

std::string textOf(nb::handle text, const std::string& what) {
    Py_ssize_t size = 0;
    const char* const data = PyUnicode_Check(text.ptr()) ? PyUnicode_AsUTF8AndSize(text.ptr(), &size) : nullptr;
    if (data != nullptr) return {data, static_cast<std::size_t>(size)};
    PyErr_Clear();
    const std::string found = shortened(nb::cast<std::string>(nb::str(nb::repr(text))), 80);
    throw Error(ErrorKind::usage, what + " is " + found + "; expected a string of whole characters");
}

nb::object pathObject(const std::string& path) {
    return nb::steal(PyUnicode_DecodeFSDefaultAndSize(path.data(), static_cast<Py_ssize_t>(path.size())));
}

std::vector<double> numbers(nb::handle it, std::size_t count, const char* what) {
    std::vector<double> out;
    try {
        for (const nb::handle item : nb::iter(it)) out.push_back(nb::cast<double>(nb::float_(item)));
    } catch (nb::python_error&) {
        out.clear();
    }
    if (out.size() != count) {
        const std::string found = nb::cast<std::string>(nb::str(nb::repr(it)));
        throw Error(ErrorKind::usage, shortened(found, 80) + ": expected " + what);
    }
    return out;
}

}  // namespace scrim::python

NB_MODULE(_scrim, module) {
    using namespace scrim::python;
    module.doc() = "The library of Scrim. Use the package `scrim`.";
    module.attr("__version__") = scrim::scrimVersion();
    nb::register_exception_translator(translate);
    bindFields(module);
    bindFrames(module);
    bindShots(module);
    bindOpening(module);
    nb::module_::import_("atexit").attr("register")(nb::cpp_function([] {
        const nb::gil_scoped_release release;
        Work::endAll();
    }));
}
