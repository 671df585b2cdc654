// SPDX-License-Identifier: Apache-2.0
// Internal to the module `scrim_ax`: runs an expression once where AX would run it for each grid that it writes.
#pragma once

#include <scrim/volume/ax_module.h>

#include <openvdb_ax/ast/AST.h>
#include <openvdb_ax/compiler/VolumeExecutable.h>

#include <fmt/format.h>

#include <string>
#include <utility>
#include <vector>

namespace scrim {

namespace ax = openvdb::ax;

/// The grids become one, whose values hold a float for each of theirs: the expression works on variables, which are
/// read before it and written after it.
class Together {
  public:
    using Executable = ax::VolumeExecutable::Ptr;
    static constexpr const char* kGrid = "scrim_together";

    explicit Together(const std::vector<AxUse>& uses) {
        for (const AxUse& use : uses) {
            if (!use.writes) continue;
            m_known = m_known && (use.type == "float" || use.type == "vec3f");
            m_written.push_back(use);
            m_floats += use.type == "float" ? 1 : 3;
        }
    }
    /// True if it writes at least two grids, all of them of float or vec3f, with at most 16 floats a voxel together.
    bool worthwhile() const { return m_known && m_written.size() > 1 && m_floats <= 16; }
    /// The expression that works on the variables; null: it cannot be rewritten.
    ax::ast::Tree::Ptr rewritten(const std::string& code) const;
    void take(Executable executable) { (m_executable = std::move(executable))->setCreateMissing(false); }
    /// Runs where all grids that are written have the same voxels; otherwise returns false.
    bool run(const openvdb::GridPtrVec& grids) const;

  private:
    std::string variable(std::size_t i) const { return fmt::format("scrim_together_{}", i); }
    const char* type() const { return m_floats <= 4 ? "vec4f" : "mat4f"; }
    template <typename Value>
    void runAs(const openvdb::GridPtrVec& grids, const openvdb::GridPtrVec& written) const;

    bool m_known = true;
    int m_floats = 0;
    std::vector<AxUse> m_written;
    Executable m_executable;
};

}  // namespace scrim
