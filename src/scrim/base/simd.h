// SPDX-License-Identifier: Apache-2.0
// Which vector instructions the inner loops may use. Normally the best the processor has; a farm whose machines must
// agree to the bit pins them all to one.
#pragma once

#include <string>
#include <vector>

namespace scrim {

/// "auto", "sse4", "avx2", "avx512": from no limit to the most one may use.
const std::vector<std::string>& simdNames();

/// Limits all vectorised code of the process to `name`, or lifts the limit ("auto"). A processor that has less uses
/// what it has. Not to be called while a render is under way. Throws Error(usage) on an unknown name.
void limitSimd(const std::string& name);

/// What is used now, as Highway calls it: "AVX2".
std::string simdInUse();

}  // namespace scrim
