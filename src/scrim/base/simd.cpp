// SPDX-License-Identifier: Apache-2.0
#include <scrim/base/simd.h>

#include <scrim/base/error.h>

#include <cstdint>

#include <hwy/highway.h>
#include <hwy/targets.h>

namespace scrim {
namespace {

// All targets that need more than the instruction set `name`.
std::int64_t beyond(const std::string& name) {
    const std::int64_t avx512 = HWY_AVX3 | HWY_AVX3_DL;
    if (name == "auto" || name == "avx512") return 0;
    if (name == "avx2") return avx512;
    if (name == "sse4") return avx512 | HWY_AVX2;
    throw Error(ErrorKind::usage, "no instruction set is called '" + name + "': choose " + choices(simdNames()));
}

std::int64_t supported() {
    static const std::int64_t targets = hwy::SupportedTargets();  // asks the processor, which takes a while
    return targets;
}

// The index of the best of `targets`. Highway's own choice is global to the process; this object is local.
std::size_t indexOf(std::int64_t targets) {
    hwy::ChosenTarget chosen;
    chosen.Update(targets);
    return chosen.GetIndex();
}

}  // namespace

const std::vector<std::string>& simdNames() {
    static const std::vector<std::string> names{"auto", "sse4", "avx2", "avx512"};
    return names;
}

Simd::Simd(const std::string& name) : m_index(indexOf(supported() & ~beyond(name))) {}

std::string Simd::target() const {
    for (std::int64_t left = supported(); left != 0; left &= left - 1) {
        const std::int64_t target = left & -left;
        if (indexOf(target) == index()) return hwy::TargetName(target);
    }
    return "baseline";
}

std::size_t Simd::bestIndex() {
    static const std::size_t best = indexOf(supported());
    return best;
}

}  // namespace scrim
