// SPDX-License-Identifier: Apache-2.0
// The cost and the accuracy of a frame, as the public types of shot_frame.h.
#pragma once

#include <scrim/engine/model/frame.h>
#include <scrim/shot/shot_frame.h>
#include <scrim/verify/verify.h>

#include <cstddef>
#include <string>

namespace scrim {

VerificationReport reportOf(const Verification& verification, const PixelSample& sample);

/// Counts of work as one compact JSON object. They are the same in every run, and so are pictures that contain them.
std::string workAsJson(const RenderWork& work);

/// A plan or counts of work as JSON, without the parts that depend on the number of threads: how many sheets are in
/// memory at a time, and their size. Pictures contain this, so that equal scenes give equal files.
std::string withoutThreads(const std::string& json);

/// Peak resident memory of this process so far, bytes.
std::size_t peakResidentBytes();

}  // namespace scrim
