// SPDX-License-Identifier: Apache-2.0
// Random numbers as choices: what a scene is drawn from, and what is shrunk until only what matters is left.
#pragma once

#include <scrim/base/split_mix.h>

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace scrim::test {

/// Numbers in [0, 1), a fixed count for each section (camera, a volume, a light ...), so that what one section takes
/// does not move the choices of another. 0 is always the plainest choice: no such light, no such key, the first word.
class Draws {
  public:
    static constexpr std::size_t kPerSection = 64;

    explicit Draws(std::vector<double> numbers) : m_numbers(std::move(numbers)) {}
    /// The numbers of a seed, for so many sections.
    static std::vector<double> numbersOf(std::uint64_t seed, std::size_t sections) {
        std::vector<double> numbers(sections * kPerSection);
        std::uint64_t state = splitMix(seed);
        for (double& n : numbers) n = double(splitMix(state += kSplitMixStep) >> 11) * 0x1p-53;
        return numbers;
    }

    void enter(std::size_t section) { m_next = section * kPerSection, m_end = m_next + kPerSection; }
    double unit() { return m_next < m_end && m_next < m_numbers.size() ? m_numbers[m_next++] : 0; }
    /// True with this probability.
    bool once(double share) { return unit() >= 1 - share; }
    int below(int n) { return static_cast<int>(unit() * n); }
    double between(double plain, double other) { return plain + (other - plain) * unit(); }
    double logBetween(double plain, double other) { return plain * std::pow(other / plain, unit()); }
    template <class T>
    T of(std::initializer_list<T> choices) {
        return choices.begin()[below(static_cast<int>(choices.size()))];
    }
    const char* word(std::initializer_list<const char*> words) { return of<const char*>(words); }
    /// Each coordinate from -reach to reach, now and then 0 or another's value: degenerate on purpose.
    std::string point(double reach) {
        double p[3];
        for (double& x : p) x = reach * (2 * unit() - 1);
        if (once(0.25)) p[below(3)] = 0;
        if (once(0.25)) p[1] = p[0];
        if (once(0.15)) p[2] = -p[0];
        return fmt::format("[{:.6g}, {:.6g}, {:.6g}]", p[0], p[1], p[2]);
    }
    /// A direction: along an axis, at 45 degrees, or any.
    std::string direction() {
        if (once(0.4)) {
            const char* axes[] = {"[0, 0, -1]",  "[0, -1, 0]", "[1, 0, 0]", "[0, 0, 1]",   "[1, 0, -1]",
                                  "[-1, -1, 0]", "[0, -1, 1]", "[1, 1, 1]", "[-1, -1, -1]"};
            return axes[below(9)];
        }
        const double x = 2 * unit() - 1, y = 2 * unit() - 1, z = 2 * unit() - 1;
        return fmt::format("[{:.6g}, {:.6g}, {:.6g}]", x, y, z + (x == 0 && y == 0 && z == 0 ? 1 : 0));
    }
    std::string colour() {
        if (once(0.35)) {
            const double v = 1 - 0.9 * unit();
            return fmt::format("[{0:.4g}, {0:.4g}, {0:.4g}]", v);
        }
        const double r = unit(), g = unit(), b = unit();
        return fmt::format("[{:.4g}, {:.4g}, {:.4g}]", r, g, b);
    }

  private:
    std::vector<double> m_numbers;
    std::size_t m_next = 0, m_end = 0;
};

}  // namespace scrim::test
