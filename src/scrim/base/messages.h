// SPDX-License-Identifier: Apache-2.0
// The functions through which the library sends messages; its caller provides them. The library itself never prints.
#pragma once

#include <functional>
#include <string>

namespace scrim {

enum class Severity { info, warning };

/// Receives one line of text without a newline. It is called only from the thread that called the library.
using MessageSink = std::function<void(Severity, const std::string&)>;

/// Receives the finished fraction of the work in [0, 1]. Returning false asks the library to stop, which it does by
/// throwing an Error of kind `interrupted`. It is called only from the thread that called the library.
using ProgressSink = std::function<bool(double)>;

/// Called often where no progress can be reported; throws where the caller of the library asked it to stop.
using Checkpoint = std::function<void()>;

/// A sink for a part of the work, from `from` to `to` of the whole, that passes its progress on to
/// `progress`. Empty where `progress` is empty.
inline ProgressSink partOf(const ProgressSink& progress, double from, double to) {
    if (!progress) return {};
    return [progress, from, to](double done) { return progress(from + (to - from) * done); };
}

inline void notify(const MessageSink& sink, Severity severity, const std::string& text) {
    if (sink) sink(severity, text);
}

}  // namespace scrim
