// SPDX-License-Identifier: Apache-2.0
#include "text_file.h"

#include <scrim/base/open_file.h>

namespace scrim::cli {

std::string textOf(const std::string& path) {
    return bytesOf(path);
}

}  // namespace scrim::cli
