// SPDX-License-Identifier: Apache-2.0
// The work of a child: edits grids (grid_edit.h), those of .vdb files or those that a source made.
#pragma once

#include "confine.h"

#include <scrim/base/error.h>
#include <scrim/volume/sparse_field.h>
#include <scrim/guard/load_request.h>
#include <scrim/volume/ax_module.h>
#include <scrim/volume/vdb_bytes.h>

#include <memory>
#include <optional>
#include <vector>

namespace scrim::load {

class EditVolume {
  public:
    static constexpr Rights kRights = Rights::compiling;
    EditVolume(const EditVolume&) = delete;
    EditVolume& operator=(const EditVolume&) = delete;

    /// The request must have an edit. `inputs` are the volume's files, or the one file of the grids that a source made.
    /// Loads the module of AX where an expression needs it, and takes over grids that a source made, which the process
    /// that asks for this has checked. May use `threads` threads.
    EditVolume(int transfer, LoadRequest request, const std::vector<int>& inputs, int threads);
    /// Compiles, and gives up the right to make code; only then reads the files, edits, and sends what was
    /// requested, or the error.
    void run() const;

  private:
    void send() const;

    int m_transfer, m_threads;
    LoadRequest m_request;
    const LoadEdit& m_first;  ///< of the request
    const AxModule* m_ax = nullptr;
    std::optional<Error> m_problem;  ///< why the module cannot be loaded
    VdbFiles m_files;                ///< empty: the grids are `m_made`
    std::vector<SparseField> m_made;
};

}  // namespace scrim::load
