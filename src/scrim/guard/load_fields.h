// SPDX-License-Identifier: Apache-2.0
// Reads volume files and runs volume sources, in this process or in a child.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/image/light_profile.h>
#include <scrim/image/picture_module.h>
#include <scrim/solid/triangle_mesh.h>
#include <scrim/volume/grid_edit.h>
#include <scrim/volume/grid_request.h>
#include <scrim/guard/load_options.h>
#include <scrim/volume/source_parameters.h>
#include <scrim/volume/sparse_field.h>
#include <scrim/volume/vdb_info.h>

#include <string>
#include <vector>

namespace scrim {

/// The fields that `requests` mean in one file, in the order of the requests, after its grids were edited if `edit` is
/// not null. A guarded load calls `checkpoint` while it waits. Throws GridError where the file lacks one of them,
/// otherwise Error: input, memory, render (guarded: the loader cannot be started), and whatever `checkpoint` throws.
std::vector<SparseField> loadFields(const std::string& path, const std::vector<GridRequest>& requests,
                                    const LoadOptions& options, const MessageSink& messages,
                                    const Checkpoint& checkpoint = {}, const GridEdit* edit = nullptr);

/// The fields that `requests` mean among grids of a source or from code; `name` stands for the file in messages.
std::vector<SparseField> editedFields(const std::vector<SparseField>& grids, const std::string& name,
                                      const std::vector<GridRequest>& requests, const GridEdit& edit,
                                      const LoadOptions& options, const MessageSink& messages,
                                      const Checkpoint& checkpoint = {});

/// The path that a source gets as its parameter `file`; "" without one.
std::string fileIn(const SourceParameters& parameters);

/// The fields that the named source makes, as `generate` (source.h). A guarded load runs a source
/// with a parameter `file` in a child (scrim_source.h); a source that reads no file runs in this
/// process. Throws as `generate`, and Error as `loadFields`.
std::vector<SparseField> sourceFields(const std::string& source, const SourceParameters& parameters,
                                      const LoadOptions& options, const MessageSink& messages,
                                      const Checkpoint& checkpoint = {});

/// Reads a picture file, in a child if the load is guarded. A defect of the file is reported in its
/// `problem`. Throws Error(input) where the file does not exist, else as `loadFields`.
FilePicture readPicture(const std::string& path, const LoadOptions& options, const Checkpoint& checkpoint = {});

/// Reads the depths of a channel of a picture file; "" stands for the only channel that can hold
/// them. Otherwise as readPicture.
FileDepth readDepth(const std::string& path, const std::string& channel, const LoadOptions& options,
                    const Checkpoint& checkpoint = {});

/// Reads a photometric file. Throws Error(input) where it is missing or damaged, else as `loadFields`.
FilePhotometry loadPhotometry(const std::string& path, const LoadOptions& options, const Checkpoint& checkpoint = {});

/// Reads a mesh file. Throws Error(input) where it is missing or damaged, else as `loadFields`.
TriangleMesh loadMesh(const std::string& path, const LoadOptions& options, const Checkpoint& checkpoint = {});

/// Reads what the file says about itself. Throws as `loadFields`.
VdbFileInfo loadInfo(const std::string& path, const LoadOptions& options, const Checkpoint& checkpoint = {});

}  // namespace scrim
