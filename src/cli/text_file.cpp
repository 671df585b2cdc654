// SPDX-License-Identifier: Apache-2.0
#include "text_file.h"

#include <scrim/base/error.h>

#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>

namespace scrim::cli {

std::string textOf(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) throw Error(ErrorKind::input, path + ": cannot be read: " + std::strerror(errno));
    return {std::istreambuf_iterator<char>(file), {}};
}

}  // namespace scrim::cli
