// SPDX-License-Identifier: Apache-2.0
// Tests whether children are confined (confine.h), by having some of them try forbidden actions.
#pragma once

namespace scrim::load {

/// Prints a line for each test. Returns true if all went as expected, and also if there is no filter.
bool checkConfinement();

}  // namespace scrim::load
