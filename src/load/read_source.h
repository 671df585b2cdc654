// SPDX-License-Identifier: Apache-2.0
// The work of a child: runs a volume source that reads a file.
#pragma once

#include "confine.h"

#include <scrim/base/error.h>
#include <scrim/guard/load_request.h>
#include <scrim/volume/loaded_source.h>

#include <optional>

namespace scrim::load {

class ReadSource {
  public:
    static constexpr Rights kRights = Rights::names;

    /// Loads the source, which may use `threads` threads. From then on, names of files lead to the open file `input`
    /// and to the one beside it, if there is one.
    ReadSource(int transfer, std::string path, SourceTask task, int input, int beside, int threads);
    /// Runs the source and sends its grids, or the error; where the source asked for another file beside its own, the
    /// error names it.
    void run() const;

  private:
    void send() const;

    int m_transfer, m_threads;
    std::string m_path;
    SourceTask m_task;
    std::optional<LoadedSource> m_source;
    std::optional<Error> m_problem;  ///< why the source cannot be loaded
};

}  // namespace scrim::load
