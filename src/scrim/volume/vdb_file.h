// SPDX-License-Identifier: Apache-2.0
// An open .vdb file: what it holds, and fields made of its grids.
//
// OpenVDB's reader is not safe on damaged files. What can be done inside one process is done here: the bytes
// are read first, their outer structure is checked, and the stream that OpenVDB parses throws at its end. A
// crash inside OpenVDB remains possible; a program that must survive it opens files in a child process and
// takes the result over with field_transfer.h.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/volume/grid_request.h>
#include <scrim/volume/sparse_field.h>
#include <scrim/volume/vdb_info.h>

#include <memory>
#include <string>
#include <vector>

namespace scrim {

class VdbBytes;

class VdbFile {
  public:
    /// Reads all of `path`, a regular file. Throws Error(input) with one line "path: reason".
    static VdbFile open(const std::string& path);
    /// Reads no more of it than `field` needs for these requests, where the file says where its grids are. A request
    /// that the file cannot serve is `field`'s concern.
    static VdbFile open(const std::string& path, const std::vector<GridRequest>& requests);

    /// The same of a file that is open already, or in memory.
    static VdbFile open(const VdbBytes& bytes);
    static VdbFile open(const VdbBytes& bytes, const std::vector<GridRequest>& requests);

    /// Describes all grids that were read; looks at every active voxel of the scalar ones.
    VdbFileInfo info() const;

    /// Grids that `field` accepts, as it accepts them: "density", or "density[0]", "density[1]" where a name
    /// is not unique, or "[0]" for one without a name. In the file's order.
    std::vector<std::string> usableGrids() const;

    /// The field of one grid, or of one component of a colour; chooseGrid says what a request means.
    ///
    /// Level sets become fog (as colours they stay what they are), and grids whose transform is not affine are
    /// resampled; both are said in an info message. Values that are not finite or negative count as 0 and are reported
    /// in one warning; the field of a component is called "Cd.r". Throws GridError where there is no such grid, it
    /// was not read, or it does not hold floating-point numbers.
    SparseField field(const GridRequest& request, const MessageSink& messages) const;
    SparseField field(const std::string& grid, const MessageSink& messages) const {
        return field(GridRequest{grid}, messages);
    }

    /// The same of a grid that is not asked for again: a level set becomes fog where it stands, in half the memory.
    SparseField lastField(const GridRequest& request, const MessageSink& messages);

    VdbFile(VdbFile&&) noexcept;
    VdbFile& operator=(VdbFile&&) noexcept;
    ~VdbFile();

    struct Content;

  private:
    explicit VdbFile(std::unique_ptr<Content> content);
    std::unique_ptr<Content> m_content;
};

}  // namespace scrim
