// SPDX-License-Identifier: Apache-2.0
// Shared by the files of the module: shots and frames as Python holds them, and waiting for work.
#pragma once

#include "work.h"

#include <scrim/base/error.h>
#include <scrim/shot/shot.h>
#include <scrim/volume/sparse_field.h>

#include <atomic>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <nanobind/nanobind.h>

namespace scrim::python {

namespace nb = nanobind;

/// One or more grids of a volume: a colour has three.
struct Field {
    std::string name;
    std::vector<SparseField> grids;
};

/// A shot may be used from one thread at a time. `busy` names the work that uses it.
struct ShotState {
    explicit ShotState(Shot opened) : shot(std::move(opened)) {}
    Shot shot;
    std::mutex mutex;
    std::string busy;
};

/// The object that Python holds. It contains a pointer instead of being one: the pointers that nanobind makes own a
/// Python object, so the thread that drops the last one would need the interpreter's lock.
struct ShotObject {
    std::shared_ptr<ShotState> state;

    const Shot& shot() const { return state->shot; }
};

/// Held by code that uses a shot. Throws Error(usage) where other code uses it.
class Busy {
  public:
    Busy(std::shared_ptr<ShotState> shot, const std::string& with);
    ~Busy();
    Busy(const Busy&) = delete;
    Busy& operator=(const Busy&) = delete;

    Shot& shot() const { return m_shot->shot; }

  private:
    std::shared_ptr<ShotState> m_shot;
};

/// Waits for the work, releasing the interpreter's lock meanwhile. Passes on messages, calls `progress` (or None) with
/// the finished fraction, and checks for signals. An exception from these cancels the work and is raised once it has
/// ended. Returns false where `seconds` have passed. Exceptions of the work itself are not thrown here.
bool await(Work& work, nb::handle progress, std::optional<double> seconds = {});

/// Runs `task` in a thread of its own, waits, and throws whatever it threw.
void doAndWait(std::function<void(Work&)> task, nb::handle progress = nb::handle());

/// The Python object for JSON text.
nb::object fromJson(const std::string& text);

/// The text of a str or an os.PathLike. Throws Error(usage) where it holds a NUL.
std::string pathText(nb::handle path);

/// The str of a path, whose bytes need not be UTF-8.
nb::object pathObject(const std::string& path);

/// The UTF-8 of a str. Throws Error(usage), in which `what` is its name, where it is none or holds half characters.
std::string textOf(nb::handle text, const std::string& what);

/// The items of a sequence of exactly `count` numbers. Throws Error(usage), which says that `what` was expected.
std::vector<double> numbers(nb::handle it, std::size_t count, const char* what);

/// "key.path=value" for each of Python's overrides.
std::vector<std::string> assignmentsOf(nb::handle overrides);

void bindFields(nb::module_& module);
void bindFrames(nb::module_& module);
void bindShots(nb::module_& module);
void bindOpening(nb::module_& module);
void bindLooking(nb::module_& module, nb::class_<ShotObject>& type);

/// A picture as an array (height, width, 4) that owns it.
nb::object ownedArray(Image picture);

/// A frame as a Python object, which takes ownership; None where it was skipped.
nb::object toPython(ShotFrame frame);

}  // namespace scrim::python
