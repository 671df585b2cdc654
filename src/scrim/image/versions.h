// SPDX-License-Identifier: Apache-2.0
// The versions of the libraries behind pictures and colours, which no other header names.
#pragma once

#include <string>

namespace scrim {

std::string openExrVersion();
std::string openColorIoVersion();
std::string openImageIoVersion();

}  // namespace scrim
