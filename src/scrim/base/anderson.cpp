// SPDX-License-Identifier: Apache-2.0
#include <scrim/base/anderson.h>

#include <scrim/base/least_squares.h>

#include <cmath>
#include <utility>

namespace scrim {
namespace {

std::vector<Real> difference(const std::vector<Real>& a, const std::vector<Real>& b) {
    std::vector<Real> out(a.size());
    for (std::size_t i = 0; i < a.size(); ++i) out[i] = a[i] - b[i];
    return out;
}

}  // namespace

AndersonMixing::AndersonMixing(std::size_t history, Product product)
    : m_history(history), m_product(std::move(product)) {}

double AndersonMixing::step(std::vector<Real>& x, const std::vector<Real>& next) {
    std::vector<Real> residual = difference(next, x);
    if (!m_next.empty()) m_steps.push_back({difference(next, m_next), difference(residual, m_residual)});
    if (m_steps.size() > m_history) m_steps.erase(m_steps.begin());
    m_next = next;
    m_residual = residual;
    const std::size_t n = m_steps.size();
    std::vector<std::vector<double>> matrix(n, std::vector<double>(n));
    std::vector<double> right(n);
    for (std::size_t i = 0; i < n; ++i) {
        for (std::size_t j = 0; j <= i; ++j)
            matrix[i][j] = matrix[j][i] = m_product(m_steps[i].residual, m_steps[j].residual);
        matrix[i][i] *= 1 + 1e-10;
        right[i] = m_product(m_steps[i].residual, residual);
    }
    const std::vector<double> part = leastSquares(std::move(matrix), std::move(right));
    const double length = m_product(residual, residual);
    x = next;
    for (std::size_t i = 0; i < n; ++i)
        for (std::size_t k = 0; k < x.size(); ++k) {
            const Real mixed = static_cast<Real>(part[i]) * m_steps[i].next[k];
            x[k] -= mixed;
            residual[k] -= mixed;
        }
    return length > 0 ? std::sqrt(m_product(residual, residual) / length) : 1;
}

}  // namespace scrim
