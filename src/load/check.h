// SPDX-License-Identifier: Apache-2.0
// Tries whether children are confined (confine.h), by having some do what they must not.
#pragma once

namespace scrim::load {

/// Prints a line for each try. Whether all went as they should; true, too, where there is no filter.
bool checkConfinement();

}  // namespace scrim::load
