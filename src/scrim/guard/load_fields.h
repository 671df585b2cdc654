// SPDX-License-Identifier: Apache-2.0
// Reads volume files, and runs volume sources, in this process or in a child.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/image/picture_module.h>
#include <scrim/solid/triangle_mesh.h>
#include <scrim/volume/grid_request.h>
#include <scrim/guard/load_options.h>
#include <scrim/volume/source_parameters.h>
#include <scrim/volume/sparse_field.h>
#include <scrim/volume/vdb_info.h>

#include <string>
#include <vector>

namespace scrim {

/// The fields that `requests` mean in one file, in that order. A guarded load calls `checkpoint` while it waits. Throws
/// GridError where the file lacks one of them, else Error: input, memory, render (guarded: the loader cannot be
/// started), and what `checkpoint` throws.
std::vector<SparseField> loadFields(const std::string& path, const std::vector<GridRequest>& requests,
                                    const LoadOptions& options, const MessageSink& messages,
                                    const Checkpoint& checkpoint = {});

/// The path that a source is given as its parameter `file`; "": none.
std::string fileIn(const SourceParameters& parameters);

/// What the source of that name makes, as `generate` (source.h). A guarded load lets a child run one that is given a
/// `file` (scrim_source.h); one that reads no file runs in this process. Throws as `generate`, and Error as
/// `loadFields`.
std::vector<SparseField> sourceFields(const std::string& source, const SourceParameters& parameters,
                                      const LoadOptions& options, const MessageSink& messages,
                                      const Checkpoint& checkpoint = {});

/// A picture file; a guarded load lets a child read it. What is wrong with it is its `problem`. Throws Error(input)
/// where there is no such file, else as `loadFields`.
FilePicture readPicture(const std::string& path, const LoadOptions& options, const Checkpoint& checkpoint = {});

/// Depths of a channel of a picture file ("": of the one that must be it), alike.
FileDepth readDepth(const std::string& path, const std::string& channel, const LoadOptions& options,
                    const Checkpoint& checkpoint = {});

/// A mesh file. Throws Error(input) where it is missing or damaged, else as `loadFields`.
TriangleMesh loadMesh(const std::string& path, const LoadOptions& options, const Checkpoint& checkpoint = {});

/// What the file says about itself. Throws as `loadFields`.
VdbFileInfo loadInfo(const std::string& path, const LoadOptions& options, const Checkpoint& checkpoint = {});

}  // namespace scrim
