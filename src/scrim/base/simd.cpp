// SPDX-License-Identifier: Apache-2.0
#include <scrim/base/simd.h>

#include <scrim/base/error.h>

#include <hwy/highway.h>
#include <hwy/targets.h>

namespace scrim {
namespace {

// All targets that need more than what `name` stands for.
std::int64_t beyond(const std::string& name) {
    const std::int64_t avx512 = HWY_AVX3 | HWY_AVX3_DL;
    if (name == "auto" || name == "avx512") return 0;
    if (name == "avx2") return avx512;
    if (name == "sse4") return avx512 | HWY_AVX2;
    throw Error(ErrorKind::usage, "no instruction set is called '" + name + "': choose " + choices(simdNames()));
}

}  // namespace

const std::vector<std::string>& simdNames() {
    static const std::vector<std::string> names{"auto", "sse4", "avx2", "avx512"};
    return names;
}

void limitSimd(const std::string& name) {
    const std::int64_t disabled = beyond(name);
    hwy::SetSupportedTargetsForTest(0);
    if (disabled != 0) hwy::SetSupportedTargetsForTest(hwy::SupportedTargets() & ~disabled);
    hwy::GetChosenTarget().Update(hwy::SupportedTargets());
}

std::string simdInUse() {
    const std::int64_t supported = hwy::SupportedTargets();
    return hwy::TargetName(supported & -supported);  // the lowest bit is the best target
}

}  // namespace scrim
