// SPDX-License-Identifier: Apache-2.0
// Volume sources: finds, loads and runs the shared objects that make volumes (scrim_source.h). Those that read files
// may run in another process: load_fields.h.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/volume/loaded_source.h>
#include <scrim/volume/source_parameters.h>
#include <scrim/volume/sparse_field.h>

#include <string>
#include <vector>

namespace scrim {

/// Where sources are looked for, in order, each folder once, whether it exists or not: those of
/// $SCRIM_PLUGIN_PATH, ../lib/scrim/sources beside the running program, scrim/sources beside this library.
std::vector<std::string> sourceFolders();

/// All sources there are, by name; of two of one name the one found first. One that cannot be loaded is
/// left out with a warning.
std::vector<SourceDescription> listSources(const MessageSink& messages);

/// The path of one source's shared object. Throws Error(input) where it is missing (with those found).
std::string sourceFile(const std::string& name);

/// The description of one source. Throws Error(input) where it is missing (with those found) or cannot be
/// loaded.
SourceDescription describeSource(const std::string& name);

/// Runs a source in this process, with parameters given as text, defaults for the others. Throws Error(input) on a
/// missing or bad source, bad parameters and whatever the source does wrong, Error(interrupted) where `progress` asks
/// to stop. Not for use from several threads at once unless the source allows it (those of Scrim do).
std::vector<SparseField> generate(const std::string& name, const SourceParameters& parameters,
                                  const MessageSink& messages, const ProgressSink& progress = {});

}  // namespace scrim
