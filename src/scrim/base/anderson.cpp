// SPDX-License-Identifier: Apache-2.0
#include <scrim/base/anderson.h>

#include <scrim/base/least_squares.h>
#include <scrim/base/parallel.h>

#include <cmath>
#include <utility>

namespace scrim {
namespace {

std::vector<Real> difference(const std::vector<Real>& a, const std::vector<Real>& b) {
    std::vector<Real> out(a.size());
    parallelChunks(a.size(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) out[i] = a[i] - b[i];
    });
    return out;
}

}  // namespace

AndersonMixing::AndersonMixing(std::size_t history, Product product)
    : m_history(history), m_product(std::move(product)) {}

double AndersonMixing::step(std::vector<Real>& x, const std::vector<Real>& next) {
    std::vector<Real> residual = difference(next, x);
    if (!m_next.empty()) {
        if (m_steps.size() == m_history) {
            m_steps.erase(m_steps.begin());
            m_matrix.erase(m_matrix.begin());
            for (std::vector<double>& row : m_matrix) row.erase(row.begin());
        }
        m_steps.push_back({difference(next, m_next), difference(residual, m_residual)});
        std::vector<double>& last = m_matrix.emplace_back();
        for (const Step& step : m_steps) last.push_back(m_product(step.residual, m_steps.back().residual));
        for (std::size_t i = 0; i + 1 < m_matrix.size(); ++i) m_matrix[i].push_back(last[i]);
        last.back() *= 1 + 1e-10;
    }
    m_next = next;
    m_residual = residual;
    std::vector<double> right;
    for (const Step& step : m_steps) right.push_back(m_product(step.residual, residual));
    const std::vector<double> part = leastSquares(m_matrix, std::move(right));
    const double length = m_product(residual, residual);
    x = next;
    parallelChunks(x.size(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = 0; i < m_steps.size(); ++i)
            for (std::size_t k = begin; k < end; ++k) {
                const Real mixed = static_cast<Real>(part[i]) * m_steps[i].next[k];
                x[k] -= mixed;
                residual[k] -= mixed;
            }
    });
    return length > 0 ? std::sqrt(m_product(residual, residual) / length) : 1;
}

std::size_t AndersonMixing::bytes() const {
    std::size_t values = m_next.size() + 2 * m_residual.size();  // a step has a residual of its own
    for (const Step& step : m_steps) values += step.next.size() + step.residual.size();
    return values * sizeof(Real);
}

}  // namespace scrim
