// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/keyed.h>

#include <algorithm>

namespace scrim {
namespace {

/// Slope of a monotone cubic at a key. Boost has this as pchip, but version 1.74 throws below four
/// keys, and two are the usual case.
///
/// With slopes a and b of the chords before and after the key, of lengths h and k in frames, the slope is their
/// weighted harmonic mean, or 0 at a turning point (F. N. Fritsch and J. Butland, "A method for constructing local
/// monotone piecewise cubic interpolants", SIAM J. Sci. Stat. Comput. 5, 1984).
double keySlope(double a, double h, double b, double k) {
    if (!(a * b > 0)) return 0;
    const double w1 = 2 * k + h, w2 = k + 2 * h;
    return (w1 + w2) / (w1 / a + w2 / b);
}

Vec3 keySlope(const Vec3& a, double h, const Vec3& b, double k) {
    return {keySlope(a.x, h, b.x, k), keySlope(a.y, h, b.y, k), keySlope(a.z, h, b.z, k)};
}

/// Clamps `value` to its keys' values, because rounding could carry it beyond them.
double between(double value, double a, double b) {
    return std::clamp(value, std::min(a, b), std::max(a, b));
}

Vec3 between(const Vec3& value, const Vec3& a, const Vec3& b) {
    return {between(value.x, a.x, b.x), between(value.y, a.y, b.y), between(value.z, a.z, b.z)};
}

}  // namespace

template <typename T>
T Keyed<T>::at(double frame) const {
    if (!(frame > keys.front().first)) return keys.front().second;
    if (frame >= keys.back().first) return keys.back().second;
    const auto after =
        std::upper_bound(keys.begin(), keys.end(), frame, [](double f, const auto& key) { return f < key.first; });
    const auto i = std::size_t(after - keys.begin()) - 1;
    const auto length = [&](std::size_t k) { return keys[k + 1].first - keys[k].first; };
    const auto chord = [&](std::size_t k) { return (keys[k + 1].second - keys[k].second) / length(k); };

    const T p = keys[i].second, q = keys[i + 1].second;
    const double h = length(i), t = (frame - keys[i].first) / h;
    if (interpolation == Interpolation::linear) return between((1 - t) * p + t * q, p, q);

    // The cubic Hermite interpolant through both keys; its slope is 0 at the first and the last key.
    const T slopeP = i == 0 ? T(0) : keySlope(chord(i - 1), length(i - 1), chord(i), h);
    const T slopeQ = i + 2 == keys.size() ? T(0) : keySlope(chord(i), h, chord(i + 1), length(i + 1));
    const double s = 1 - t;
    return between((1 + 2 * t) * s * s * p + t * t * (3 - 2 * t) * q + t * s * s * h * slopeP - t * t * s * h * slopeQ,
                   p, q);
}

template struct Keyed<double>;
template struct Keyed<Vec3>;

}  // namespace scrim
