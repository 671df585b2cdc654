// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/point_raster.h>

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/geometry/bounds.h>

#include <fmt/format.h>
#include <glm/common.hpp>

#include <algorithm>
#include <cmath>
#include <deque>
#include <numbers>
#include <utility>

namespace scrim {
namespace {

/// Smaller balls, in voxels, are sums of parts, each of which eight voxels share; larger ones are drawn voxel by voxel.
constexpr float kSmall = 1.5f;
constexpr int kMostParts = 6;  // along the diameter of a small ball: four for each voxel

constexpr int kKeyBits = 21;                                // of a cube's coordinate
constexpr int kMostCube = 1 << (kKeyBits - 1);              // cubes from the origin
constexpr double kMostIndex = 8.0 * (kMostCube - 1);        // voxels from the origin
constexpr std::size_t kUsualBlocks = 1 << 18;               // what finer voxels may take by themselves: 512 MB
constexpr std::size_t kMostBlocks = std::size_t{1} << 22;   // 8 GB
constexpr std::size_t kMostTouches = std::size_t{1} << 28;  // pairs of stamps and blocks
constexpr double kFinest = 0.5;                             // edge of the finest voxels, in radii

/// Places of equal parts of a ball of radius 1, by their number along the diameter. Their mean is its centre.
const std::vector<Vec3>& partsOf(int across) {
    static const std::array<std::vector<Vec3>, kMostParts + 1> all = [] {
        std::array<std::vector<Vec3>, kMostParts + 1> parts;
        for (int n = 1; n <= kMostParts; ++n)
            for (int i = 0; i < n * n * n; ++i) {
                const Vec3 at = (Vec3(i / (n * n), i / n % n, i % n) + 0.5) * (2.0 / n) - 1.0;
                if (glm::dot(at, at) <= 1) parts[std::size_t(n)].push_back(at);
            }
        return parts;
    }();
    return all[std::size_t(across)];
}

int partsAcross(float radius) {
    return std::clamp(static_cast<int>(std::ceil(4 * radius)), 1, kMostParts);
}

struct VoxelBox {
    Int3 lower, upper;  // inclusive
};

VoxelBox voxelsOf(const PointStamp& stamp) {
    const double radius = double(stamp.radius);
    if (stamp.radius < kSmall) {
        const double reach = radius * (1 - 1.0 / partsAcross(stamp.radius));
        return {Int3(glm::floor(stamp.is - reach)), Int3(glm::floor(stamp.is + reach)) + 1};
    }
    return {Int3(glm::ceil(stamp.is - (radius + 0.5))), Int3(glm::floor(stamp.is + (radius + 0.5)))};
}

/// Calls visit(voxel, part) for the voxels of a stamp in the box, which small balls may visit several times.
template <typename Visit>
void visitVoxels(const PointStamp& stamp, const VoxelBox& box, const Visit& visit) {
    if (stamp.radius < kSmall) {
        for (const Vec3& part : partsOf(partsAcross(stamp.radius))) {
            const Vec3 at = stamp.is + double(stamp.radius) * part, floor = glm::floor(at), beyond = at - floor;
            for (int corner = 0; corner < 8; ++corner) {
                const Int3 step(corner >> 2, corner >> 1 & 1, corner & 1), voxel = Int3(floor) + step;
                if (voxel != glm::clamp(voxel, box.lower, box.upper)) continue;
                const Vec3 weight = glm::mix(1.0 - beyond, beyond, Vec3(step));
                visit(voxel, static_cast<float>(weight.x * weight.y * weight.z));
            }
        }
        return;
    }
    const VoxelBox own = voxelsOf(stamp);
    const Int3 lower = glm::max(own.lower, box.lower), upper = glm::min(own.upper, box.upper);
    for (int x = lower.x; x <= upper.x; ++x)
        for (int y = lower.y; y <= upper.y; ++y)
            for (int z = lower.z; z <= upper.z; ++z) {
                const auto distance = static_cast<float>(glm::distance(Vec3(x, y, z), stamp.is));
                const float part = std::min(stamp.radius + 0.5f - distance, 1.0f);
                if (part > 0) visit(Int3(x, y, z), part);
            }
}

std::uint64_t keyOf(const Int3& cube) {
    const auto part = [](int i) { return static_cast<std::uint64_t>(i + kMostCube); };
    return part(cube.x) << (2 * kKeyBits) | part(cube.y) << kKeyBits | part(cube.z);
}

Int3 cubeOf(std::uint64_t key) {
    const auto part = [&](int shift) {
        return static_cast<int>(key >> shift & ((std::uint64_t{1} << kKeyBits) - 1)) - kMostCube;
    };
    return {part(2 * kKeyBits), part(kKeyBits), part(0)};
}

template <typename Visit>
void visitCubes(const PointStamp& stamp, const Visit& visit) {
    const VoxelBox box = voxelsOf(stamp);
    const Int3 lower = box.lower >> 3, upper = box.upper >> 3;
    for (int x = lower.x; x <= upper.x; ++x)
        for (int y = lower.y; y <= upper.y; ++y)
            for (int z = lower.z; z <= upper.z; ++z) visit(keyOf({x, y, z}));
}

/// The number of blocks that a stamp may touch.
double cubesOf(const PointStamp& stamp) {
    const VoxelBox box = voxelsOf(stamp);
    const Vec3 cubes((box.upper >> 3) - (box.lower >> 3) + 1);
    return cubes.x * cubes.y * cubes.z;
}

bool isFinite(const Vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

PointBlocks sorted(std::vector<PointStamp> stamps, const std::string& where) {
    double touches = 0;
    for (const PointStamp& stamp : stamps) touches += cubesOf(stamp);
    if (touches > double(kMostTouches))
        throw Error(ErrorKind::input, fmt::format("{}: its points would touch {:.3g} blocks of voxels; expected larger "
                                                  "voxels ('voxel' of points) or shorter ways",
                                                  where, touches));
    std::vector<std::pair<std::uint64_t, std::uint32_t>> pairs;
    pairs.reserve(static_cast<std::size_t>(touches));
    for (std::size_t i = 0; i < stamps.size(); ++i)
        visitCubes(stamps[i], [&](std::uint64_t key) { pairs.emplace_back(key, static_cast<std::uint32_t>(i)); });
    std::sort(pairs.begin(), pairs.end());
    PointBlocks out;
    out.stamps = std::move(stamps);
    for (std::size_t i = 0; i < pairs.size(); ++i) {
        if (i == 0 || pairs[i].first != pairs[i - 1].first) {
            out.origins.push_back(cubeOf(pairs[i].first) * kBlockEdge);
            out.first.push_back(i);
        }
        out.touching.push_back(pairs[i].second);
    }
    out.first.push_back(pairs.size());
    return out;
}

}  // namespace

std::optional<PointRadii> ownRadii(const PointCloud& cloud) {
    for (const auto& [name, scale] : {std::pair("pscale", 1.0), {"radius", 1.0}, {"width", 0.5}, {"widths", 0.5}})
        if (const PointAttribute* const own = cloud.attribute(name); own != nullptr && own->width == 1)
            return PointRadii{own, scale};
    return {};
}

PointRaster::PointRaster(PointCloud cloud, const PointLook& look, const std::string& where, const MessageSink& messages,
                         bool listed)
    : m_cloud(std::move(cloud)), m_look(look), m_where(where) {
    if (!listed) m_look.sharp = false;
    keepSound(messages);
    chooseVoxel(messages);
}

/// Finds each point's radius and weight, and removes the points that have none.
void PointRaster::keepSound(const MessageSink& messages) {
    const std::optional<PointRadii> own = m_look.radius > 0 ? std::nullopt : ownRadii(m_cloud);
    const PointAttribute* factor = m_cloud.attribute("density");
    if (factor != nullptr && factor->width != 1) factor = nullptr;
    double all = m_look.radius;
    if (all == 0 && !own) {
        all = 0.5 * m_cloud.spacing;
        notify(messages, Severity::info,
               fmt::format("{}: points '{}' have no radius (pscale, radius or width): {:.3g} is taken, half of their "
                           "spacing",
                           m_where, shortened(m_cloud.name, 80), all));
    }
    std::vector<std::size_t> kept;
    for (std::size_t i = 0; i < m_cloud.positions.size(); ++i) {
        const double r = m_look.scale * (own ? own->scale * double(own->attribute->values[i]) : all);
        const double times = factor != nullptr ? double(factor->values[i]) : 1;
        const auto radius = static_cast<float>(r);
        const auto weight = static_cast<float>(times * std::numbers::pi * r * r * (m_look.discs ? 1 : 4.0 / 3 * r));
        const bool sound = isFinite(m_cloud.positions[i]) && radius > 0 && std::isfinite(radius) && weight > 0 &&
                           std::isfinite(weight);
        if (!sound) continue;
        kept.push_back(i);
        m_radii.push_back(radius);
        m_weights.push_back(weight);
    }
    if (kept.size() == m_cloud.positions.size()) return;
    notify(messages, Severity::warning,
           fmt::format(
               "{}: {} of {} points '{}' are left out: their places are not finite, or their radii or densities "
               "not above 0",
               m_where, m_cloud.positions.size() - kept.size(), m_cloud.positions.size(), shortened(m_cloud.name, 80)));
    for (std::size_t i = 0; i < kept.size(); ++i) m_cloud.positions[i] = m_cloud.positions[kept[i]];
    m_cloud.positions.resize(kept.size());
    for (PointAttribute& attribute : m_cloud.attributes) {
        const auto width = static_cast<std::size_t>(attribute.width);
        for (std::size_t i = 0; i < kept.size(); ++i)
            for (std::size_t c = 0; c < width; ++c)
                attribute.values[i * width + c] = attribute.values[kept[i] * width + c];
        attribute.values.resize(kept.size() * width);
    }
}

/// A box around all points.
Bounds PointRaster::wsBounds() const {
    Bounds ws;
    for (std::size_t i = 0; i < m_radii.size(); ++i) {
        ws.include(m_cloud.positions[i] - double(m_radii[i]));
        ws.include(m_cloud.positions[i] + double(m_radii[i]));
    }
    return ws;
}

bool PointRaster::spans(double voxel) const {
    return largest(wsBounds().size()) < kMostIndex * voxel;
}

void PointRaster::setVoxel(double voxel) {
    m_voxel = voxel;
    const Bounds ws = wsBounds();
    // The lattice begins at the origin, or in large steps from it, so that it stays from frame to frame.
    const double step = 0.25 * kMostIndex * voxel;
    const Vec3 origin = ws.empty() ? Vec3(0) : step * glm::round(ws.center() / step);
    for (int axis = 0; axis < 3 && !ws.empty(); ++axis) {
        const double reach = std::max(ws.upper[axis] - origin[axis], origin[axis] - ws.lower[axis]);
        if (!(reach + 64 * voxel < kMostIndex * voxel))
            throw Error(ErrorKind::input,
                        fmt::format("{}: its points lie {:.3g} apart, which voxels of {:.3g} cannot span; expected a "
                                    "'voxel' of points of at least {:.3g}",
                                    m_where, largest(ws.size()), voxel, largest(ws.size()) / kMostIndex));
    }
    m_wsFromIs = Mat4(voxel);
    m_wsFromIs[3] = glm::dvec4(origin, 1.0);
}

/// Half of the usual radius, so that a ball is four voxels across; or twice that, and so on, where
/// that takes too much memory.
void PointRaster::chooseVoxel(const MessageSink& messages) {
    constexpr double kAsPoints = 2;  // radii
    if (m_radii.empty()) return setVoxel(m_look.voxel > 0 ? m_look.voxel : 1);
    std::vector<float> radii = m_radii;
    std::nth_element(radii.begin(), radii.begin() + std::ptrdiff_t(radii.size() / 2), radii.end());
    const auto usual = double(radii[radii.size() / 2]);
    if (m_look.voxel > 0) {
        m_sharp = m_look.sharp.value_or(2 * usual < m_look.voxel);
        return setVoxel(m_look.voxel);
    }
    m_sharp = m_look.sharp.value_or(areFarApart(kFinest * usual));
    if (m_sharp) return chooseForLight(usual, messages);
    std::size_t blocks = kUsualBlocks + 1, sharp = 0;
    double part = kFinest;
    for (; blocks > kUsualBlocks; part *= 2) {
        if (!spans(part * usual)) continue;
        setVoxel(part * usual);
        blocks = countBlocks(part == kAsPoints ? kMostBlocks : kUsualBlocks);
        if (part == kAsPoints) sharp = blocks;
    }
    const auto megabytes = [](std::size_t count) { return double(count) * kBlockVoxels * sizeof(float) / 1e6; };
    notify(
        messages, Severity::info,
        fmt::format("{}: {} points '{}' of a usual radius of {:.3g} become voxels of {:.3g} in {} blocks ({:.0f} MB "
                    "a grid); 'voxel' of points changes this",
                    m_where, m_radii.size(), shortened(m_cloud.name, 80), usual, m_voxel, blocks, megabytes(blocks)));
    if (m_voxel > 2 * kAsPoints * usual)
        notify(messages, Severity::warning,
               fmt::format("{}: its points are far apart, and blurred to voxels of {:.3g} to save memory; a 'voxel' of "
                           "points of {:.3g} shows each of them, and takes {}{:.0f} MB a grid",
                           m_where, m_voxel, kAsPoints * usual, sharp > kMostBlocks ? "more than " : "",
                           megabytes(sharp)));
}

/// True if points fill so little of the blocks of such voxels that these blocks are as many as the points. Such a block
/// is twice the diameter of a ball wide, so its balls fill at most a fifteenth of it.
bool PointRaster::areFarApart(double voxel) {
    constexpr std::size_t kFew = 64;  // blocks that are worth no thought
    if (!spans(voxel)) return true;
    setVoxel(voxel);
    const std::size_t most = std::clamp(m_radii.size(), kFew, kMostBlocks);
    return countBlocks(most) > most;
}

/// Of points that the eye sees by themselves, voxels make the light alone: the mean of many points. They are as small
/// as a few points to a block allow, and so large that the longest side of all is a few hundred of them.
void PointRaster::chooseForLight(double usual, const MessageSink& messages) {
    constexpr std::size_t kPointsOfBlock = 32, kFew = 4096;
    constexpr double kAcross = 512;
    const double length = largest(wsBounds().size());
    std::size_t blocks = 0;
    for (double part = kFinest;; part *= 2) {
        if (part * usual * kAcross < length || !spans(part * usual)) continue;
        setVoxel(part * usual);
        const std::size_t most = std::max(m_radii.size() / kPointsOfBlock, kFew);
        blocks = countBlocks(most);
        if (blocks <= most) break;
    }
    notify(messages, Severity::info,
           fmt::format("{}: {} points '{}' of a usual radius of {:.3g} are seen by themselves; their light is that of "
                       "voxels of {:.3g} in {} blocks, which 'voxel' of points changes",
                       m_where, m_radii.size(), shortened(m_cloud.name, 80), usual, m_voxel, blocks));
}

/// The number of blocks, or one more than `most`.
std::size_t PointRaster::countBlocks(std::size_t most) const {
    std::vector<std::uint64_t> keys;
    const auto settle = [&] {
        std::sort(keys.begin(), keys.end());
        keys.erase(std::unique(keys.begin(), keys.end()), keys.end());
    };
    std::size_t limit = 4 * most;
    for (std::size_t i = 0; i < m_radii.size(); ++i) {
        const PointStamp stamp = stampAt(i, m_cloud.positions[i], 0);
        if (cubesOf(stamp) > double(most)) return most + 1;
        visitCubes(stamp, [&](std::uint64_t key) {
            if (keys.empty() || keys.back() != key) keys.push_back(key);
        });
        if (keys.size() <= limit) continue;
        settle();
        if (keys.size() > most) return most + 1;
        limit = keys.size() + 4 * most;
    }
    settle();
    return std::min(keys.size(), most + 1);
}

PointStamp PointRaster::stampAt(std::size_t point, const Vec3& ws, float wider) const {
    PointStamp stamp;
    stamp.is = (ws - Vec3(m_wsFromIs[3])) / m_voxel;
    stamp.radius = static_cast<float>(double(m_radii[point]) / m_voxel) + wider;
    stamp.point = static_cast<std::uint32_t>(point);
    return stamp;
}

PointBlocks PointRaster::blocks() const {
    std::vector<PointStamp> stamps(m_radii.size());
    parallelChunks(stamps.size(), [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            stamps[i] = stampAt(i, m_cloud.positions[i], 0);
            double sum = 0;
            visitVoxels(stamps[i], voxelsOf(stamps[i]), [&](const Int3&, float part) { sum += double(part); });
            stamps[i].norm = static_cast<float>(1 / sum);
        }
    });
    return sorted(std::move(stamps), m_where);
}

PointBlocks PointRaster::blocksOnWay(const PointAttribute* velocity) const {
    // Beyond the ball and its interpolated rim, the velocity itself is interpolated.
    constexpr float kWider = 1.5f;
    constexpr double kMostSteps = 1000, kStep = 0.5;  // radii of a stamp
    std::vector<PointStamp> stamps;
    for (std::size_t i = 0; i < m_radii.size(); ++i) {
        const float* const v = velocity == nullptr ? nullptr : velocity->values.data() + 3 * i;
        const Vec3 way = v == nullptr ? Vec3(0) : Vec3(v[0], v[1], v[2]);
        const Vec3 from = m_cloud.positions[i] + m_look.open * way, to = m_cloud.positions[i] + m_look.close * way;
        PointStamp stamp = stampAt(i, m_cloud.positions[i], kWider);
        const double steps = glm::distance(from, to) / m_voxel / (kStep * double(stamp.radius));
        const auto count = static_cast<int>(std::clamp(std::ceil(steps), 1.0, kMostSteps)) + 1;
        const bool moves = isFinite(from) && isFinite(to) && steps > 0;
        for (int k = 0; k < (moves ? count : 1); ++k) {
            if (moves) stamp.is = stampAt(i, glm::mix(from, to, double(k) / (count - 1)), kWider).is;
            const double beyond = largest(glm::abs(stamp.is)) + double(stamp.radius) + 2;
            if (beyond < kMostIndex) stamps.push_back(stamp);
        }
    }
    return sorted(std::move(stamps), m_where);
}

void PointRaster::fill(const PointBlocks& blocks, std::size_t block, const PointAttribute* attribute, Sums& out) const {
    out.density.fill(0);
    for (auto& mean : out.means) mean.fill(0);
    const Int3 origin = blocks.origins[block];
    const VoxelBox box{origin, origin + (kBlockEdge - 1)};
    const double perVoxel = 1 / (m_voxel * m_voxel * m_voxel);
    const int width = attribute == nullptr ? 0 : attribute->width;
    for (std::size_t t = blocks.first[block]; t < blocks.first[block + 1]; ++t) {
        const PointStamp& stamp = blocks.stamps[blocks.touching[t]];
        const auto weight = static_cast<float>(perVoxel * double(m_weights[stamp.point])) * stamp.norm;
        const float* const own =
            attribute == nullptr ? nullptr : attribute->values.data() + std::size_t(width) * stamp.point;
        visitVoxels(stamp, box, [&](const Int3& voxel, float part) {
            const Int3 in = voxel - origin;
            const auto at = static_cast<std::size_t>(blockOffset(in.x, in.y, in.z));
            out.density[at] += weight * part;
            for (int c = 0; c < width; ++c) out.means[std::size_t(c)][at] += weight * part * own[c];
        });
    }
    for (int c = 0; c < width; ++c)
        for (std::size_t i = 0; i < kBlockVoxels; ++i)
            if (out.density[i] > 0) out.means[std::size_t(c)][i] /= out.density[i];
}

std::vector<SparseField> PointRaster::fields(const PointBlocks& blocks, const PointAttribute* attribute,
                                             const std::vector<Wanted>& wanted, BlockMemory& memory) const {
    std::deque<FieldFill> fills;
    for (const Wanted& one : wanted) {
        FieldPieces pieces;
        pieces.name = one.name;
        pieces.wsFromIs = m_wsFromIs;
        pieces.blockOrigins = blocks.origins;
        fills.emplace_back(std::move(pieces), memory);
    }
    parallelFor(blocks.origins.size(), [&](std::size_t block) {
        Sums sums;
        fill(blocks, block, attribute, sums);
        for (std::size_t f = 0; f < wanted.size(); ++f) {
            const auto& from = attribute == nullptr ? sums.density : sums.means[std::size_t(wanted[f].component)];
            float* const to = fills[f].block(block);
            for (std::size_t i = 0; i < kBlockVoxels; ++i) {
                const float value = wanted[f].part == GridPart::negative ? -from[i] : from[i];
                to[i] = wanted[f].part == GridPart::whole || !(value < 0) ? value : 0;
            }
            fills[f].filled(block);
        }
    });
    std::vector<SparseField> out;
    for (FieldFill& fill : fills) out.push_back(fill.finish());
    return out;
}

SparseField PointRaster::list(const Listed& wanted, BlockMemory& memory) const {
    FieldPieces pieces;
    pieces.name = wanted.name;
    const std::size_t count = m_sharp ? m_radii.size() : 0;
    const Bounds ws = wsBounds();
    const Vec3 size = count == 0 ? Vec3(1) : ws.size();  // above 0, since radii are
    for (int axis = 0; axis < 3; ++axis) pieces.wsFromIs[axis][axis] = size[axis];
    if (count > 0) pieces.wsFromIs[3] = glm::dvec4(ws.lower, 1.0);
    for (std::size_t i = 0; i < count; i += kBlockVoxels)
        pieces.blockOrigins.emplace_back(static_cast<int>(i / kBlockVoxels) * kBlockEdge, 0, 0);
    const auto valueOf = [&](std::size_t i) {
        const auto c = static_cast<std::size_t>(std::max(wanted.component, 0));
        if (wanted.part == GridPart::places)
            return wanted.component == GridRequest::kScalar
                       ? m_radii[i]
                       : static_cast<float>((m_cloud.positions[i][int(c)] - ws.lower[int(c)]) / size[int(c)]);
        if (wanted.attribute != nullptr) {
            const float value = wanted.attribute->values[i * std::size_t(wanted.attribute->width) + c];
            if (wanted.part == GridPart::positiveOfPoints) return std::max(value, 0.0f);
            return wanted.part == GridPart::negativeOfPoints ? std::max(-value, 0.0f) : value;
        }
        const double r = double(m_radii[i]), own = std::numbers::pi * r * r * (m_look.discs ? 1 : 4.0 / 3 * r);
        return static_cast<float>(double(m_weights[i]) / own);
    };
    pieces.fill = [&](std::size_t block, float* to) {
        const std::size_t first = block * kBlockVoxels;
        for (std::size_t i = 0; i < kBlockVoxels; ++i) to[i] = first + i < count ? valueOf(first + i) : 0;
    };
    return buildField(std::move(pieces), memory);
}

}  // namespace scrim
