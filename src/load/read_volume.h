// SPDX-License-Identifier: Apache-2.0
// The work of a child: reads one .vdb file.
#pragma once

#include "confine.h"

#include <scrim/guard/load_request.h>
#include <scrim/volume/vdb_bytes.h>

#include <memory>

namespace scrim::load {

/// Does everything that opens files or costs time before any child is forked, but for OpenVDB (vdb_library.h): oneTBB's
/// libraries. From then on, parallel loops run on the calling thread.
void prepareToRead();

/// For a child that is confined: lets parallel loops start threads, all of which allocate from one arena. Threads that
/// start before that would keep the capabilities of root.
void allowThreads();
/// As allowThreads; each has an arena of its own, which takes 64 MB of address space.
void allowThreadsWithArenas();

class ReadVolume {
  public:
    static constexpr Rights kRights = Rights::threads;

    /// The request is for fields or a description, without an edit. Determines the size of the open file `input`, which
    /// `threads` threads will read.
    ReadVolume(int transfer, LoadRequest request, int input, int threads);
    /// Reads the file and sends its contents, or the error. Ends the process with kNeedsOpenVdb (load_protocol.h) where
    /// OpenVDB is needed, and has not been loaded.
    void run() const;

  private:
    int m_transfer, m_threads;
    LoadRequest m_request;
    std::unique_ptr<VdbBytes> m_bytes;
};

}  // namespace scrim::load
