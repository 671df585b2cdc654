// SPDX-License-Identifier: Apache-2.0
// Internal: carries out what a scene does to the grids of a volume (grid_edit.h). Only the .cpp
// files that use OpenVDB include this header.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/volume/ax_module.h>
#include <scrim/volume/grid_edit.h>

#include <memory>
#include <string>
#include <vector>

#include <openvdb/openvdb.h>

namespace scrim {

/// The grids of a volume. Each may be null: it was not read, since nothing needs it.
struct EditedGrids {
    openvdb::GridPtrVec grids;
};

class GridEditor {
  public:
    /// Compiles the expressions. `ax` may be null where there are none. Throws Error(input) with
    /// the place of the first mistake.
    GridEditor(GridEdit edit, const AxModule* ax);
    GridEditor(const GridEditor&) = delete;
    GridEditor& operator=(const GridEditor&) = delete;

    /// What it does.
    const GridEdit& edit() const { return m_edit; }
    /// The names of the grids that the expressions use; some of them may be new.
    std::vector<std::string> usedGrids() const;

    /// Edits the grids, and adds new ones at the end. Level sets become fog first, and doubles become floats. A new
    /// grid has the voxels of the density, all 0. `file` names the file or source in messages; one info message for
    /// each expression says what it used and how long it took. Throws Error.
    void apply(EditedGrids& all, const std::string& file, const MessageSink& messages) const;

  private:
    struct Program {
        const AxCode* code;
        std::shared_ptr<const AxProgram> compiled;
        double seconds;  ///< of compilation
    };
    openvdb::GridBase::Ptr gridFor(const Program& program, const AxUse& use, EditedGrids& all,
                                   const std::string& file) const;
    void run(const Program& program, EditedGrids& all, const std::string& file, const MessageSink& messages) const;

    GridEdit m_edit;
    std::vector<Program> m_programs;
};

}  // namespace scrim
