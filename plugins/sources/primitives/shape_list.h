// SPDX-License-Identifier: Apache-2.0
// Parses the text of a list of shapes, whose grammar is at the top of primitives.cpp. Errors are std::runtime_error
// with the number of the shape, the key, what was found and what is allowed.
#pragma once

#include "shape.h"

#include <string_view>
#include <vector>

namespace primitives {

/// The shapes in the order of the text; at least one.
std::vector<Shape> parseShapes(std::string_view text);

}  // namespace primitives
