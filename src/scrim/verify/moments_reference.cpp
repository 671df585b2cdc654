// SPDX-License-Identifier: Apache-2.0
#include <scrim/verify/moments_reference.h>

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/geometry/even_points.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include <fmt/format.h>
#include <glm/common.hpp>

namespace scrim {
namespace {

using Rgba = std::array<double, 4>;

constexpr std::size_t kMostIntervals = 256;             // 512 moments
constexpr int kPaths = 2048, kMostPaths = 16 * kPaths;  // for multiply scattered light, of a pixel or a square
// The noise, relative to the mean, that more paths are taken for. With this noise in 100 squares,
// the interval of an error of 2 % reaches from about 1.5 to 2.5 %.
constexpr double kNoise = 0.02;
constexpr double kChange = 1e-3;  // convergence threshold, relative to the brightest mean

// Evenly spread places on a lens, any number of them in this order (M. Roberts' R2).
Vec2 placeOnLens(std::size_t i) {
    const Vec2 square = evenPoint(i, {0.25, 0.7});
    const double radius = std::sqrt(square.x), angle = 2 * std::numbers::pi * square.y;
    return {radius * std::cos(angle), radius * std::sin(angle)};
}

bool differ(const Rgba& a, const Rgba& b, const Rgba& brightest) {
    for (std::size_t c = 0; c < 4; ++c)
        if (std::abs(a[c] - b[c]) > kChange * brightest[c]) return true;
    return false;
}

}  // namespace

void checkVerifiable(const ViewScene& truth) {
    for (const ViewVolume& volume : truth.volumes)
        if (volume.balls)
            throw Error(ErrorKind::usage,
                        fmt::format("the picture shows the points of volume '{}' themselves, but brute force marches "
                                    "through their voxels; 'sharp = false' in [volume.points] shows these, too",
                                    volume.name));
}

MomentsReference::MomentsReference(const ViewScene& truth) : m_truth(truth), m_paths(kPaths) {
    checkVerifiable(truth);
    if (!truth.moments) {
        OfMoment& still = m_levels.emplace_back().emplace_back();
        still.reference = std::make_unique<const Reference>(truth, ReferenceOptions{}, &m_samplers);
        still.paths = std::make_unique<const PathTracer>(truth, &m_samplers);
        return;
    }
    // If the limit of 24 intervals allows it, nothing travels further than about two pixels between
    // two moments of the first level.
    m_intervals = static_cast<std::size_t>(std::clamp(truth.moments->path / 4, truth.moments->lens ? 16.0 : 3.0, 24.0));
}

std::size_t MomentsReference::moments() const {
    std::size_t count = 0;
    for (const auto& level : m_levels) count += level.size();
    return count;
}

const std::vector<MomentsReference::OfMoment>& MomentsReference::momentsOf(std::size_t level) {
    if (level < m_levels.size()) return m_levels[level];
    const ViewMoments& moments = *m_truth.moments;
    const std::size_t intervals = m_intervals << level;
    const double length = (moments.close - moments.open) / double(intervals), gauss = 0.5 / std::sqrt(3.0);
    std::vector<OfMoment>& made = m_levels.emplace_back();
    for (std::size_t i = 0; i < intervals; ++i)
        for (const double side : {-gauss, gauss}) {
            OfMoment& moment = made.emplace_back();
            const double t = moments.open + (double(i) + 0.5 + side) * length;
            const Vec2 place = moments.lens ? placeOnLens(made.size()) : Vec2(0);
            moment.scene = std::make_unique<const ViewScene>(moments.at({t, place}));
            moment.reference = std::make_unique<const Reference>(*moment.scene, ReferenceOptions{}, &m_samplers);
            if (level == 0) moment.paths = std::make_unique<const PathTracer>(*moment.scene, &m_samplers);
        }
    return made;
}

std::vector<Rgba> MomentsReference::meansOver(std::span<const VerifiedPixel> pixels, std::size_t level) {
    const std::vector<OfMoment>& moments = momentsOf(level);
    std::vector<Rgba> values(pixels.size() * moments.size());
    parallelFor(values.size(), [&](std::size_t i) {
        const VerifiedPixel& p = pixels[i / moments.size()];
        if (goesOn()) values[i] = moments[i % moments.size()].reference->pixel(p.x, p.y, stop());
    });
    std::vector<Rgba> means(pixels.size());
    for (std::size_t i = 0; i < values.size(); ++i)
        for (std::size_t c = 0; c < 4; ++c) means[i / moments.size()][c] += values[i][c] / double(moments.size());
    return means;
}

bool MomentsReference::goesOn() {
    if (!m_left && m_late && m_late()) m_left = true;
    return !m_left;
}

// What the reference asks within a pixel; nothing, if no time is set.
std::function<bool()> MomentsReference::stop() {
    if (!m_late) return {};
    return [this] { return !goesOn(); };
}

// A square is the mean of its pixels, among which its paths are divided.
bool MomentsReference::evaluate(std::span<VerifiedPixel> pixels, const std::function<bool()>& late) {
    m_late = late;
    m_left = false;
    std::vector<VerifiedPixel> each;
    std::vector<std::size_t> first;
    int most = 1;  // pixels of a square
    for (const VerifiedPixel& p : pixels) {
        first.push_back(each.size());
        most = std::max(most, p.edge * p.edge);
        for (int i = 0; i < p.edge * p.edge; ++i) {
            const Int2 at(p.x + i % p.edge, p.y + i / p.edge);
            if (p.edge == 1 || m_truth.region.contains(at.x, at.y)) each.push_back({at.x, at.y, {}, {}});
        }
    }
    first.push_back(each.size());
    evaluateSingle(each);
    if (!m_left) addScattered(each, std::max(m_paths / most, 1));
    if (m_left) return false;
    for (std::size_t i = 0; i < pixels.size(); ++i) {
        VerifiedPixel& p = pixels[i];
        p.reference = {};
        p.variance = {};
        const auto count = static_cast<double>(first[i + 1] - first[i]);
        for (std::size_t k = first[i]; k < first[i + 1]; ++k) {
            for (std::size_t c = 0; c < 4; ++c) p.reference[c] += each[k].reference[c] / count;
            for (std::size_t c = 0; c < 3; ++c) p.variance[c] += each[k].variance[c] / (count * count);
        }
    }
    choosePaths(pixels);
    return true;
}

void MomentsReference::choosePaths(std::span<const VerifiedPixel> pixels) {
    for (const VerifiedPixel& p : pixels)
        for (std::size_t c = 0; c < 3; ++c) {
            m_noise += p.variance[c] / 3 * m_paths;
            m_light += p.reference[c] / 3;
        }
    m_seen += pixels.size();
    if (!(m_light > 0) || m_noise == 0) return;
    const double mean = m_light / double(m_seen), wanted = m_noise / double(m_seen) / (kNoise * kNoise * mean * mean);
    m_paths = static_cast<int>(std::clamp(wanted, 1.0 * kPaths, 1.0 * kMostPaths));
}

void MomentsReference::evaluateSingle(std::span<VerifiedPixel> pixels) {
    if (!m_truth.moments) {
        const Reference& still = *m_levels[0][0].reference;
        parallelFor(pixels.size(), [&](std::size_t i) {
            if (goesOn()) pixels[i].reference = still.pixel(pixels[i].x, pixels[i].y, stop());
        });
        return;
    }
    std::vector<VerifiedPixel> open(pixels.begin(), pixels.end());
    std::vector<std::size_t> places(pixels.size());
    for (std::size_t i = 0; i < places.size(); ++i) places[i] = i;
    std::vector<Rgba> before;
    for (std::size_t level = 0; !open.empty() && !m_left; ++level) {
        const std::vector<Rgba> means = meansOver(open, level);
        for (const Rgba& mean : means)
            for (std::size_t c = 0; c < 4; ++c) m_brightest[c] = std::max(m_brightest[c], std::abs(mean[c]));
        const bool last = (m_intervals << (level + 1)) > kMostIntervals;
        std::vector<VerifiedPixel> still;
        std::vector<std::size_t> stillAt;
        std::vector<Rgba> kept;
        for (std::size_t i = 0; i < open.size(); ++i) {
            pixels[places[i]].reference = means[i];
            if (last || (level > 0 && !differ(means[i], before[i], m_brightest))) continue;
            still.push_back(open[i]);
            stillAt.push_back(places[i]);
            kept.push_back(means[i]);
        }
        open = std::move(still);
        places = std::move(stillAt);
        before = std::move(kept);
    }
}

// Adds multiply scattered light on the first level only; its noise exceeds the differences between levels.
void MomentsReference::addScattered(std::span<VerifiedPixel> pixels, int all) {
    if (pixels.empty()) return;
    const std::vector<OfMoment>& moments = m_levels.front();
    constexpr int kLeast = 16;  // paths of a moment
    const int paths = std::max(all / static_cast<int>(moments.size()), kLeast);
    parallelFor(pixels.size(), [&](std::size_t i) {
        for (std::size_t m = 0; m < moments.size(); ++m) {
            if (!moments[m].paths->any() || !goesOn()) return;
            const Estimate scattered = moments[m].paths->pixel(pixels[i].x, pixels[i].y, paths, m + 1);
            const double part = 1.0 / double(moments.size());
            for (int c = 0; c < 3; ++c) {
                pixels[i].reference[std::size_t(c)] += part * scattered.mean[c];
                pixels[i].variance[std::size_t(c)] += part * part * scattered.variance[c];
            }
        }
    });
}

}  // namespace scrim
