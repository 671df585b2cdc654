// SPDX-License-Identifier: Apache-2.0
// The work of a child: reads one picture.
#pragma once

#include "confine.h"

#include <scrim/image/picture_module.h>
#include <scrim/guard/load_request.h>

#include <string>

namespace scrim::load {

/// Loads the module of pictures from the file `path`, before any child is forked. Null where it cannot be loaded.
const PictureModule* loadPictureModule(const std::string& path);

class ReadPicture {
  public:
    static constexpr Rights kRights = Rights::names;

    /// From then on, names of files lead to the open file `input` only.
    ReadPicture(const PictureModule& module, int transfer, LoadRequest request, int input);
    /// Reads the file and sends its contents, or the error.
    void run() const;

  private:
    const PictureModule& m_module;
    int m_transfer;
    LoadRequest m_request;
};

}  // namespace scrim::load
