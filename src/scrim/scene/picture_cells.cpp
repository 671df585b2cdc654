// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/picture_cells.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>

namespace scrim {
namespace {

// Cells consist of bins, of which there are at most this many along the picture's longer side. A bin holds the sums of
// its pixels, so that neither its light nor its centre depends on the bins. A picture of few pixels is divided more
// finely, since a white sky has the same extent whether it has one pixel or a million.
constexpr int kMostBins = 512, kLeastBins = 256;

struct Bin {
    Rgb light{0};       // integral over the bin
    double weight = 0;  // mean of the channels
    double share = 0;   // fraction of the full solid angle or area
    Vec3 moment{0};     // integral of weight times position

    Bin& operator+=(const Bin& b) {
        light += b.light;
        weight += b.weight;
        share += b.share;
        moment += b.moment;
        return *this;
    }
};

struct Cell {
    int x0, y0, x1, y1;
    Bin sum;
    bool whole = false;  // cannot be divided
    // A measure of the error of a light at the centre: the amount of light times the distance it is moved.
    double priority() const { return whole ? 0 : sum.weight * std::sqrt(sum.share); }
};

class BinMap {
  public:
    /// A point (u, v) of the picture is at across(u) * scale(v) + down(v); rows from v0 to v1 are
    /// the fraction share(v0, v1) of the whole.
    template <class Across, class Scale, class Down, class Share>
    BinMap(const Texture& picture, const Across& across, const Scale& scale, const Down& down, const Share& share) {
        const Texture::Level& level = picture.levels().front();
        const int longer = std::max(level.width, level.height), by = (longer + kMostBins - 1) / kMostBins;
        const int finer = (kLeastBins + longer - 1) / longer;  // 1 for all but small pictures
        const int width = level.width * finer, height = level.height * finer;
        m_width = (width + by - 1) / by;
        m_height = (height + by - 1) / by;
        m_bins.resize(std::size_t(m_width) * std::size_t(m_height));
        std::vector<Vec3> columns;
        for (int x = 0; x < width; ++x) columns.push_back(across((x + 0.5) / width));
        for (int y = 0; y < height; ++y) {
            const double part = share(double(y) / height, double(y + 1) / height) / width;
            const double v = (y + 0.5) / height, wide = scale(v);
            const Vec3 below = down(v);
            for (int x = 0; x < width; ++x) {
                const float* p = level.pixel(x / finer, y / finer);
                Bin one{part * Rgb(p[0], p[1], p[2]), 0, part, Vec3(0)};
                one.weight = (one.light.x + one.light.y + one.light.z) / 3;
                one.moment = one.weight * (wide * columns[std::size_t(x)] + below);
                m_bins[std::size_t(y / by) * std::size_t(m_width) + std::size_t(x / by)] += one;
            }
        }
    }

    std::vector<Cell> split(int count, double widthOverHeight) const {
        std::vector<Cell> cells{{0, 0, m_width, m_height, sumOf(0, 0, m_width, m_height)}};
        while (static_cast<int>(cells.size()) < count) {
            const auto most = std::max_element(
                cells.begin(), cells.end(), [](const Cell& a, const Cell& b) { return a.priority() < b.priority(); });
            if (most->priority() <= 0) break;
            const Cell parent = *most;
            if (const auto halves = halved(parent, widthOverHeight)) {
                *most = halves->first;
                cells.push_back(halves->second);
            } else {
                most->whole = true;
            }
        }
        return cells;
    }

  private:
    const Bin& at(int x, int y) const { return m_bins[std::size_t(y) * std::size_t(m_width) + std::size_t(x)]; }
    Bin sumOf(int x0, int y0, int x1, int y1) const {
        Bin sum;
        for (int y = y0; y < y1; ++y)
            for (int x = x0; x < x1; ++x) sum += at(x, y);
        return sum;
    }
    // Divides a cell across its longer side so that each half has half of its light; no value for a single bin.
    std::optional<std::pair<Cell, Cell>> halved(const Cell& c, double widthOverHeight) const {
        const int columns = c.x1 - c.x0, rows = c.y1 - c.y0;
        if (columns * rows == 1) return std::nullopt;
        // The cell's share accounts for its width where a sky's meridians converge.
        const double height = double(rows) / m_height;
        const bool across = rows == 1 || (columns > 1 && c.sum.share / height > height / widthOverHeight);
        const int length = across ? columns : rows;
        std::vector<Bin> lines(static_cast<std::size_t>(length));
        for (int y = c.y0; y < c.y1; ++y)
            for (int x = c.x0; x < c.x1; ++x) lines[std::size_t(across ? x - c.x0 : y - c.y0)] += at(x, y);
        int cut = 1;
        double before = lines[0].weight;
        while (cut < length - 1 && before + 0.5 * lines[std::size_t(cut)].weight < 0.5 * c.sum.weight)
            before += lines[std::size_t(cut++)].weight;
        std::pair<Cell, Cell> halves{c, c};
        (across ? halves.first.x1 : halves.first.y1) = (across ? c.x0 : c.y0) + cut;
        (across ? halves.second.x0 : halves.second.y0) = (across ? c.x0 : c.y0) + cut;
        halves.first.sum = halves.second.sum = Bin();
        for (int i = 0; i < length; ++i) (i < cut ? halves.first : halves.second).sum += lines[std::size_t(i)];
        return halves;
    }

    int m_width = 0, m_height = 0;
    std::vector<Bin> m_bins;
};

}  // namespace

const Texture::Level& wideLevel(const Slide& slide) {
    constexpr int kColumns = 256;
    const auto& levels = smoothPicture(slide).levels();
    std::size_t level = 0;
    while (level + 1 < levels.size() && levels[level].width > kColumns) ++level;
    return levels[level];
}

namespace {

// A level of a picture at a place in [0, 1]^2, interpolated. `round`: its right border meets the left one.
Rgb onPicture(const Texture::Level& picture, const Vec2& place, bool round) {
    const Vec2 at = place * Vec2(picture.width, picture.height) - 0.5;
    const Vec2 whole = glm::floor(at), part = at - whole;
    Rgb sum(0);
    for (int i = 0; i < 4; ++i) {
        const int x = static_cast<int>(whole.x) + (i & 1), y = static_cast<int>(whole.y) + (i >> 1);
        const float* p =
            picture.pixel(round ? (x + picture.width) % picture.width : std::clamp(x, 0, picture.width - 1),
                          std::clamp(y, 0, picture.height - 1));
        sum += ((i & 1) != 0 ? part.x : 1 - part.x) * ((i >> 1) != 0 ? part.y : 1 - part.y) * Rgb(p[0], p[1], p[2]);
    }
    return sum;
}

// The radiance of a dome by one level of its picture.
Rgb skyOn(const Texture::Level& picture, const Light& sky, const Vec3& direction) {
    return sky.intensity * onPicture(picture, pictureOfDome(sky, direction), true);
}

// The coarsest level whose pixels are no wider than this part of the picture.
const Texture::Level& levelFor(const Texture& picture, double part) {
    const auto& levels = picture.levels();
    std::size_t level = 0;
    while (level + 1 < levels.size() && 1.0 / levels[level].width < part) ++level;
    return levels[level];
}

// What a pixel sees of a sun that is not in the picture: its disk with a border as wide as the pixel, or, of a small
// sun, a disk of 1.6 pixels. The integral over all directions is that of the sun, and the sum over pixels within 7 %.
Rgb sunSeen(const Light& sky, const SkySun& sun, const Vec3& direction, double pixel) {
    constexpr double kLeast = 0.8;  // pixels; others add up less evenly
    const double half = 0.5 * glm::radians(sun.angle), wide = std::max(half, kLeast * pixel);
    const Vec3 center = domeDirection(sky, sun.u, sun.v);
    const double away = 2 * std::asin(std::min(0.5 * glm::distance(direction, center), 1.0));
    const double part = std::clamp((wide - away) / pixel + 0.5, 0.0, 1.0);
    if (part == 0) return Rgb(0);
    const Rgb seen = wide > half ? sun.light / (2 * std::numbers::pi * (1 - std::cos(half)))
                                 : sunRadiance(sun, pictureOfDome(sky, direction).y);
    return part * half * half / (wide * wide + pixel * pixel / 12) * seen;
}

}  // namespace

Rgb sunRadiance(const SkySun& sun, double v) {
    const double height = (sun.v - v) * 180 / sun.angle + 0.5;  // 0 to 1 from its lower rim to its upper one
    const double last = static_cast<double>(sun.rows.size()) - 1;
    const double at = std::clamp(height * (last + 1) - 0.5, 0.0, last), first = std::min(std::floor(at), last - 1);
    const Rgb& low = sun.rows[static_cast<std::size_t>(first)];
    return low + (at - first) * (sun.rows[static_cast<std::size_t>(first) + 1] - low);
}

Rgb skyAt(const Light& sky, const Vec3& direction) {
    return sky.slide ? skyOn(wideLevel(*sky.slide), sky, direction) : sky.intensity;
}

Rgb visibleSky(const Light& sky, const Vec3& direction, double angle) {
    if (!sky.slide) return sky.intensity;
    Rgb light = skyOn(levelFor(*sky.slide->image, angle / (2 * std::numbers::pi)), sky, direction);
    if (const SkySun* sun = sunBeside(*sky.slide))
        light += sky.intensity * sunSeen(sky, *sun, direction, std::max(angle, 1e-6));
    return light;
}

Rgb visibleSurface(const Light& light, const Vec3& ws, const Vec3& normal, const Vec3& direction, double pixel) {
    const Light::Area& area = *light.area();
    const double cosine = -glm::dot(normal, direction);
    if (cosine <= 0) return Rgb(0);
    const Rgb radiance = light.intensity * Spread(area.spread).at(cosine);
    if (!light.slide || !light.slide->image) return radiance;
    const Vec3 at = (ws - light.wsPosition) * lightFrame(light);  // the transpose turns into the frame
    return radiance * onPicture(levelFor(*light.slide->image, pixel / area.width),
                                {0.5 + at.x / area.width, 0.5 - at.y / area.height}, false);
}

std::vector<PictureCell> domeCells(const Light& light, int count) {
    constexpr double pi = std::numbers::pi;
    const BinMap map(
        smoothPicture(*light.slide), [&](double u) { return domeDirection(light, u, 0.5); },
        [](double v) { return std::sin(pi * v); },
        [up = glm::normalize(light.wsUp)](double v) { return std::cos(pi * v) * up; },
        [](double v0, double v1) { return 0.5 * (std::cos(pi * v0) - std::cos(pi * v1)); });
    std::vector<PictureCell> cells;
    // In fractions of the sphere, heights are up to 1 and widths 4 / pi times as much at the equator.
    for (const Cell& cell : map.split(count, 4 / pi)) {
        if (cell.sum.weight <= 0) continue;
        const double length = glm::length(cell.sum.moment);
        // The whole sky has no centre.
        const Vec3 center = length > 1e-9 * cell.sum.weight ? cell.sum.moment / length : glm::normalize(light.wsUp);
        cells.push_back({4 * pi * cell.sum.light, center, cell.sum.share});
    }
    return cells;
}

double lightInSpots(const Light& dome, int directions) {
    constexpr double pi = std::numbers::pi;
    constexpr double kBright = 4;      // times the mean around; a horizon, or half a cloud, is not as bright
    constexpr int kFineEnough = 1024;  // pixels across; the sun has two
    if (!dome.slide || !dome.slide->image) return 0;
    const auto& levels = smoothPicture(*dome.slide).levels();
    std::size_t chosen = 0;
    while (chosen + 1 < levels.size() && levels[chosen + 1].width >= kFineEnough) ++chosen;
    const Texture::Level& level = levels[chosen];
    // Regions of about one direction each: rows of equal heights, divided by the lengths of their circles.
    const int rows = std::max(1, static_cast<int>(std::lround(std::sqrt(pi * directions) / 2)));
    const auto regionsOf = [&](int row) {
        return std::max(1, static_cast<int>(std::lround(2 * rows * std::sin(pi * (row + 0.5) / rows))));
    };
    struct Region {
        double light = 0, weight = 0;
    };
    std::vector<std::vector<Region>> regions;
    for (int row = 0; row < rows; ++row) regions.emplace_back(std::size_t(regionsOf(row)));
    const auto each = [&](const auto& visit) {
        for (int y = 0; y < level.height; ++y) {
            std::vector<Region>& row = regions[std::size_t(y * rows / level.height)];
            const double weight = std::sin(pi * (y + 0.5) / level.height);
            for (int x = 0; x < level.width; ++x) {
                const float* p = level.pixel(x, y);
                visit(row[std::size_t(x) * row.size() / std::size_t(level.width)], weight,
                      (double(p[0]) + p[1] + p[2]) / 3);
            }
        }
    };
    double all = 0, spots = 0;
    each([&](Region& region, double weight, double value) {
        region.light += weight * value;
        region.weight += weight;
        all += weight * value;
    });
    each([&](const Region& region, double weight, double value) {
        const double mean = region.light / region.weight;
        if (value > kBright * mean) spots += weight * (value - mean);
    });
    return all > 0 ? spots / all : 0;
}

std::vector<PictureCell> rectangleCells(const Light& light, int count) {
    const BinMap map(
        *light.slide->image, [&](double u) { return pictureOfRectangle(light, u, 0.5); }, [](double) { return 1.0; },
        [&](double v) { return pictureOfRectangle(light, 0.5, v) - light.wsPosition; },
        [](double v0, double v1) { return v1 - v0; });
    std::vector<PictureCell> cells;
    for (const Cell& cell : map.split(count, light.area()->width / light.area()->height))
        if (cell.sum.weight > 0) cells.push_back({cell.sum.light, cell.sum.moment / cell.sum.weight, cell.sum.share});
    return cells;
}

}  // namespace scrim
