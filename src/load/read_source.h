// SPDX-License-Identifier: Apache-2.0
// What a child does: runs a volume source that reads a file.
#pragma once

#include "confine.h"

#include <scrim/base/error.h>
#include <scrim/guard/field_transfer.h>
#include <scrim/volume/loaded_source.h>

#include <optional>

namespace scrim::load {

class ReadSource {
  public:
    static constexpr Files kFiles = Files::answered;

    /// Loads the source, which may use so many threads. From then on the open file `input` and the one beside it, if
    /// there is one, are all that names lead to.
    ReadSource(int transfer, LoadRequest request, int input, int beside, int threads);
    /// Runs the source, and sends what it makes, or what is wrong; and, where it asked for another file beside its own,
    /// which.
    void run() const;

  private:
    void send() const;

    int m_transfer, m_threads;
    LoadRequest m_request;
    std::optional<LoadedSource> m_source;
    std::optional<Error> m_problem;  ///< of a source that cannot be loaded
};

}  // namespace scrim::load
