// SPDX-License-Identifier: Apache-2.0
// What the files of the module share: shots and frames as Python holds them, and waiting for work.
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

/// One or more grids of a volume: a colour is three.
struct Field {
    std::string name;
    std::vector<SparseField> grids;
};

/// A shot is used from one thread at a time. `busy` says by what.
struct ShotState {
    explicit ShotState(Shot opened) : shot(std::move(opened)) {}
    Shot shot;
    std::mutex mutex;
    std::string busy;
};

/// What Python holds. Not the pointer itself: those that nanobind makes own an object of Python, whose lock the thread
/// that drops them would need.
struct ShotObject {
    std::shared_ptr<ShotState> state;

    const Shot& shot() const { return state->shot; }
};

/// Whoever uses a shot holds one. Throws Error(usage) where another does.
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

/// Waits with the interpreter's lock, which is let go meanwhile: passes on messages, calls `progress` (or None) with
/// the finished part, and hears of signals. What these raise cancels the work and is raised once it has ended. False
/// where `seconds` have passed. What the work itself threw is not thrown here.
bool await(Work& work, nb::handle progress, std::optional<double> seconds = {});

/// Does `task` in a thread of its own, waits, and throws what it threw.
void doAndWait(std::function<void(Work&)> task, nb::handle progress = nb::handle());

/// The object that JSON text stands for.
nb::object fromJson(const std::string& text);

/// A str, or an os.PathLike.
std::string pathText(nb::handle path);

/// The items of a sequence of exactly `count` numbers. Throws Error(usage), which says `what` was expected.
std::vector<double> numbers(nb::handle it, std::size_t count, const char* what);

/// "key.path=value" for each of the overrides of Python.
std::vector<std::string> assignmentsOf(nb::handle overrides);

void bindFields(nb::module_& module);
void bindFrames(nb::module_& module);
void bindShots(nb::module_& module);
void bindOpening(nb::module_& module);

/// A frame as an object of Python, which takes it over; None where it was skipped.
nb::object toPython(ShotFrame frame);

}  // namespace scrim::python
