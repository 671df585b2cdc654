// SPDX-License-Identifier: Apache-2.0
// How the library speaks: through functions its caller hands in. The library itself never prints.
#pragma once

#include <functional>
#include <string>

namespace scrim {

enum class Severity { info, warning };

/// Receives one line of text without a newline. May be called from the thread that called the library only.
using MessageSink = std::function<void(Severity, const std::string&)>;

/// Receives the finished part of the work in [0, 1]; returning false asks the library to stop, which it does
/// by throwing an Error of kind `interrupted`. Called from the thread that called the library only.
using ProgressSink = std::function<bool(double)>;

/// Called often where nothing can be reported: throws where the caller of the library asked it to stop.
using Checkpoint = std::function<void()>;

/// Receives the progress of a part of the work, [from, to] of all, and passes it on; nothing where `progress` is
/// nothing.
inline ProgressSink partOf(const ProgressSink& progress, double from, double to) {
    if (!progress) return {};
    return [progress, from, to](double done) { return progress(from + (to - from) * done); };
}

inline void notify(const MessageSink& sink, Severity severity, const std::string& text) {
    if (sink) sink(severity, text);
}

}  // namespace scrim
