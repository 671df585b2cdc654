// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/depth_picture.h>

#include <algorithm>
#include <cmath>

namespace scrim {
namespace {

using Piece = DepthPicture::Piece;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// The mean of e^-s over s in [0, x].
double meanLeft(double x) {
    return x < 1e-8 ? 1 - 0.5 * x : -std::expm1(-x) / x;
}

// Optical depths add up where pieces overlap. A pixel is therefore computed from events: beginnings
// and ends of volumes, and surfaces.
struct Event {
    float depth;
    double density;  // increase of extinction at the beginning of a volume; negative at its end
    double tau;      // optical depth of a surface
    int volumes;     // 1: a volume begins; -1: one ends; 0: a surface
};

bool isThere(float depth, double background) {
    return depth > 0 && depth < background;  // false for NaN, too
}

// Collects events from samples (z, zBack, alpha) in any order.
void addEvents(std::span<const float> samples, double background, std::vector<Event>& events) {
    for (std::size_t i = 0; i + 2 < samples.size(); i += 3) {
        const float z = samples[i], back = samples[i + 1], alpha = samples[i + 2];
        if (!isThere(z, background) || !(alpha > 0)) continue;
        // An opaque sample is opaque from its beginning on: (1 - 1)^x is 0 for any x > 0.
        const double tau = alpha < 1 ? -std::log1p(-double(alpha)) : kInfinity;
        if (alpha < 1 && back > z && std::isfinite(back)) {
            const double density = tau / (double(back) - double(z));
            events.push_back({z, density, 0, 1});
            events.push_back({back, -density, 0, -1});
        } else {
            events.push_back({z, 0, tau, 0});
        }
    }
    std::stable_sort(events.begin(), events.end(), [](const Event& a, const Event& b) { return a.depth < b.depth; });
}

void addPieces(const std::vector<Event>& events, DepthPicture& out) {
    double density = 0, before = 0;
    int volumes = 0;
    float at = 0;
    const auto add = [&](float end, double tau) {
        if (!(tau > 0)) return;
        out.pieces.push_back({at, end, static_cast<float>(tau), static_cast<float>(before)});
        out.thin = out.thin || tau < kInfinity;
        before += tau;
    };
    for (const Event& event : events) {
        if (volumes > 0 && event.depth > at) add(event.depth, density * (double(event.depth) - double(at)));
        at = event.depth;
        density += event.density;
        volumes += event.volumes;
        if (volumes == 0) density = 0;  // without the residue of rounding
        if (event.volumes == 0) add(at, event.tau);
        if (before == kInfinity) return;
    }
}

}  // namespace

DepthPicture::Pieces DepthPicture::at(int x, int y) const {
    if (!window.contains(x, y)) return {};
    const std::size_t i = std::size_t(y - window.y0) * std::size_t(window.width()) + std::size_t(x - window.x0);
    return Pieces(pieces).subspan(first[i], first[i + 1] - first[i]);
}

double opaqueFrom(DepthPicture::Pieces pieces) {
    const bool any = !pieces.empty() && std::isinf(pieces.back().tau);
    return any ? double(pieces.back().begin) : kInfinity;
}

double seenShare(DepthPicture::Pieces pieces, double near, double far, double tau) {
    auto piece = std::partition_point(pieces.begin(), pieces.end(), [&](const Piece& p) { return p.end < near; });
    double before = 0;  // optical depth of the pieces so far
    if (piece != pieces.end())
        before = piece->before;
    else if (!pieces.empty())
        before = double(pieces.back().before) + double(pieces.back().tau);
    const double length = far - near;
    if (!(length > 0) || piece == pieces.end() || piece->begin >= far) return std::exp(-before);
    double sum = 0, at = near;
    // Adds a piece over [at, to) of the extinction `density`.
    const auto add = [&](double to, double density) {
        const double way = to - at;
        if (!(way > 0)) return;
        sum += std::exp(-before - tau * (at - near) / length) * way / length * meanLeft((density + tau / length) * way);
        before += density * way;
        at = to;
    };
    for (; piece != pieces.end() && piece->begin < far; ++piece) {
        add(piece->begin, 0);
        if (piece->end == piece->begin) {
            before += piece->tau;
            continue;
        }
        const double density = double(piece->tau) / (double(piece->end) - double(piece->begin));
        if (piece->begin < at) before = piece->before + density * (at - piece->begin);
        add(std::min<double>(piece->end, far), density);
    }
    add(far, 0);
    return std::clamp(sum / meanLeft(tau), 0.0, 1.0);
}

DepthPicture depthPictureOf(const FileDepth& file, const DepthMeaning& meaning) {
    DepthPicture out;
    out.window = {file.x0, file.y0, file.x0 + file.width, file.y0 + file.height};
    out.alongRay = meaning.alongRay;
    out.first.reserve(out.window.pixelCount() + 1);
    out.first.push_back(0);
    std::vector<Event> events;
    std::size_t sample = 0;
    for (std::size_t i = 0; i < out.window.pixelCount(); ++i) {
        events.clear();
        if (file.deep) {
            const std::size_t count = file.counts[i];
            addEvents(std::span(file.samples).subspan(3 * sample, 3 * count), meaning.background, events);
            sample += count;
        } else if (isThere(file.depths[i], meaning.background)) {
            events.push_back({file.depths[i], 0, kInfinity, 0});
        }
        addPieces(events, out);
        out.first.push_back(static_cast<std::uint32_t>(out.pieces.size()));
    }
    out.pieces.shrink_to_fit();
    return out;
}

}  // namespace scrim
