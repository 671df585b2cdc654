// SPDX-License-Identifier: Apache-2.0
// Anderson's acceleration of the iteration x = G(x) (D. G. Anderson, J. ACM 12, 1965): the next
// iterate is the mix of the last ones whose residuals G(x) - x cancel best.
#pragma once

#include <scrim/base/real.h>

#include <cstddef>
#include <functional>
#include <vector>

namespace scrim {

class AndersonMixing {
  public:
    /// The inner product of two vectors, whose squares are made smallest.
    using Product = std::function<double(const std::vector<Real>&, const std::vector<Real>&)>;
    /// Mixes at most `history` steps from one iterate to the next.
    AndersonMixing(std::size_t history, Product product);

    /// Replaces x by the next iterate; `next` = G(x). Returns the length of that step, relative to the residual's.
    double step(std::vector<Real>& x, const std::vector<Real>& next);
    /// What a step leaves here, and works with, at most: so many vectors like x.
    static std::size_t vectors(std::size_t history) { return 2 * history + 3; }
    std::size_t bytes() const;

  private:
    struct Step {
        std::vector<Real> next, residual;
    };
    std::size_t m_history;
    Product m_product;
    std::vector<Step> m_steps;                  // from each iterate to the next one
    std::vector<std::vector<double>> m_matrix;  // products of their residuals
    std::vector<Real> m_next, m_residual;
};

}  // namespace scrim
