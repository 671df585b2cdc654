// SPDX-License-Identifier: Apache-2.0
// What a frame took and how good it is, in the public words of shot_frame.h.
#pragma once

#include <scrim/engine/model/frame.h>
#include <scrim/shot/shot_frame.h>
#include <scrim/verify/verify.h>

#include <cstddef>
#include <string>

namespace scrim {

VerificationReport reportOf(const Verification& verification, bool outOfTime);

/// Counts of work as one compact JSON object: the same on every run, so that pictures with it are, too.
std::string workAsJson(const RenderWork& work);

/// A plan or counts of work, as JSON, without what depends on the number of threads: how many sheets are in memory at a
/// time, and what they take. Pictures carry that, so that equal scenes give equal files.
std::string withoutThreads(const std::string& json);

/// Of this process, now.
std::size_t peakResidentBytes();

}  // namespace scrim
