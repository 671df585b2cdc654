// SPDX-License-Identifier: Apache-2.0
// Internal: one shared object that makes volumes (scrim_source.h). source.h finds it; the program
// `scrim-load` is told its path.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/volume/block_memory.h>
#include <scrim/volume/source_parameters.h>
#include <scrim/volume/sparse_field.h>

#include <string>
#include <vector>

namespace scrim {

struct SourceDescription {
    std::string name;
    std::string description;
    std::string path;  ///< of the shared object
    std::vector<ParameterDescription> parameters;
};

/// NAME of ".../scrim_source_NAME.so"; "" for a file with any other name.
std::string sourceNameOf(const std::string& path);

class LoadedSource {
  public:
    /// Loads the file and never unloads it, because its code may have started threads or registered
    /// handlers. Throws Error(input) "`path`: ..." where it is not a source.
    explicit LoadedSource(const std::string& path);

    const SourceDescription& description() const { return m_description; }

    /// As `generate` (source.h); values lie in `memory`. `alone`: this process was made for the
    /// call and is confined (src/load).
    std::vector<SparseField> run(const SourceParameters& parameters, const MessageSink& messages,
                                 const ProgressSink& progress, BlockMemory& memory, bool alone = false) const;

  private:
    const scrim_source* m_abi = nullptr;
    SourceDescription m_description;
};

}  // namespace scrim
