// SPDX-License-Identifier: Apache-2.0
// The vector instructions that the inner loops use: normally the best that the processor has. A
// farm whose machines must agree to the bit sets the same for all. Every render passes the value
// down to its loops; there is no global state, so renders side by side may use different ones.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace scrim {

/// "auto", "sse4", "avx2", "avx512": no limit, or the highest instruction set allowed.
const std::vector<std::string>& simdNames();

class Simd {
  public:
    /// The best instruction set of the processor.
    Simd() = default;
    /// The best instruction set that is not beyond `name`. Throws Error(usage) for an unknown name.
    explicit Simd(const std::string& name);

    /// Highway's name of it: "AVX2".
    std::string target() const;

    /// Index into Highway's dispatch tables, for SCRIM_ON_TARGET.
    std::size_t index() const { return m_index != 0 ? m_index : bestIndex(); }

  private:
    static std::size_t bestIndex();

    std::size_t m_index = 0;  // 0: the best, not yet determined
};

/// The variant of a function that HWY_EXPORT has exported: SCRIM_ON_TARGET(simd, function)(arguments).
#define SCRIM_ON_TARGET(simd, function) (*(HWY_DISPATCH_TABLE(function)[(simd).index()]))

}  // namespace scrim
