// SPDX-License-Identifier: Apache-2.0
#include <scrim/study/error_picture.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace scrim {
namespace {

double meanError(const Image& difference, std::size_t pixel) {
    const float* rgba = difference.rgba.data() + 4 * pixel;
    return (double(rgba[0]) + rgba[1] + rgba[2]) / 3;
}

std::array<std::uint8_t, 4> colourOf(double error) {
    // White, and the blue and the vermilion of Okabe and Ito's palette; the square root makes small errors visible.
    constexpr std::array<double, 3> kTooDark{0, 114, 178}, kTooBright{213, 94, 0};
    const double strength = std::sqrt(std::min(std::abs(error), 1.0));
    const std::array<double, 3>& end = error < 0 ? kTooDark : kTooBright;
    std::array<std::uint8_t, 4> out{0, 0, 0, 255};
    for (std::size_t c = 0; c < 3; ++c)
        out[c] = static_cast<std::uint8_t>(std::lround(255 + (end[c] - 255) * strength));
    return out;
}

PixelWindow thinnedWindow(const PixelWindow& window, int stride) {
    return {0, 0, (window.width() + stride - 1) / stride, (window.height() + stride - 1) / stride};
}

}  // namespace

DisplayImage errorPicture(const Image& difference, double scale, int stride) {
    DisplayImage out{thinnedWindow(difference.window, stride), {}};
    for (int y = 0; y < difference.window.height(); y += stride)
        for (int x = 0; x < difference.window.width(); x += stride) {
            const std::size_t at = std::size_t(y) * std::size_t(difference.window.width()) + std::size_t(x);
            const auto colour = colourOf(scale > 0 ? meanError(difference, at) / scale : 0);
            out.rgba.insert(out.rgba.end(), colour.begin(), colour.end());
        }
    return out;
}

double errorScale(const Image& difference) {
    std::vector<double> errors;
    for (std::size_t i = 0; i < difference.window.pixelCount(); ++i)
        if (difference.rgba[4 * i + 3] > 0) errors.push_back(std::abs(meanError(difference, i)));
    if (errors.empty()) return 0;
    const std::size_t place = errors.size() - 1 - errors.size() / 1000;
    std::nth_element(errors.begin(), errors.begin() + static_cast<std::ptrdiff_t>(place), errors.end());
    return errors[place];
}

DisplayImage thinned(const DisplayImage& picture, int stride) {
    DisplayImage out{thinnedWindow(picture.window, stride), {}};
    for (int y = 0; y < picture.window.height(); y += stride)
        for (int x = 0; x < picture.window.width(); x += stride) {
            const auto at = 4 * (static_cast<std::ptrdiff_t>(y) * picture.window.width() + x);
            out.rgba.insert(out.rgba.end(), picture.rgba.begin() + at, picture.rgba.begin() + at + 4);
        }
    return out;
}

}  // namespace scrim
