// SPDX-License-Identifier: Apache-2.0
// Internal: the host's side of the plug-in ABI during one call of a source's `generate`. Everything
// that a source passes is checked here; our exceptions are kept until the source has returned.
#pragma once

#include <scrim/base/messages.h>
#include <scrim/volume/field_builder.h>
#include <scrim/volume/scrim_source.h>

#include <exception>
#include <string>
#include <thread>
#include <vector>

namespace scrim {

class SourceHost {
  public:
    /// `where` starts every message and error. `alone` is what the source is told about its process (scrim_source.h).
    SourceHost(std::string where, MessageSink messages, ProgressSink progress, bool alone);
    SourceHost(const SourceHost&) = delete;
    SourceHost& operator=(const SourceHost&) = delete;

    /// The pointer to pass to the source; valid as long as this object.
    const scrim_host* abi() const { return &m_abi; }

    /// The grids, once `generate` has returned `code`; their values lie in `memory`. Throws the
    /// error of the call, if there was one.
    std::vector<SparseField> finish(int code, BlockMemory& memory);

  private:
    static SourceHost& self(const scrim_host* host) { return *static_cast<SourceHost*>(host->context); }
    static int addGrid(const scrim_host* host, const char* name, const double worldFromIndex[16]) noexcept;
    static int addBlock(const scrim_host* host, int grid, const std::int32_t origin[3],
                        const float values[512]) noexcept;
    static int addTile(const scrim_host* host, int grid, const std::int32_t origin[3], std::int32_t edge,
                       float value) noexcept;
    static void warn(const scrim_host* host, const char* text) noexcept;
    static int progress(const scrim_host* host, double done) noexcept;
    static void fail(const scrim_host* host, const char* text) noexcept;

    /// Runs `task`. An exception is kept (the first one counts) and the result is then -1.
    template <typename Task>
    int guarded(const Task& task) noexcept;
    FieldBuilder& grid(int number);
    [[noreturn]] void refuse(const std::string& reason) const;

    std::string m_where;
    MessageSink m_messages;
    ProgressSink m_progress;
    std::thread::id m_thread = std::this_thread::get_id();
    scrim_host m_abi;
    std::vector<FieldBuilder> m_grids;
    std::string m_failure;         ///< text that the source passed to `fail`
    std::exception_ptr m_problem;  ///< the first problem on our side
};

}  // namespace scrim
