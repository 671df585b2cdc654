// SPDX-License-Identifier: Apache-2.0
// SIGINT and SIGTERM: the first one asks the work to stop at the next safe point, and ends the program within a second
// if there is none; a second one ends it at once. Either way no half-written file is left behind.
#pragma once

namespace scrim::cli {

void handleInterrupts();

/// The signal that was received, or 0.
int interruptSignal() noexcept;

/// Throws Error(interrupted) if a signal was received.
void throwIfInterrupted();

}  // namespace scrim::cli
