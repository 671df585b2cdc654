// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/composite/pixel_tiles.h>
#include <scrim/base/parallel.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include <glm/geometric.hpp>

namespace scrim {

Box2<int> PixelTiles::tilesIn(const Box2<double>& positions) const {
    const auto tile = [](double position, int origin, int tiles) {
        return static_cast<int>(std::clamp(std::floor((position - origin) / kTileEdge), -1.0, double(tiles)));
    };
    return intersection<int>(
        {0, 0, m_tilesX, m_tilesY},
        {tile(positions.x0, m_window.x0, m_tilesX), tile(positions.y0, m_window.y0, m_tilesY),
         tile(positions.x1, m_window.x0, m_tilesX) + 1, tile(positions.y1, m_window.y0, m_tilesY) + 1});
}

const std::uint8_t* PixelTiles::closed(int tile, int block, Real cutoff) {
    std::uint8_t* const closed = m_closed.data() + std::size_t(tile) * kTileSize;
    if (int& at = m_closedAt[std::size_t(tile)]; at != block) {
        at = block;
        const Real* last = states(tile) + m_layout.floats() - 1;  // the smallest opacity
        for (int k = 0; k < kTileSize; ++k, last += m_layout.floats()) closed[k] = 1 + *last < cutoff ? 1 : 0;
    }
    return closed;
}

bool PixelTiles::anyOpen(const Box2<int>& tiles) const {
    const Box2<int> box = intersection(tiles, {0, 0, m_tilesX, m_tilesY});
    for (int ty = box.y0; ty < box.y1; ++ty)
        for (int tx = box.x0; tx < box.x1; ++tx)
            if (!opaque(ty * m_tilesX + tx)) return true;
    return false;
}

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

bool holds(const Solids* solids) {
    return solids != nullptr && solids->any(SolidRole::holdout);
}

}  // namespace

bool EyeEnds::any(const ViewScene& scene) {
    return holds(scene.solids.get()) || scene.depths;
}

EyeEnds::EyeEnds(const ViewScene& scene, const PixelTiles& tiles)
    : m_picture(scene.depths),
      m_rayFamily(wsRays(supersampled(scene.camera, scene.dials.antialias))),
      m_antialias(scene.dials.antialias),
      m_depths(std::size_t(tiles.count())),
      m_thin(std::size_t(tiles.count())) {
    const Solids* const solids = holds(scene.solids.get()) ? scene.solids.get() : nullptr;
    if (solids) m_rays = std::uint64_t{kTileSize} * m_depths.size();
    const auto keep = [](const std::vector<double>& from, std::vector<double>& to) {
        if (*std::min_element(from.begin(), from.end()) < kInfinity) to = from;
    };
    parallelFor(m_depths.size(), [&](std::size_t i) {
        const auto tile = static_cast<int>(i);
        std::vector<double> depths(kTileSize, kInfinity), thin(kTileSize, kInfinity);
        for (std::size_t k = 0; k < kTileSize; ++k) {
            const double x = tiles.cornerX(tile) + static_cast<int>(k) % kTileEdge + 0.5,
                         y = tiles.cornerY(tile) + static_cast<int>(k) / kTileEdge + 0.5;
            // Directions are scaled so that the ray's parameter is depth.
            if (solids)
                depths[k] = solids->firstHit(SolidRole::holdout, m_rayFamily.origin(x, y), m_rayFamily.direction(x, y),
                                             m_rayFamily.near, kInfinity);
            const DepthPicture::Pieces pieces = piecesAt(x, y);
            if (pieces.empty()) continue;
            depths[k] = std::min(depths[k], opaqueFrom(pieces) / unitAt(x, y));
            if (std::isfinite(pieces.front().tau)) thin[k] = pieces.front().begin / unitAt(x, y);
        }
        keep(depths, m_depths[i]);
        keep(thin, m_thin[i]);
    });
}

// All rays of a pixel see the pieces of the one pixel in the depth picture.
DepthPicture::Pieces EyeEnds::piecesAt(double x, double y) const {
    if (!m_picture) return {};
    return m_picture->at(static_cast<int>(std::floor(x / m_antialias)), static_cast<int>(std::floor(y / m_antialias)));
}

// What the picture stores for a depth of 1 along the viewing axis.
double EyeEnds::unitAt(double x, double y) const {
    return m_picture && m_picture->alongRay ? glm::length(m_rayFamily.direction(x, y)) : 1;
}

double EyeEnds::seenShare(double x, double y, double near, double far, double tau) const {
    const double unit = unitAt(x, y);
    return scrim::seenShare(piecesAt(x, y), near * unit, far * unit, tau);
}

std::size_t EyeEnds::bytes() const {
    std::size_t sum = 0;
    for (const auto* tiles : {&m_depths, &m_thin})
        for (const std::vector<double>& own : *tiles) sum += own.size() * sizeof(double);
    return sum;
}

namespace {

// Sums for a pixel's motion before division: right and up times opacity, and the opacities of both.
constexpr std::size_t kMotionSums = 4;

FrameLayer* find(Frame& frame, Layer layer, int light = -1, int volume = -1) {
    for (FrameLayer& l : frame.layers)
        if (l.layer == layer && l.light == light && l.volume == volume) return &l;
    return nullptr;
}

// The layer that receives an output of a group, and its weight.
struct Target {
    int quad;
    FrameLayer* layer;
    double share;
};

std::vector<Target> targetsOf(const GroupPlan& group, Frame& frame) {
    std::vector<Target> targets;
    for (std::size_t i = 0; i < group.outputs.list.size(); ++i) {
        const Output& output = group.outputs.list[i];
        // Outputs of lights, ambient light, emission and volumes already contain the group's share.
        const bool seen = output.layer == Layer::albedo || output.layer == Layer::depth ||
                          output.layer == Layer::motion || output.layer == Layer::cryptomatte;
        targets.push_back({group.outputs.layout.quadOf(static_cast<int>(i) + 1),
                           find(frame, output.layer, output.light, output.place), seen ? group.primary : 1.0});
    }
    return targets;
}

// The sums of the states of a pixel's rays, quad by quad, and the smallest of their depths.
struct PixelSum {
    std::vector<Real> floats;
    Real first = 0;

    void clear() {
        std::fill(floats.begin(), floats.end(), Real(0));
        first = 0;
    }
};

void sumRays(const PixelTiles& tiles, int n, int x, int y, PixelSum& sum) {
    sum.clear();
    const int count = tiles.layout().floats();
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            const Real* state = tiles.state(x * n + i, y * n + j);
            for (int f = 0; f < count; ++f) sum.floats[f] += state[f];
            if (!tiles.keepsDepth()) continue;
            const Real depth = tiles.depth(x * n + i, y * n + j);
            if (depth > 0 && (sum.first == 0 || depth < sum.first)) sum.first = depth;
        }
}

// What a pixel's rays lose of the backdrop in the volumes: the sum of its radiance and alpha times their opacity.
using Hidden = std::array<float, 4>;
Hidden hiddenOf(const PixelTiles& tiles, int n, int x, int y, const BackdropRays& backdrop) {
    const OutputLayout& layout = tiles.layout();
    const int opacities = layout.floats() - 4;
    Hidden sum{};
    for (int j = 0; j < n; ++j)
        for (int i = 0; i < n; ++i) {
            const auto& seen = backdrop.ray(x * n + i, y * n + j);
            const Real* state = tiles.state(x * n + i, y * n + j) + opacities;
            const Hidden opacity = layout.coloured
                                       ? Hidden{-state[0], -state[1], -state[2], -(state[0] + state[1] + state[2]) / 3}
                                       : Hidden{-state[3], -state[3], -state[3], -state[3]};
            for (std::size_t c = 0; c < 4; ++c) sum[c] += seen[c] * opacity[c];
        }
    return sum;
}

}  // namespace

Frame emptyFrame(const ViewScene& scene) {
    Frame frame;
    frame.image = emptyImage(scene.region);
    const auto add = [&](Layer layer, int light, int volume) {
        FrameLayer& out = frame.layers.emplace_back(FrameLayer{layer, light, {}, volume});
        const std::size_t floats = layer == Layer::motion ? kMotionSums : out.channels();
        out.data.assign(floats * scene.region.pixelCount(), 0.0f);
    };
    for (const Layer layer : scene.layers) {
        if (layer == Layer::light || layer == Layer::shadow) {
            for (int i = 0; i < static_cast<int>(scene.lights.size()); ++i)
                if (layer == Layer::shadow || lightOfLayer(scene, i) == i) add(layer, i, -1);
        } else if (layer == Layer::volume || layer == Layer::cryptomatte)
            for (std::size_t i = 0; i < placesOf(scene); ++i) add(layer, -1, static_cast<int>(i));
        else
            add(layer, -1, -1);
    }
    return frame;
}

void resolve(const ViewScene& scene, const Plan& plan, const GroupPlan& group, const PixelTiles& tiles, Frame& frame) {
    const EyePart& part = plan.eyeParts[group.eyePart];
    const int n = scene.dials.antialias;
    const std::vector<Target> targets = targetsOf(group, frame);
    FrameLayer* const transmittance = group.primary > 0 ? find(frame, Layer::transmittance) : nullptr;
    const OutputLayout& layout = tiles.layout();
    const std::size_t opacities = std::size_t(layout.floats() - 4);
    const auto beauties = std::size_t(layout.beauty ? 1 : layout.quadOf(layout.beautyParts));
    parallelFor(std::size_t(part.window.height()), [&](std::size_t row) {
        PixelSum sum{std::vector<Real>(std::size_t(layout.floats())), 0};
        const int y = part.window.y0 + static_cast<int>(row);
        for (int x = part.window.x0; x < part.window.x1; ++x) {
            sumRays(tiles, n, x, y, sum);
            const double weight = part.weight(x + 0.5, y + 0.5) / (n * n);
            const std::size_t at = frame.image.indexOf(x, y);
            // Interpolation between texels rounds: nothing may become slightly negative, and opaque
            // slightly more than opaque.
            const auto radiance = [&](std::size_t f, double share) {
                return static_cast<Real>(weight * share) * std::max(sum.floats[f], Real(0));
            };
            float* pixel = frame.image.rgba.data() + at;
            // The beauty's quad, or those that add up to it; they come first in either case.
            for (std::size_t q = 0; q < beauties; ++q)
                for (std::size_t c = 0; c < 3; ++c) pixel[c] += radiance(4 * q + c, 1);
            Real hidden[3];
            for (std::size_t c = 0; c < 3; ++c)
                hidden[c] = static_cast<Real>(weight * group.primary) *
                            (layout.seen ? sum.floats[std::size_t(4 * layout.quadOf(*layout.seen)) + c]
                                         : -sum.floats[layout.coloured ? opacities + c : opacities + 3]);
            const Real alpha = layout.coloured ? (hidden[0] + hidden[1] + hidden[2]) / 3 : hidden[0];
            pixel[3] = static_cast<float>(std::clamp(pixel[3] + alpha, Real(0), Real(1)));

            for (const Target& target : targets) {
                const auto quad = std::size_t(4 * target.quad);
                if (target.layer->layer == Layer::depth) {
                    float* depth = target.layer->data.data() + at / 4 * 2;
                    if (sum.first > 0 && (depth[0] == 0 || sum.first < depth[0])) depth[0] = sum.first;
                    for (std::size_t c = 0; c < 3; ++c) depth[1] += radiance(quad + c, target.share / 3);
                } else if (target.layer->layer == Layer::cryptomatte) {
                    for (std::size_t c = 0; c < 3; ++c)
                        target.layer->data[at / 4] += radiance(quad + c, target.share / 3);
                } else if (target.layer->layer == Layer::motion) {
                    float* sums = target.layer->data.data() + at / 4 * kMotionSums;
                    for (std::size_t c = 0; c < 2; ++c) {
                        sums[c] += static_cast<Real>(weight * target.share) * sum.floats[quad + c];
                        sums[2 + c] += hidden[c];
                    }
                } else {
                    float* rgb = target.layer->data.data() + at / 4 * 3;
                    for (std::size_t c = 0; c < 3; ++c) rgb[c] += radiance(quad + c, target.share);
                }
            }
            if (transmittance)
                for (std::size_t c = 0; c < 3; ++c) transmittance->data[at / 4 * 3 + c] += hidden[c];
        }
    });
}

void beginBackdrop(const BackdropRays& backdrop, Frame& frame) {
    const PixelWindow& region = frame.image.window;
    const int n = backdrop.antialias();
    const float share = 1.0f / float(n * n);
    std::vector<float>& data = find(frame, Layer::backdrop)->data;
    data.assign(4 * region.pixelCount(), 0.0f);
    float* pixel = data.data();
    for (int y = region.y0; y < region.y1; ++y)
        for (int x = region.x0; x < region.x1; ++x, pixel += 4)
            for (int k = 0; k < n * n; ++k) {
                const auto& seen = backdrop.ray(x * n + k % n, y * n + k / n);
                for (std::size_t c = 0; c < 4; ++c) pixel[c] += share * seen[c];
            }
}

void takeFromBackdrop(const Plan& plan, const GroupPlan& group, const PixelTiles& tiles, const BackdropRays& backdrop,
                      Frame& frame) {
    if (!(group.primary > 0)) return;
    std::vector<float>& data = find(frame, Layer::backdrop)->data;
    const EyePart& part = plan.eyeParts[group.eyePart];
    const int n = backdrop.antialias();
    parallelFor(std::size_t(part.window.height()), [&](std::size_t row) {
        const int y = part.window.y0 + static_cast<int>(row);
        for (int x = part.window.x0; x < part.window.x1; ++x) {
            const auto weight = static_cast<float>(part.weight(x + 0.5, y + 0.5) / (n * n) * group.primary);
            const Hidden lost = hiddenOf(tiles, n, x, y, backdrop);
            float* pixel = data.data() + frame.image.indexOf(x, y);
            for (std::size_t c = 0; c < 4; ++c) pixel[c] -= weight * lost[c];
        }
    });
}

void finishBackdrop(Frame& frame) {
    std::vector<float>& data = find(frame, Layer::backdrop)->data;
    std::vector<float> rgb;
    for (std::size_t i = 0; i < data.size(); ++i) {
        const float seen = std::max(data[i], 0.0f);
        float& value = frame.image.rgba[i];
        value += seen;
        if (i % 4 == 3)
            value = std::min(value, 1.0f);
        else
            rgb.push_back(seen);
    }
    data = std::move(rgb);
}

void finishLayers(Frame& frame) {
    FrameLayer *const direct = find(frame, Layer::direct), *const indirect = find(frame, Layer::indirect);
    for (std::size_t i = 0; direct && indirect && i < direct->data.size(); ++i)
        direct->data[i] = std::max(frame.image.rgba[i / 3 * 4 + i % 3] - indirect->data[i], 0.0f);
    for (FrameLayer& layer : frame.layers) {
        if (layer.layer == Layer::motion) {
            const std::vector<float> sums = std::move(layer.data);
            layer.data.assign(sums.size() / 2, 0.0f);
            for (std::size_t i = 0; i < layer.data.size(); ++i) {
                const float hidden = sums[i / 2 * kMotionSums + 2 + i % 2];
                if (hidden > 0) layer.data[i] = sums[i / 2 * kMotionSums + i % 2] / hidden;
            }
        }
        if (layer.layer == Layer::transmittance)
            for (float& value : layer.data) value = std::clamp(1 - value, 0.0f, 1.0f);
        if (layer.layer != Layer::depth) continue;
        for (std::size_t i = 0; i < layer.data.size(); i += 2) {
            const float alpha = frame.image.rgba[2 * i + 3];
            layer.data[i + 1] = alpha > 0 ? layer.data[i + 1] / alpha : 0.0f;
        }
    }
}

}  // namespace scrim
