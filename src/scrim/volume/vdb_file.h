// SPDX-License-Identifier: Apache-2.0
// An open .vdb file: its description, and fields made from its grids.
//
// OpenVDB's reader is not safe on damaged files. What can be done about that inside one process is
// done here: the bytes are read first, their outer structure is checked, and the stream that
// OpenVDB parses throws at its end. A crash inside OpenVDB remains possible; a program that must
// survive it opens files in a child process and receives the result through field_transfer.h.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/volume/block_memory.h>
#include <scrim/volume/grid_request.h>
#include <scrim/volume/point_cloud.h>
#include <scrim/volume/sparse_field.h>
#include <scrim/volume/vdb_info.h>

#include <memory>
#include <string>
#include <vector>

namespace scrim {

class GridEditor;
class VdbBytes;
using VdbFiles = std::vector<std::unique_ptr<VdbBytes>>;

class VdbFile {
  public:
    /// Reads all of `path`, a regular file. Throws Error(input) with one line "path: reason".
    static VdbFile open(const std::string& path);
    /// Reads only as much as `field` needs for these requests, if the file states where its grids
    /// are. Requests that the file cannot serve are reported by `field`.
    static VdbFile open(const std::string& path, const std::vector<GridRequest>& requests);

    /// The same for a file that is already open, or in memory.
    static VdbFile open(const VdbBytes& bytes);
    static VdbFile open(const VdbBytes& bytes, const std::vector<GridRequest>& requests);
    /// The same for fields alone, whose values lie in `memory`, which must outlive this object. They are read straight
    /// into it where that is possible, on all threads, and info() then knows nothing of the grid.
    static VdbFile open(const VdbBytes& bytes, const std::vector<GridRequest>& requests, BlockMemory& memory,
                        const PointLook& look = {});
    /// The same with the grids edited, or put together from several files, before they can be
    /// requested; messages are about that.
    static VdbFile open(const VdbFiles& files, const std::vector<GridRequest>& requests, const GridEditor& editor,
                        const MessageSink& messages);
    /// The same with all grids.
    static VdbFile open(const VdbFiles& files, const GridEditor& editor, const MessageSink& messages);
    /// No file: fields made by a source, edited in the same way. `name` stands for the file in messages.
    static VdbFile of(const std::vector<SparseField>& fields, const std::string& name, const GridEditor& editor,
                      const MessageSink& messages);

    /// Describes all grids that were read; visits every active voxel of the scalar ones.
    VdbFileInfo info() const;

    /// The names of grids that `field` accepts, in the file's order: "density", or "density[0]",
    /// "density[1]" where a name is not unique, or "[0]" for a grid without a name.
    std::vector<std::string> usableGrids() const;

    /// The field of one grid, or of one component of a colour; chooseGrid defines what a request means.
    ///
    /// Level sets become fog (except as colours), and grids whose transform is not affine are
    /// resampled; an info message reports either. Values that are not finite or negative count as 0
    /// and are reported in one warning; the field of a component is called "Cd.r". Throws GridError
    /// where there is no such grid, it was not read, or it does not hold floating-point numbers.
    SparseField field(const GridRequest& request, const MessageSink& messages) const;
    SparseField field(const std::string& grid, const MessageSink& messages) const {
        return field(GridRequest{grid}, messages);
    }

    /// The same for a grid that will not be requested again: a level set is turned into fog in
    /// place, which takes half the memory.
    SparseField lastField(const GridRequest& request, const MessageSink& messages);

    /// The grids as a .vdb file of their own.
    std::string asFile() const;

    VdbFile(VdbFile&&) noexcept;
    VdbFile& operator=(VdbFile&&) noexcept;
    ~VdbFile();

    struct Content;

  private:
    explicit VdbFile(std::unique_ptr<Content> content);
    std::unique_ptr<Content> m_content;
};

}  // namespace scrim
