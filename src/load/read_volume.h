// SPDX-License-Identifier: Apache-2.0
// What a child does: reads one .vdb file.
#pragma once

#include "confine.h"

#include <scrim/guard/field_transfer.h>
#include <scrim/volume/vdb_bytes.h>

#include <memory>

namespace scrim::load {

/// Does once, before any child is forked, what opens files or costs time: OpenVDB's tables, oneTBB's libraries. From
/// then on parallel loops run on the calling thread.
void prepareToRead();

/// In a child: parallel loops may start threads.
void allowThreads();

class ReadVolume {
  public:
    static constexpr Files kFiles = Files::descriptors;

    /// Takes the size of the open file `input`.
    ReadVolume(int transfer, LoadRequest request, int input);
    /// Reads the file, and sends what it holds, or what is wrong with it.
    void run() const;

  private:
    int m_transfer;
    LoadRequest m_request;
    std::unique_ptr<VdbBytes> m_bytes;
};

}  // namespace scrim::load
