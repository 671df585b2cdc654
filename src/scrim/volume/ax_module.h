// SPDX-License-Identifier: Apache-2.0
// Internal: the module that compiles and runs OpenVDB AX. AX brings LLVM along, whose 100 MB take
// longer to load than all of Scrim. Therefore only the processes that run an expression load the
// module, and only for volumes that have one.
#pragma once

#include <scrim/volume/grid_edit.h>

#include <memory>
#include <string>
#include <vector>

namespace scrim {

inline constexpr const char* kAxModule = "scrim_ax.so";

struct EditedGrids;  // grid_editor.h

/// A grid that an expression uses, and where it does so first: line and column of its text, from 1.
struct AxUse {
    std::string name;
    std::string type;  ///< AX's word: "float", "vec3f", "int32", ...
    bool reads = false, writes = false;
    int line = 0, column = 0;
};

struct AxProblem {
    std::string text;
    int line = 0, column = 0;
};

/// Code that is ready to run.
class AxProgram {
  public:
    virtual ~AxProgram() = default;
    virtual const std::vector<AxUse>& grids() const = 0;
    /// Runs for each active voxel of each grid that the code writes. All grids that it uses must be
    /// there, once each. Throws std::exception.
    virtual void run(EditedGrids& grids) const = 0;
};

/// The program, or why there is none.
struct AxCompiled {
    std::shared_ptr<const AxProgram> program;
    std::vector<AxProblem> problems;
};

struct AxModule {
    AxCompiled (*compile)(const std::string& code, const std::vector<AxVariable>& variables) = nullptr;
};

/// The single function that the module exports. The name must change whenever anything above changes.
#define SCRIM_AX_MODULE_SYMBOL "scrim_ax_module_1"
using AxModuleFunction = const AxModule* (*)();

/// Loads the module from the file `path`, and never unloads it. Throws Error(render) "`where`: ..."
/// with the names of the packages that it needs.
const AxModule* loadAxModule(const std::string& path, const std::string& where);

}  // namespace scrim
