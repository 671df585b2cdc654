// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/light/volume_shine.h>

#include <scrim/base/parallel.h>
#include <scrim/engine/light/marched_light.h>
#include <scrim/engine/model/sub_lights.h>
#include <scrim/engine/solve/scattered_light.h>
#include <scrim/scene/split_phase.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include <glm/common.hpp>
#include <glm/exponential.hpp>
#include <glm/geometric.hpp>

namespace scrim {
namespace {

constexpr int kAlong = 64;  // finest cells along the cube; those at its border stay empty
constexpr int kCones = 256;
constexpr int kSubLights = 8;  // of an extended light

bool black(const Rgb& rgb) {
    return rgb.x <= 0 && rgb.y <= 0 && rgb.z <= 0;
}

bool scatters(const ViewVolume& volume) {
    return !volume.classified && !volume.field->empty() && (!black(volume.medium.albedo) || !volume.scatter.empty());
}

double voxelVolume(const Mat4& wsFromIs) {
    const Mat3 m(wsFromIs);
    return std::abs(glm::dot(m[0], glm::cross(m[1], m[2])));
}

double largestEdge(const Mat4& wsFromIs) {
    return std::max({glm::length(Vec3(wsFromIs[0])), glm::length(Vec3(wsFromIs[1])), glm::length(Vec3(wsFromIs[2]))});
}

void addPart(std::array<float, 4>& to, const std::array<float, 4>& from, float part) {
    for (std::size_t i = 0; i < 4; ++i) to[i] += part * from[i];
}

// What a beam sends against `direction` beside what it would send if it were scattered evenly.
double besideEven(const std::array<float, 4>& flow, const Vec3& direction) {
    const Vec3 beam(flow[0], flow[1], flow[2]);
    const double length = glm::length(beam);
    if (length == 0) return 0;
    const double g = std::clamp(flow[3] / length, -0.95, 0.95), cosine = -glm::dot(beam, direction) / length;
    const double x = 1 + g * g - 2 * g * cosine;
    return length * ((1 - g * g) / (x * std::sqrt(x)) - 1);
}

// Calls visit(sum of the values, voxels, centre in world space) for parts of a field of at most `edge` world units.
template <class Visit>
void forParts(const SparseField& field, const Mat4& wsFromIs, double edge, const Visit& visit) {
    const double unit = largestEdge(wsFromIs);
    int part = 1;
    while (part < kBlockEdge && 2 * part * unit <= edge) part *= 2;
    for (std::size_t b = 0; b < field.blockCount(); ++b) {
        const float* values = field.block(b);
        for (int i = 0; i < kBlockEdge; i += part)
            for (int j = 0; j < kBlockEdge; j += part)
                for (int k = 0; k < kBlockEdge; k += part) {
                    double sum = 0;
                    for (int x = i; x < i + part; ++x)
                        for (int y = j; y < j + part; ++y)
                            for (int z = k; z < k + part; ++z) sum += values[blockOffset(x, y, z)];
                    if (sum <= 0) continue;
                    const Vec3 is = Vec3(field.blockOrigins[b] + Int3(i, j, k)) + 0.5 * (part - 1);
                    visit(sum, double(part) * part * part, transformPoint(wsFromIs, is));
                }
    }
    for (const ConstantTile& tile : field.tiles) {
        int n = 1;
        while (n < kAlong && tile.edge * unit > n * edge) n *= 2;
        const double own = double(tile.edge) / n;
        for (int i = 0; i < n * n * n; ++i) {
            const Vec3 at = own * (Vec3(i / (n * n), i / n % n, i % n) + 0.5) - 0.5;
            const double voxels = own * own * own;
            visit(tile.value * voxels, voxels, transformPoint(wsFromIs, Vec3(tile.origin) + at));
        }
    }
}

}  // namespace

bool anyShines(const ViewScene& scene) {
    return std::ranges::any_of(scene.volumes, [](const ViewVolume& v) { return !v.emission.empty() || scatters(v); });
}

ViewScene withScatteredApart(const ViewScene& scene) {
    ViewScene out = scene;
    out.layers = {Layer::indirect, Layer::ambient};
    return out;
}

std::size_t VolumeShine::bytes() {
    const std::size_t finest = std::size_t(kAlong) * kAlong * kAlong;
    return finest * (sizeof(Cell) + sizeof(Flow) + 3 * sizeof(float)) / 7 * 8;
}

// What fills the finest cells.
struct VolumeShine::Making {
    const ViewScene& scene;
    Level& finest;
    Vec3 wsLower;

    // Adds an amount to the eight cells around a place by their distances: add(index of a cell, part).
    template <class Add>
    void spreadOver(const Vec3& ws, const Add& add) const {
        const Vec3 at = (ws - wsLower) / finest.edge - 0.5;
        const Int3 first(glm::floor(at));
        const Vec3 part = at - Vec3(first);
        for (int corner = 0; corner < 8; ++corner) {
            const Int3 cell = first + Int3(corner & 1, corner >> 1 & 1, corner >> 2);
            double weight = 1;
            for (int axis = 0; axis < 3; ++axis) weight *= cell[axis] > first[axis] ? part[axis] : 1 - part[axis];
            if (glm::all(glm::greaterThanEqual(cell, Int3(0))) && glm::all(glm::lessThan(cell, Int3(kAlong))))
                add(finest.indexOf(cell), weight);
        }
    }
    // Adds a field, times a factor, to the cells' means: add(index of a cell, value per world unit).
    template <class Add>
    void addField(const SparseField& field, const Mat4& wsFromIs, const Add& add) const {
        const double factor = voxelVolume(wsFromIs) / std::pow(finest.edge, 3);
        forParts(field, wsFromIs, 0.5 * finest.edge, [&](double sum, double, const Vec3& ws) {
            spreadOver(ws, [&](std::size_t cell, double weight) { add(cell, sum * factor * weight); });
        });
    }
    void addExtinction(const ViewVolume& v) const;
    void addEmission(const ViewVolume& v) const;
    void addScattered(std::size_t volume, const MarchedLight& lights, const std::vector<CellLight>& again) const;
};

void VolumeShine::Making::addExtinction(const ViewVolume& v) const {
    if (v.field->empty()) return;
    if (!v.classified) {
        const Rgb factor = v.medium.densityScale * v.medium.extinctionTint;
        return addField(*v.field, v.wsFromIs, [&](std::size_t cell, double value) {
            for (int c = 0; c < 3; ++c) finest.cells[cell].extinction[std::size_t(c)] += float(value * factor[c]);
        });
    }
    FieldSamplers samplers;
    const VolumeOptics optics(v, scene.dials.kernel, samplers);
    const double factor = voxelVolume(v.wsFromIs) / std::pow(finest.edge, 3);
    forParts(*v.field, v.wsFromIs, 0.5 * finest.edge, [&](double, double voxels, const Vec3& ws) {
        const Rgb extinction = voxels * factor * optics.extinction(ws);
        spreadOver(ws, [&](std::size_t cell, double weight) {
            for (int c = 0; c < 3; ++c) finest.cells[cell].extinction[std::size_t(c)] += float(weight * extinction[c]);
        });
    });
}

void VolumeShine::Making::addEmission(const ViewVolume& v) const {
    for (const ViewEmission& e : v.emission)
        addField(*e.field.field, e.field.wsFromIs, [&](std::size_t cell, double value) {
            for (int c = 0; c < 3; ++c) finest.cells[cell].source[std::size_t(c)] += float(value * e.color[c]);
        });
}

// Light is looked up in cells twice as large.
void VolumeShine::Making::addScattered(std::size_t volume, const MarchedLight& lights,
                                       const std::vector<CellLight>& again) const {
    const ViewVolume& v = scene.volumes[volume];
    const double scale = v.medium.densityScale;
    std::vector<Rgb> scattering(finest.cells.size(), Rgb(0));
    for (std::size_t c = 0; c < (v.scatter.empty() ? 1 : 3); ++c)
        addField(v.scatter.empty() ? *v.field : *v.scatter[c].field, v.wsFromIs, [&](std::size_t cell, double value) {
            if (v.scatter.empty())
                scattering[cell] += scale * value * v.medium.extinctionTint * v.medium.albedo;
            else
                scattering[cell][int(c)] += scale * value * v.medium.extinctionTint[int(c)];
        });
    const double cosine = legendreMoments(v.medium.phase, 2)[1];
    constexpr int kHalf = kAlong / 2;
    parallelFor(std::size_t(kHalf) * kHalf, [&](std::size_t row) {
        for (int x = 0; x < kHalf; ++x) {
            const Int3 first = 2 * Int3(x, int(row % kHalf), int(row / kHalf));
            std::array<std::size_t, 8> cells;
            for (int i = 0; i < 8; ++i) cells[std::size_t(i)] = finest.indexOf(first + Int3(i & 1, i >> 1 & 1, i >> 2));
            if (std::ranges::all_of(cells, [&](std::size_t cell) { return black(scattering[cell]); })) continue;
            const Vec3 ws = wsLower + finest.edge * Vec3(first + 1);
            FromAllSides light = lights.fromAllSides(ws, v.lights, finest.edge);
            if (!scattersFully(v)) light.mean += scene.ambient;
            for (const CellLight& part : again) {
                Real rgb[3] = {};
                if (part.ofVolume[volume] && (part.again || part.output == Output{Layer::ambient}))
                    part.ofVolume[volume]->sample(ws, rgb);
                light.mean += Rgb(rgb[0], rgb[1], rgb[2]);
            }
            for (const std::size_t cell : cells)
                for (int c = 0; c < 3; ++c) {
                    finest.cells[cell].source[std::size_t(c)] += float(scattering[cell][c] * light.mean[c]);
                    if (finest.flows.empty()) continue;
                    const Vec3 flow = scattering[cell][c] * light.flow[std::size_t(c)];
                    addPart(finest.flows[cell][std::size_t(c)],
                            {float(flow.x), float(flow.y), float(flow.z), float(cosine * glm::length(flow))}, 1);
                }
        }
    });
}

VolumeShine::VolumeShine(const ViewScene& scene, const TransportPlan& plan, const Checkpoint& checkpoint)
    : m_scene(scene), m_wsBounds(wsBounds(scene)) {
    const double edge = largest(m_wsBounds.size()) / (kAlong - 2);
    m_radius = 0.5 * std::sqrt(3.0) * kAlong * edge;
    Level& finest = m_levels.emplace_back(Level{kAlong, edge, {}, {}});
    finest.resize(std::ranges::any_of(scene.volumes,
                                      [](const ViewVolume& v) { return scatters(v) && !v.medium.phase.isotropic(); }));
    const Making making{scene, finest, m_wsBounds.center() - 0.5 * kAlong * edge};
    const ViewScene few = withFewSubLights(scene, kSubLights);
    const MarchedLight lights(few);
    const ViewScene apart = withScatteredApart(scene);
    Solved solved;
    std::vector<CellLight> again;
    if (plan.any()) again = scatteredMoments(apart, plan, false, Simd(scene.dials.simd), checkpoint, solved).first;
    for (std::size_t v = 0; v < scene.volumes.size(); ++v) {
        checkpoint();
        making.addExtinction(scene.volumes[v]);
        making.addEmission(scene.volumes[v]);
        if (scatters(scene.volumes[v])) making.addScattered(v, lights, again);
    }
    while (m_levels.back().along > 1) {
        const Level& fine = m_levels.back();
        Level next{fine.along / 2, 2 * fine.edge, {}, {}};
        next.resize(!fine.flows.empty());
        for (int z = 0; z < fine.along; ++z)
            for (int y = 0; y < fine.along; ++y)
                for (int x = 0; x < fine.along; ++x) {
                    const std::size_t from = fine.indexOf({x, y, z}), to = next.indexOf({x / 2, y / 2, z / 2});
                    addPart(next.cells[to].extinction, fine.cells[from].extinction, 0.125F);
                    addPart(next.cells[to].source, fine.cells[from].source, 0.125F);
                    for (std::size_t c = 0; c < 3 && !fine.flows.empty(); ++c)
                        addPart(next.flows[to][c], fine.flows[from][c], 0.125F);
                }
        m_levels.push_back(std::move(next));
    }
}

void VolumeShine::Level::resize(bool withFlows) {
    const std::size_t count = std::size_t(along + 2) * std::size_t(along + 2) * std::size_t(along + 2);
    cells.resize(count);
    if (withFlows) flows.resize(count);
}

namespace {

// A place between eight cells, from the first of them on.
struct Between {
    int x, y, z;
    std::array<float, 8> weights;
};

// Returns false if `at`, in cells from the middle of a level, is beyond the border of its cells.
inline bool place(int along, const Vec3& at, Between& out) {
    const double half = 0.5 * along + 0.5;  // one more, so that truncation rounds down
    const double x = at.x + half, y = at.y + half, z = at.z + half, end = along + 1;
    if (!(x >= 0 && y >= 0 && z >= 0 && x < end && y < end && z < end)) return false;
    const int i = static_cast<int>(x), j = static_cast<int>(y), k = static_cast<int>(z);
    const auto u = static_cast<float>(x - i), v = static_cast<float>(y - j), w = static_cast<float>(z - k);
    const float a = (1 - v) * (1 - w), b = v * (1 - w), c = (1 - v) * w, d = v * w;
    out = {i - 1, j - 1, k - 1, {(1 - u) * a, u * a, (1 - u) * b, u * b, (1 - u) * c, u * c, (1 - u) * d, u * d}};
    return true;
}

}  // namespace

// What arrives at `ws` along a cone around `direction`, up to `most` world units away; `spread`:
// its width over its length. Samples lie between the cells that are about as wide.
template <bool withFlows>
Rgb VolumeShine::radiance(const Vec3& ws, const Vec3& direction, double spread, double most) const {
    constexpr double kStep = 0.75;  // of the width
    constexpr double kLeast = 1e-3;
    // The part of the cone in which samples may meet the volumes.
    const double margin = std::max(m_levels[0].edge, spread * (glm::distance(ws, m_wsBounds.center()) + m_radius));
    double begin = 0, end = most;
    for (int axis = 0; axis < 3; ++axis) {
        const double low = m_wsBounds.lower[axis] - margin - ws[axis],
                     high = m_wsBounds.upper[axis] + margin - ws[axis];
        const double a = low / direction[axis], b = high / direction[axis];  // infinite where it is parallel
        begin = std::max(begin, std::min(a, b));
        end = std::min(end, std::max(a, b));
    }
    const Vec3 toCenter = m_wsBounds.center() - ws;
    Rgb sum(0), clear(1);
    std::size_t l = 0;
    double edge = m_levels[0].edge;
    for (double t = begin, step = 0; t < end && largest(clear) > kLeast; t += step) {
        const double width = std::max(m_levels[0].edge, spread * t);
        for (; width > std::numbers::sqrt2 * edge && l + 1 < m_levels.size(); ++l) edge *= 2;
        step = std::min(kStep * width, end - t);
        const Level& level = m_levels[l];
        Between between;
        if (!place(level.along, ((t + 0.5 * step) * direction - toCenter) / edge, between)) continue;
        const std::size_t first = level.indexOf({between.x, between.y, between.z});
        const std::size_t row = std::size_t(level.along) + 2, slice = row * row;
        const std::size_t corners[] = {0, 1, row, row + 1, slice, slice + 1, slice + row, slice + row + 1};
        Cell met;
        Flow flow{};
        for (std::size_t i = 0; i < 8; ++i) {
            const Cell& cell = level.cells[first + corners[i]];
            addPart(met.extinction, cell.extinction, between.weights[i]);
            addPart(met.source, cell.source, between.weights[i]);
            for (std::size_t c = 0; withFlows && c < 3; ++c)
                addPart(flow[c], level.flows[first + corners[i]][c], between.weights[i]);
        }
        for (int i = 0; i < 3; ++i) {
            const auto c = std::size_t(i);
            double source = met.source[c];
            if (withFlows) source += besideEven(flow[c], direction);
            const double sent = std::max(source, 0.0) * step;
            const double tau = double(met.extinction[c]) * step;
            if (tau < 1e-6) {
                sum[i] += clear[i] * sent;
                continue;
            }
            const double left = std::exp(-tau);
            sum[i] += clear[i] * sent * (1 - left) / tau;
            clear[i] *= left;
        }
    }
    return sum;
}

Rgb VolumeShine::irradiance(const Vec3& ws, const Vec3& normal, const Cap& cap) const {
    constexpr double kOverlap = 1.0;  // width of a cone's samples, in distances of the cones' axes
    const double off = offSurface(ws), far = 2 * (glm::distance(ws, m_wsBounds.center()) + m_radius);
    const double own = cap.solidAngle / kCones, spread = kOverlap * std::sqrt(own);
    const Mat3 frame = frameAround(cap.axis);
    const bool solid = solidsBlock(m_scene), flows = !m_levels[0].flows.empty();
    Rgb sum(0);
    for (int i = 0; i < kCones; ++i) {
        const double z = 1 - (i + 0.5) * own / (2 * std::numbers::pi), across = std::sqrt(1 - z * z);
        const double angle = 2 * std::numbers::pi * i / std::numbers::phi;
        const Vec3 direction = frame * Vec3(across * std::cos(angle), across * std::sin(angle), z);
        const double cosine = glm::dot(direction, normal);
        if (cosine <= 0) continue;
        const double most = solid ? m_scene.solids->firstHit(SolidRole::shadow, ws, direction, off, far) : far;
        sum += cosine *
               (flows ? radiance<true>(ws, direction, spread, most) : radiance<false>(ws, direction, spread, most));
    }
    return own * sum;
}

// Within the sphere around the volumes by cones over the hemisphere, outside by cones over what the
// sphere covers of all directions, and at its border by both, because they do not agree exactly.
Rgb VolumeShine::irradiance(const Vec3& ws, const Vec3& normal) const {
    constexpr double kPi = std::numbers::pi, kBorder = 0.25;  // radii
    const double away = glm::distance(ws, m_wsBounds.center()) / m_radius;
    const Cap hemisphere{normal, 2 * kPi};
    if (away <= 1) return irradiance(ws, normal, hemisphere);
    const Cap sphere{(m_wsBounds.center() - ws) / (away * m_radius), 2 * kPi * (1 - std::sqrt(1 - 1 / (away * away)))};
    const Rgb outside = irradiance(ws, normal, sphere);
    const double part = (away - 1) / kBorder;
    return part >= 1 ? outside : glm::mix(irradiance(ws, normal, hemisphere), outside, part);
}

}  // namespace scrim
