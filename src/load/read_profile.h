// SPDX-License-Identifier: Apache-2.0
// The work of a child: reads one photometric file.
#pragma once

#include "confine.h"

#include <scrim/guard/field_transfer.h>

namespace scrim::load {

class ReadProfile {
  public:
    static constexpr Rights kRights = Rights::reading;

    ReadProfile(int transfer, LoadRequest request, int input);
    /// Reads the file and sends its contents, or the error.
    void run() const;

  private:
    int m_transfer;
    LoadRequest m_request;
    int m_input;
};

}  // namespace scrim::load
