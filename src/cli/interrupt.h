// SPDX-License-Identifier: Apache-2.0
// SIGINT and SIGTERM: the first asks the work to stop at the next safe place, and ends the program in a second where
// none comes; a second one ends it at once. Either way no half-written file stays behind.
#pragma once

namespace scrim::cli {

void handleInterrupts();

/// The signal that came, or 0.
int interruptSignal() noexcept;

/// Throws Error(interrupted) where a signal came.
void throwIfInterrupted();

}  // namespace scrim::cli
