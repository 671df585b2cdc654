// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/sky_parts.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <optional>
#include <utility>

#include <glm/common.hpp>
#include <glm/geometric.hpp>

namespace scrim {
namespace {

constexpr double kPi = std::numbers::pi;
constexpr double kBright = 16;     // times the mean of the sky without what is bright
constexpr double kStep = 4;        // a spot with a glow is looked at again above so many times the threshold
constexpr double kWidest = 5;      // degrees
constexpr double kLittle = 0.005;  // of the sky's light
constexpr std::size_t kMostSuns = 8;
constexpr int kMostWidth = 2048;  // of the smooth picture

using Pixels = std::vector<std::int32_t>;

class Sky {
  public:
    explicit Sky(const Texture::Level& level)
        : m_level(level), m_sun(std::size_t(level.width) * std::size_t(level.height)) {
        for (int y = 0; y < level.height; ++y) {
            const double share = std::cos(kPi * y / level.height) - std::cos(kPi * (y + 1) / level.height);
            m_solidAngle.push_back(2 * kPi / level.width * share);
        }
        m_all = lightWhere([](double) { return true; }).first;
    }

    std::vector<std::pair<SkySun, Pixels>> suns() {
        std::vector<std::pair<SkySun, Pixels>> found;
        if (!(m_all > 0)) return found;
        for (double threshold = kBright * calmMean(), most = brightest(); threshold < most; threshold *= kStep)
            for (Pixels& spot : spotsAbove(threshold))
                if (auto sun = sunOf(spot)) found.emplace_back(*sun, std::move(spot));
        std::sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return sum(a.first) > sum(b.first); });
        if (found.size() > kMostSuns) found.resize(kMostSuns);
        return found;
    }

    /// The mean of the pixels around a spot.
    Rgb around(const Pixels& spot) const {
        Rgb mean(0);
        double weight = 0;
        std::vector<bool> counted(m_sun.size(), false);
        for (const std::int32_t at : spot) counted[std::size_t(at)] = true;
        for (const std::int32_t at : spot)
            forNeighbours(at, [&](std::int32_t beside) {
                if (counted[std::size_t(beside)]) return;
                counted[std::size_t(beside)] = true;
                const double w = solidAngle(beside);
                mean += w * colour(beside);
                weight += w;
            });
        return weight > 0 ? mean / weight : Rgb(0);
    }
    Rgb colour(std::int32_t at) const {
        const float* p = m_level.rgba.data() + 4 * std::size_t(at);
        return {p[0], p[1], p[2]};
    }
    double solidAngle(std::int32_t at) const { return m_solidAngle[std::size_t(at / m_level.width)]; }

  private:
    static double sum(const SkySun& sun) { return sun.light.x + sun.light.y + sun.light.z; }
    double value(std::int32_t at) const {
        const Rgb rgb = colour(at);
        return (rgb.x + rgb.y + rgb.z) / 3;
    }
    template <class Counts>
    std::pair<double, double> lightWhere(const Counts& counts) const {
        double light = 0, weight = 0;
        for (std::int32_t at = 0; at < static_cast<std::int32_t>(m_sun.size()); ++at)
            if (const double v = value(at); counts(v)) {
                light += solidAngle(at) * v;
                weight += solidAngle(at);
            }
        return {light, weight};
    }
    double brightest() const {
        double most = 0;
        for (std::int32_t at = 0; at < static_cast<std::int32_t>(m_sun.size()); ++at) most = std::max(most, value(at));
        return most;
    }
    // The mean of what is not much brighter than it: a sun may have more light than all of the sky.
    double calmMean() const {
        double mean = m_all / (4 * kPi);
        for (int i = 0; i < 30; ++i) {
            const auto [light, weight] = lightWhere([&](double v) { return v <= kBright * mean; });
            const double next = weight > 0 ? light / weight : 0;
            if (next >= mean * (1 - 1e-6)) break;
            mean = next;
        }
        // In a black sky everything else is bright.
        return std::max(mean, 1e-6 * m_all / (4 * kPi));
    }
    // The eight pixels beside one. The left border is beside the right one; all pixels at a pole are.
    template <class Visit>
    void forNeighbours(std::int32_t at, const Visit& visit) const {
        const int x = at % m_level.width, y = at / m_level.width;
        for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx) {
                const int row = y + dy, column = (x + dx + m_level.width) % m_level.width;
                if (row >= 0 && row < m_level.height) visit(row * m_level.width + column);
            }
        if (y == 0 || y == m_level.height - 1) visit(y * m_level.width + (x + m_level.width / 2) % m_level.width);
    }
    // Connected pixels above a threshold that are not part of a sun.
    std::vector<Pixels> spotsAbove(double threshold) {
        std::vector<Pixels> spots;
        std::vector<bool> seen(m_sun);
        for (std::int32_t first = 0; first < static_cast<std::int32_t>(m_sun.size()); ++first) {
            if (seen[std::size_t(first)] || value(first) <= threshold) continue;
            Pixels spot{first};
            seen[std::size_t(first)] = true;
            for (std::size_t i = 0; i < spot.size(); ++i)
                forNeighbours(spot[i], [&](std::int32_t beside) {
                    if (seen[std::size_t(beside)] || value(beside) <= threshold) return;
                    seen[std::size_t(beside)] = true;
                    spot.push_back(beside);
                });
            spots.push_back(std::move(spot));
        }
        return spots;
    }
    Vec3 direction(std::int32_t at) const {
        const double longitude = 2 * kPi * (at % m_level.width + 0.5) / m_level.width,
                     polar = kPi * (at / m_level.width + 0.5) / m_level.height;
        return {std::sin(polar) * std::cos(longitude), std::sin(polar) * std::sin(longitude), std::cos(polar)};
    }
    // No value if the spot is too wide or too faint. Its pixels then count as before.
    std::optional<SkySun> sunOf(const Pixels& spot) {
        // The sky around a spot is looked at only where the spot is bright enough with it: a night has many stars.
        double most = 0;
        for (const std::int32_t at : spot) most += solidAngle(at) * value(at);
        if (!(most > kLittle * m_all)) return std::nullopt;
        const Rgb beside = around(spot);
        SkySun sun;
        Vec3 center(0);
        double all = 0, squares = 0;
        for (const std::int32_t at : spot) {
            const Rgb more = glm::max(colour(at) - beside, Rgb(0)) * solidAngle(at);
            const double light = more.x + more.y + more.z;
            sun.light += more;
            center += light * direction(at);
            all += light;
            squares += light * light / solidAngle(at);
        }
        if (!(all / 3 > kLittle * m_all)) return std::nullopt;
        center = glm::normalize(center);
        const double pixel = 2 * kPi / m_level.width, widest = std::cos(0.5 * kWidest * kPi / 180 + pixel);
        for (const std::int32_t at : spot)
            if (glm::dot(direction(at), center) < widest) return std::nullopt;
        // The solid angle over which its light is spread.
        sun.angle = 360 / kPi * std::acos(std::clamp(1 - all * all / squares / (2 * kPi), -1.0, 1.0));
        const double turn = std::atan2(center.y, center.x) / (2 * kPi);
        sun.u = turn - std::floor(turn);
        sun.v = std::acos(std::clamp(center.z, -1.0, 1.0)) / kPi;
        for (const std::int32_t at : spot) m_sun[std::size_t(at)] = true;
        return sun;
    }

    const Texture::Level& m_level;
    std::vector<double> m_solidAngle;  // of a pixel, for each row
    std::vector<bool> m_sun;           // for each pixel: it belongs to a sun
    double m_all = 0;
};

}  // namespace

SkyParts skyParts(const Texture& picture) {
    const Texture::Level& level = picture.levels().front();
    Sky sky(level);
    SkyParts parts;
    const auto found = sky.suns();
    if (found.empty()) return parts;
    Image rest;
    rest.window = {0, 0, level.width, level.height};
    rest.rgba = level.rgba;
    for (const auto& [sun, pixels] : found) {
        const Rgb beside = sky.around(pixels);
        for (const std::int32_t at : pixels) {
            const Rgb left = glm::min(sky.colour(at), beside);
            for (int c = 0; c < 3; ++c) rest.rgba[4 * std::size_t(at) + std::size_t(c)] = static_cast<float>(left[c]);
        }
        parts.suns.push_back(sun);
    }
    const Texture whole(rest, picture.aspect() * level.height / level.width);
    std::size_t coarse = 0;
    while (whole.levels()[coarse].width > kMostWidth) ++coarse;
    rest.window = {0, 0, whole.levels()[coarse].width, whole.levels()[coarse].height};
    rest.rgba = whole.levels()[coarse].rgba;
    parts.smooth = std::make_shared<const Texture>(rest, picture.aspect() * rest.window.height() / rest.window.width());
    return parts;
}

}  // namespace scrim
