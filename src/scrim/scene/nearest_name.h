// SPDX-License-Identifier: Apache-2.0
// Guesses which name a misspelt one was meant to be, for messages.
#pragma once

#include <string>
#include <vector>

namespace scrim {

/// The entry of `names` that is reached from `name` with the fewest single-letter edits or swaps of
/// neighbours, if these are few enough to be slips (one in three letters); "" otherwise.
std::string nearestName(const std::string& name, const std::vector<std::string>& names);

/// "; did you mean 'fov'?", to be put in front of the rest of a message, or "".
std::string didYouMean(const std::string& name, const std::vector<std::string>& names);

}  // namespace scrim
