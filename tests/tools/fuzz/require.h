// SPDX-License-Identifier: Apache-2.0
// How a fuzz target says that something is wrong: by an exception that nobody expects. libFuzzer takes it for a crash,
// and the plain tests report its text.
#pragma once

#include <stdexcept>
#include <string>

#include <fmt/format.h>

namespace scrim::fuzz {

template <typename... Arguments>
void require(bool holds, fmt::format_string<Arguments...> text, Arguments&&... arguments) {
    if (!holds) throw std::logic_error(fmt::format(text, std::forward<Arguments>(arguments)...));
}

}  // namespace scrim::fuzz
