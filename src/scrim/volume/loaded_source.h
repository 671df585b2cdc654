// SPDX-License-Identifier: Apache-2.0
// Internal: one shared object that makes volumes (scrim_source.h). Finding it is the business of others (source.h): the
// program `scrim-load` is told where it is.
#pragma once

#include <scrim/base/messages.h>
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

/// NAME of ".../scrim_source_NAME.so"; "" where the file is called otherwise.
std::string sourceNameOf(const std::string& path);

class LoadedSource {
  public:
    /// Loads the file for good: what has been loaded once may have started threads or registered handlers, and is
    /// never unloaded. Throws Error(input) "`path`: ..." where it is no source.
    explicit LoadedSource(const std::string& path);

    const SourceDescription& description() const { return m_description; }

    /// As `generate` (source.h). `alone`: this process was made for that, and can do nothing else (src/load).
    std::vector<SparseField> run(const SourceParameters& parameters, const MessageSink& messages,
                                 const ProgressSink& progress, bool alone = false) const;

  private:
    const scrim_source* m_abi = nullptr;
    SourceDescription m_description;
};

}  // namespace scrim
