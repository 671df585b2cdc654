// SPDX-License-Identifier: Apache-2.0
// The work of a child: reads one photometric file.
#pragma once

#include "confine.h"

#include <string>

namespace scrim::load {

class ReadProfile {
  public:
    static constexpr Rights kRights = Rights::reading;

    ReadProfile(int transfer, std::string path, int input);
    /// Reads the file and sends its contents, or the error.
    void run() const;

  private:
    int m_transfer;
    std::string m_path;
    int m_input;
};

}  // namespace scrim::load
