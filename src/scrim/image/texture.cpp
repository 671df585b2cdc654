// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/texture.h>

#include <scrim/base/parallel.h>

#include <algorithm>
#include <cmath>

namespace scrim {
namespace {

// The part of the `fine` pixels that pixel `i` of `coarse` covers along one axis: up to three
// pixels, with weights that sum to 1.
struct Cover {
    int first = 0, count = 0;
    float weights[3] = {0, 0, 0};
};

Cover coverOf(int i, int coarse, int fine) {
    const double scale = double(fine) / coarse, begin = i * scale, end = (i + 1) * scale;
    Cover cover;
    cover.first = static_cast<int>(std::floor(begin));
    for (int p = cover.first; p < fine && cover.count < 3; ++p) {
        const double part = std::min(end, p + 1.0) - std::max(begin, double(p));
        if (part <= 1e-12) break;  // residue of rounding at an end that is a whole number
        cover.weights[cover.count++] = static_cast<float>(part / scale);
    }
    return cover;
}

Texture::Level halved(const Texture::Level& fine) {
    Texture::Level out;
    out.width = (fine.width + 1) / 2;
    out.height = (fine.height + 1) / 2;
    out.rgba.assign(4 * std::size_t(out.width) * std::size_t(out.height), 0.0f);
    parallelFor(std::size_t(out.height), [&](std::size_t row) {
        const Cover down = coverOf(static_cast<int>(row), out.height, fine.height);
        for (int x = 0; x < out.width; ++x) {
            const Cover across = coverOf(x, out.width, fine.width);
            float* to = out.rgba.data() + 4 * (row * std::size_t(out.width) + std::size_t(x));
            for (int j = 0; j < down.count; ++j)
                for (int i = 0; i < across.count; ++i) {
                    const float* from = fine.pixel(across.first + i, down.first + j);
                    for (int c = 0; c < 4; ++c) to[c] += down.weights[j] * across.weights[i] * from[c];
                }
        }
    });
    return out;
}

}  // namespace

Texture::Texture(const Image& image, double pixelAspect)
    : m_aspect(pixelAspect * image.window.width() / image.window.height()) {
    m_levels.push_back({image.window.width(), image.window.height(), image.rgba});
    while (m_levels.back().width > 1 || m_levels.back().height > 1) m_levels.push_back(halved(m_levels.back()));
}

std::size_t Texture::bytes() const {
    std::size_t sum = 0;
    for (const Level& level : m_levels) sum += level.rgba.size() * sizeof(float);
    return sum;
}

}  // namespace scrim
