// SPDX-License-Identifier: Apache-2.0
// Which vector instructions the inner loops use. Normally the best the processor has; a farm whose machines must agree
// to the bit pins them all to one. A value that every render hands down to its loops: nothing of it belongs to the
// process, so that renders side by side may use unlike ones.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace scrim {

/// "auto", "sse4", "avx2", "avx512": from no limit to the most one may use.
const std::vector<std::string>& simdNames();

class Simd {
  public:
    /// The best there is.
    Simd() = default;
    /// The best that is no more than `name`. Throws Error(usage) on an unknown name.
    explicit Simd(const std::string& name);

    /// As Highway calls it: "AVX2".
    std::string target() const;

    /// Place in Highway's dispatch tables, for SCRIM_ON_TARGET.
    std::size_t index() const { return m_index != 0 ? m_index : bestIndex(); }

  private:
    static std::size_t bestIndex();

    std::size_t m_index = 0;  // 0: the best, not looked up yet
};

/// The variant of a function that HWY_EXPORT has exported: SCRIM_ON_TARGET(simd, function)(arguments).
#define SCRIM_ON_TARGET(simd, function) (*(HWY_DISPATCH_TABLE(function)[(simd).index()]))

}  // namespace scrim
