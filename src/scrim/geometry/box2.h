// SPDX-License-Identifier: Apache-2.0
// Rectangles of pixels, of tiles or of positions on a raster.
#pragma once

#include <algorithm>
#include <cstddef>
#include <limits>
#include <type_traits>

namespace scrim {

/// A rectangle of whole numbers is half-open, [x0, x1) x [y0, y1); the initial {0, 0, 0, 0} is empty. A rectangle of
/// positions is closed; `Box2<double>::nothing()` is empty and grows by `include`. x points to the right, y down.
template <class T>
struct Box2 {
    T x0{}, y0{}, x1{}, y1{};

    static Box2 nothing() {
        constexpr T kFar = std::numeric_limits<T>::infinity();
        return {kFar, kFar, -kFar, -kFar};
    }
    bool empty() const {
        if constexpr (std::is_integral_v<T>)
            return x1 <= x0 || y1 <= y0;
        else
            return !(x0 <= x1 && y0 <= y1);
    }
    T width() const { return x1 > x0 ? x1 - x0 : T{}; }
    T height() const { return y1 > y0 ? y1 - y0 : T{}; }
    std::size_t pixelCount() const { return std::size_t(width()) * std::size_t(height()); }

    bool contains(T x, T y) const { return x >= x0 && x < x1 && y >= y0 && y < y1; }
    /// True where all of `other` lies inside, and where `other` is empty.
    bool contains(const Box2& other) const {
        return other.empty() || (other.x0 >= x0 && other.x1 <= x1 && other.y0 >= y0 && other.y1 <= y1);
    }
    /// Grows to contain a position.
    void include(T x, T y) { *this = {std::min(x0, x), std::min(y0, y), std::max(x1, x), std::max(y1, y)}; }
    /// Grows to contain a box; an empty one changes nothing.
    void include(const Box2& b) {
        if (b.empty()) return;
        *this = empty() ? b : Box2{std::min(x0, b.x0), std::min(y0, b.y0), std::max(x1, b.x1), std::max(y1, b.y1)};
    }
    bool operator==(const Box2&) const = default;
};

/// The part that lies in both boxes; may be empty.
template <class T>
Box2<T> intersection(const Box2<T>& a, const Box2<T>& b) {
    return {std::max(a.x0, b.x0), std::max(a.y0, b.y0), std::min(a.x1, b.x1), std::min(a.y1, b.y1)};
}

}  // namespace scrim
