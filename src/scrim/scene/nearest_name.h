// SPDX-License-Identifier: Apache-2.0
// Guesses what a misspelt name was meant to be, for messages.
#pragma once

#include <string>
#include <vector>

namespace scrim {

/// The one of `names` that the fewest single-letter edits or swaps of neighbours turn `name` into, if those
/// are few enough to be slips (one in three letters); "" otherwise.
std::string nearestName(const std::string& name, const std::vector<std::string>& names);

/// "; did you mean 'fov'?" in front of the rest of a message, or "".
std::string didYouMean(const std::string& name, const std::vector<std::string>& names);

}  // namespace scrim
