// SPDX-License-Identifier: Apache-2.0
// The text a list of shapes is written in; its grammar is at the top of primitives.cpp. Whatever does not fit throws
// std::runtime_error with the number of the shape, the key, what was found and what is allowed.
#pragma once

#include "shape.h"

#include <string_view>
#include <vector>

namespace primitives {

/// At least one shape, in the order of the text.
std::vector<Shape> parseShapes(std::string_view text);

}  // namespace primitives
