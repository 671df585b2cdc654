// SPDX-License-Identifier: Apache-2.0
// Volume sources: finds, loads and runs the shared objects that make volumes (scrim_source.h).
// Those that read files may run in another process: see load_fields.h.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/volume/loaded_source.h>
#include <scrim/volume/source_parameters.h>
#include <scrim/volume/sparse_field.h>

#include <string>
#include <vector>

namespace scrim {

/// The folders in which sources are searched, in order and without repetitions, whether they exist or not: those of
/// $SCRIM_PLUGIN_PATH, ../lib/scrim/sources beside the running program, scrim/sources beside this library.
std::vector<std::string> sourceFolders();

/// All sources by name; of two with the same name, the one found first. A source that cannot be
/// loaded is left out with a warning.
std::vector<SourceDescription> listSources(const MessageSink& messages);

/// The path of one source's shared object. Throws Error(input), which lists those found, where it is missing.
std::string sourceFile(const std::string& name);

/// The description of one source. Throws Error(input) where it is missing (and lists those found) or cannot be loaded.
SourceDescription describeSource(const std::string& name);

/// Runs a source in this process, with parameters given as text and defaults for the others. Throws Error(input) for a
/// missing or bad source, bad parameters and any mistake of the source, Error(interrupted) where `progress` asks to
/// stop. Must not be called from several threads at once unless the source allows it (Scrim's own sources do).
std::vector<SparseField> generate(const std::string& name, const SourceParameters& parameters,
                                  const MessageSink& messages, const ProgressSink& progress = {});

}  // namespace scrim
