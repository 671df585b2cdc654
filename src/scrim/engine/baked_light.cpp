// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/baked_light.h>

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/engine/light/light_sweep.h>
#include <scrim/engine/light/volume_shine.h>
#include <scrim/engine/plan/light_groups.h>
#include <scrim/engine/plan/make_plan.h>
#include <scrim/engine/plan/transport_plan.h>
#include <scrim/engine/shade/shade_tile.h>
#include <scrim/engine/splat/extinction_sum.h>
#include <scrim/engine/splat/plane_stack.h>
#include <scrim/engine/solve/scattered_light.h>
#include <scrim/scene/field_rays.h>
#include <scrim/volume/block_index.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <tuple>
#include <utility>

#include <fmt/format.h>
#include <glm/geometric.hpp>

namespace scrim {
namespace {

constexpr std::size_t kBlockFloats = std::size_t{3} * kBlockVoxels;

Int3 voxelOf(const Int3& origin, int offset) {
    return origin + Int3(offset / (kBlockEdge * kBlockEdge), offset / kBlockEdge % kBlockEdge, offset % kBlockEdge);
}

void report(const ProgressSink& progress, double done) {
    if (progress && !progress(done)) throw Error(ErrorKind::interrupted, "the bake was interrupted");
}

BakedVolume emptyBake(const SparseField& field) {
    // Each of 6 KB a light, so that no machine has memory for more.
    constexpr double kMostBlocks = double(std::size_t{1} << 27);
    if (const double blocks = dividedBlocks(field); blocks > kMostBlocks)
        throw Error(ErrorKind::memory,
                    fmt::format("grid '{}' has {:.3g} voxels, with those in constant regions; at most {:.3g} can be "
                                "baked",
                                field.name, kBlockVoxels * blocks, kBlockVoxels * kMostBlocks));
    BakedVolume out;
    for (std::size_t b = 0; b < field.blockCount(); ++b) {
        std::bitset<kBlockVoxels> active;
        for (int i = 0; i < kBlockVoxels; ++i) active[std::size_t(i)] = field.block(b)[i] > 0;
        if (active.none()) continue;
        out.blockOrigins.push_back(field.blockOrigins[b]);
        out.active.push_back(active);
    }
    for (const ConstantTile& tile : field.tiles)
        for (int n = tile.edge / kBlockEdge, i = 0; i < n * n * n; ++i) {
            out.blockOrigins.push_back(tile.origin + kBlockEdge * Int3(i / (n * n), i / n % n, i % n));
            out.active.push_back(std::bitset<kBlockVoxels>().set());
        }
    return out;
}

// The scene as seen by an eye that looks at all of its volumes along the main light. Nothing is culled, and every light
// lights every volume. Only the extinction of volumes matters, not their look.
ViewScene bakingScene(const ViewScene& given) {
    ViewScene scene = given;
    scene.layers.clear();
    scene.deep.reset();
    scene.shutter.reset();
    scene.moments = nullptr;
    scene.ambient = Rgb(0);
    for (ViewVolume& volume : scene.volumes) {
        volume.lights.clear();
        volume.scatter.clear();
        volume.emission.clear();
        volume.medium.albedo = Rgb(1);
        volume.medium.scattering = Scattering::single;  // what is scattered before is added afterwards
    }
    for (Light& light : scene.lights) light.shadow = ShadowMethod::buffers;
    scene.dials.splat = SplatMode::shared;
    scene.dials.sheets = SheetAxis::halfWay;
    scene.dials.shadowPlane = ShadowPlane::light;
    scene.dials.shade = ShadeMode::pixel;  // one look-up between buffer and voxel, as for pixels
    scene.dials.antialias = 1;
    scene.dials.crossFade = 0;
    scene.camera = cameraAlongLight(scene);
    scene.region = scene.picture = {0, 0, scene.camera.resolution.x, scene.camera.resolution.y};
    return scene;
}

// The path of light to a voxel: along the ray through the middle plane of the voxel's sheet, where
// buffers are looked up.
struct Crossing {
    double u, v;    // where the ray crosses that plane
    double inside;  // sheets along N from the point where light enters the sheet to the voxel
    double factor;  // irradiance at the voxel relative to that on the plane; 0: no light
};

Crossing crossingOf(const SheetLight& light, const Sheets& sheets, int sheet, const Vec3& ts) {
    const double toTexels = sheets.thickness / sheets.texel;
    if (const DistantOnSheet* sun = light.distant()) {
        const double back = (sheet + 0.5 - ts.z) * toTexels;
        return {ts.x + sun->slopeA * back, ts.y + sun->slopeB * back, ts.z - sheet, 1};
    }
    const NearOnSheet& lamp = *light.near();
    // A sheet that contains the light is lit from the light on, and its intensity accounts for that part only.
    const double away = lamp.distanceW / sheets.thickness, part = std::min(2 * away, 1.0);
    const double source = part < 1 ? sheet + 1 - part : sheet + 0.5 - away;
    constexpr double kLeast = 1e-3;  // of a sheet, for rays that lie within it
    const double from = ts.z - source;
    if (from <= 0) return {ts.x, ts.y, 0, 0};
    const double scale = away / std::max(from, kLeast);
    Crossing out{lamp.texelU + (ts.x - lamp.texelU) * scale, lamp.texelV + (ts.y - lamp.texelV) * scale,
                 std::min(from, ts.z - sheet), 1 / part};
    if (!lamp.decay) return out;
    const double a = (ts.x - lamp.texelU) * sheets.texel, b = (ts.y - lamp.texelV) * sheets.texel;
    const double c = from * sheets.thickness, own = a * a + b * b + c * c;
    out.factor *= std::max(own * scale * scale, double(lamp.radius2)) / std::max(own, double(lamp.radius2));
    return out;
}

// Up to 256 voxels of a sheet with one light's data.
struct VoxelTile {
    int count = 0;
    const std::size_t* at = nullptr;  // block * 512 + offset of each voxel
    const Vec3* ts = nullptr;
    SampleTile samples{};
    alignas(64) Real factor[kTileSize];
    alignas(64) Real path[kTileSize];   // world length of the light's path through the sheet
    alignas(64) Real clear[kTileSize];  // fraction of light that passes the solids
    alignas(64) Real tau[ExtinctionChannels::kMost * kTileSize]{};
};

void meet(const SheetLight& light, const Sheets& sheets, int sheet, VoxelTile& tile) {
    for (int k = 0; k < kTileSize; ++k) {
        const Crossing at = crossingOf(light, sheets, sheet, tile.ts[std::min(k, tile.count - 1)]);
        tile.samples.u[k] = static_cast<Real>(at.u);
        tile.samples.v[k] = static_cast<Real>(at.v);
        tile.factor[k] = static_cast<Real>(at.factor);
        const Vec2 slope = light.slopesAt(at.u, at.v, sheets.texel);
        tile.path[k] =
            static_cast<Real>(at.inside * sheets.thickness * std::sqrt(1 + slope.x * slope.x + slope.y * slope.y));
        tile.clear[k] = 1;
    }
}

class Baking {
  public:
    // `scene` is the scene for baking, whose plan is `plan`.
    Baking(const ViewScene& given, const ViewScene& scene, const Plan& plan, std::vector<BakedVolume>& out)
        : m_given(given), m_scene(scene), m_plan(plan), m_out(out) {}

    void sweep(const GroupPlan& group, const ProgressSink& progress);

  private:
    struct Batch {
        const GroupPlan& group;
        const ExtinctionSum& extinction;
        const LightSweep& lights;
        int first, count;
    };
    void bakeBlocks(const Batch& batch, std::size_t volume, std::size_t from, std::size_t to);
    void addLight(const Batch& batch, int p, std::size_t index, std::size_t volume, VoxelTile& tile);
    void shade(const SheetLight& light, const Sheets& sheets, const Octaves& octaves, const VoxelTile& tile,
               std::vector<float>& sum) const;

    const ViewScene& m_given;
    const ViewScene& m_scene;
    const Plan& m_plan;
    std::vector<BakedVolume>& m_out;
};

// Voxels are shaded as samples of a medium without absorption whose scattering makes radiance equal
// to the arriving light. Therefore light, slide, cone and shadow are the same as in pictures.
void Baking::shade(const SheetLight& light, const Sheets& sheets, const Octaves& octaves, const VoxelTile& tile,
                   std::vector<float>& sum) const {
    // So thin that light does not change along a sample.
    const auto thin = static_cast<Real>(1e-6 * sheets.thickness);
    alignas(64) Real scatter[kTileSize], nothing[kTileSize] = {};
    std::fill_n(scatter, kTileSize, static_cast<Real>(4 * std::numbers::pi) / thin);
    const SheetMedium medium{{scatter, scatter, scatter}, {1, 1, 1}, {}, octaves, nullptr};
    ShadeInput input{};
    input.samples = &tile.samples;
    input.texel = static_cast<Real>(sheets.texel);
    input.thickness = thin;
    input.sameSide = true;
    input.coloured = m_plan.extinction.coloured;
    input.channels = m_plan.extinction.count();
    for (int r = 0; r < input.channels; ++r) {
        input.extinction[r] = nothing;
        for (int c = 0; c < 3; ++c) input.tints[r][c] = static_cast<Real>(m_plan.extinction.tints[std::size_t(r)][c]);
    }
    input.media = {&medium, 1};
    input.lights = {&light, 1};
    input.tauIn = tile.tau;
    input.unblocked = tile.clear;
    input.layout.coloured = input.coloured;
    input.outputs = nothing;  // there are no outputs beside the beauty
    input.simd = m_plan.simd;
    const int floats = input.layout.floats();
    alignas(64) std::array<Real, std::size_t{8} * kTileSize> shaded;
    shadeTile(input, shaded.data());
    for (int k = 0; k < tile.count; ++k) {
        float* own = sum.data() + tile.at[k] / kBlockVoxels * kBlockFloats + tile.at[k] % kBlockVoxels;
        for (int c = 0; c < 3; ++c) own[c * kBlockVoxels] += tile.factor[k] * shaded[std::size_t(floats * k + c)];
    }
}

void Baking::addLight(const Batch& batch, int p, std::size_t index, std::size_t volume, VoxelTile& tile) {
    const Sheets& sheets = batch.group.sheets;
    const LightSweep::OnSheet& on = batch.lights.onSheet(p);
    SheetLight light = on.lights[index];
    light.output = 0;
    const auto owner = std::size_t(m_plan.subLights.ownerOf(light.index));
    const int channels = m_plan.extinction.count();
    BakedVolume& out = m_out[volume];
    if (out.lights[owner].empty()) return;
    meet(light, sheets, on.sheet, tile);
    for (const int c : light.channels) {
        Real* tau = tile.tau + c * kTileSize;
        const Shadow* shadow = on.shadows[index * std::size_t(channels) + std::size_t(c)];
        shadow->lookUpPoints(p, tile.samples.u, tile.samples.v, kTileSize, tau);
        if (!light.withinSheet) continue;
        alignas(64) Real sigma[kTileSize];
        const PlaneStack& planes = batch.extinction.total(c);
        samplePoints(planes.view(p, m_plan.simd), tile.samples.u, tile.samples.v, false, kTileSize, sigma);
        for (int k = 0; k < kTileSize; ++k) tau[k] += sigma[k] * tile.path[k];
    }
    if (!on.solids.empty() && on.solids[index])
        on.solids[index]->multiply(on.sheet, tile.samples.u, tile.samples.v, tile.clear);
    shade(light, sheets, {}, tile, out.lights[owner]);
    if (!out.scattered.empty()) shade(light, sheets, m_given.volumes[volume].medium.octaves, tile, out.scattered);
}

// Bakes all voxels of the blocks [from, to) that lie in the batch.
void Baking::bakeBlocks(const Batch& batch, std::size_t volume, std::size_t from, std::size_t to) {
    const BakedVolume& out = m_out[volume];
    const Mat4 tsFromIs = batch.group.sheets.tsFrom(m_scene.volumes[volume].wsFromIs);
    // The extent of a block along N from its first voxel.
    double low = 0, high = 0;
    for (int axis = 0; axis < 3; ++axis) {
        const double step = (kBlockEdge - 1) * tsFromIs[axis].z;
        (step < 0 ? low : high) += step;
    }
    std::vector<std::vector<std::pair<std::size_t, Vec3>>> bySheet(std::size_t(batch.count));
    for (std::size_t b = from; b < to; ++b) {
        const double corner = transformPoint(tsFromIs, Vec3(out.blockOrigins[b])).z;
        if (corner + high < batch.first || corner + low >= batch.first + batch.count) continue;
        for (int i = 0; i < kBlockVoxels; ++i) {
            if (!out.active[b][std::size_t(i)]) continue;
            const Vec3 ts = transformPoint(tsFromIs, Vec3(voxelOf(out.blockOrigins[b], i)));
            const int p = static_cast<int>(std::floor(ts.z)) - batch.first;
            if (p >= 0 && p < batch.count) bySheet[std::size_t(p)].emplace_back(b * kBlockVoxels + std::size_t(i), ts);
        }
    }
    VoxelTile tile;
    std::size_t at[kTileSize];
    Vec3 ts[kTileSize];
    tile.at = at;
    tile.ts = ts;
    for (int p = 0; p < batch.count; ++p) {
        const auto& voxels = bySheet[std::size_t(p)];
        for (std::size_t first = 0; first < voxels.size(); first += kTileSize) {
            tile.count = static_cast<int>(std::min<std::size_t>(kTileSize, voxels.size() - first));
            for (int k = 0; k < tile.count; ++k) std::tie(at[k], ts[k]) = voxels[first + std::size_t(k)];
            for (std::size_t i = 0; i < batch.lights.onSheet(p).lights.size(); ++i) addLight(batch, p, i, volume, tile);
        }
    }
}

void Baking::sweep(const GroupPlan& group, const ProgressSink& progress) {
    constexpr std::size_t kBlocks = 8;  // per task; neighbouring blocks share their sheets
    ExtinctionSum extinction(m_scene, m_plan, group.sheets, group.lattice, group.batchSheets,
                             ExtinctionSum::For::light);
    LightSweep lights(m_scene, m_plan, group);
    std::vector<std::array<std::size_t, 3>> tasks;  // volume, and from which block to which
    for (std::size_t v = 0; v < m_out.size(); ++v)
        for (std::size_t b = 0; b < m_out[v].blockOrigins.size(); b += kBlocks)
            tasks.push_back({v, b, std::min(b + kBlocks, m_out[v].blockOrigins.size())});
    for (int first = group.needed.first; first < group.needed.last; first += group.batchSheets) {
        const int count = std::min(group.batchSheets, group.needed.last - first);
        extinction.splat(first, count, &group.needed);
        lights.attenuate(first, count, extinction);
        const Batch batch{group, extinction, lights, first, count};
        parallelFor(tasks.size(), [&](std::size_t i) { bakeBlocks(batch, tasks[i][0], tasks[i][1], tasks[i][2]); });
        report(progress, double(first + count - group.needed.first) / (group.needed.last - group.needed.first));
    }
}

// Adds light that has scattered before to `out`: its mean radiance to what volumes that scatter
// more than once scatter, as irradiance from all sides.
void addScattered(const ViewScene& given, bool indirect, const ProgressSink& progress, std::vector<BakedVolume>& out) {
    const ViewScene scene = withScatteredApart(given);
    const TransportPlan plan = planTransport(scene, indirect);
    if (!plan.any()) return;
    Solved solved;
    const auto stop = [&] { report(progress, 1); };
    const auto [means, flux] = scatteredMoments(scene, plan, indirect, Simd(), stop, solved);
    for (std::size_t v = 0; v < out.size(); ++v) {
        const ViewVolume& volume = scene.volumes[v];
        if (!scattersFully(volume)) continue;
        BakedVolume& baked = out[v];
        baked.iterationError = solved.converged ? 0 : solved.error;
        parallelFor(baked.blockOrigins.size(), [&](std::size_t b) {
            for (int i = 0; i < kBlockVoxels; ++i) {
                if (!baked.active[b][std::size_t(i)]) continue;
                const Vec3 ws = transformPoint(volume.wsFromIs, Vec3(voxelOf(baked.blockOrigins[b], i)));
                const std::size_t at = b * kBlockFloats + std::size_t(i);
                Real rgb[3];
                for (const CellLight& light : means) {
                    // Lights have brought what has not scattered before. Ambient light has not.
                    const bool scatters = light.again || light.output == Output{Layer::ambient};
                    light.ofVolume[v]->sample(ws, rgb);
                    for (std::size_t c = 0; c < 3; ++c) {
                        if (light.again && indirect) baked.indirect[at + c * kBlockVoxels] += rgb[c];
                        if (scatters && !baked.scattered.empty())
                            baked.scattered[at + c * kBlockVoxels] += static_cast<Real>(4 * std::numbers::pi) * rgb[c];
                    }
                }
                for (std::size_t axis = 0; indirect && axis < 3; ++axis) {
                    flux[axis]->sample(ws, rgb);
                    for (std::size_t c = 0; c < 3; ++c) baked.flux[c][at + axis * kBlockVoxels] = rgb[c];
                }
            }
        });
    }
}

// Turns arriving light into scattered radiance with the field's voxels and the albedo's.
void scatter(const ViewScene& scene, const ViewVolume& volume, BakedVolume& out) {
    if (out.scattered.empty()) return;
    const Medium& medium = volume.medium;
    const Rgb ambient = scattersFully(volume) ? Rgb(0) : scene.ambient;  // addScattered has brought it
    std::vector<FieldRays> fields;                                       // of one lattice
    const bool grid = !volume.scatter.empty();
    for (std::size_t c = 0; c < (grid ? 3 : 1); ++c)
        fields.emplace_back(grid ? *volume.scatter[c].field : *volume.field);
    parallelFor(out.blockOrigins.size(), [&](std::size_t b) {
        for (int i = 0; i < kBlockVoxels; ++i) {
            if (!out.active[b][std::size_t(i)]) continue;
            const Vec3 ws = transformPoint(volume.field->wsFromIs, Vec3(voxelOf(out.blockOrigins[b], i)));
            float* own = out.scattered.data() + b * kBlockFloats + i;
            for (int c = 0; c < 3; ++c) {
                const std::size_t f = grid ? std::size_t(c) : 0;
                const double value = fields[f].value(ws) * (grid ? 1 : medium.albedo[c]);
                const double arrives = own[c * kBlockVoxels] / (4 * std::numbers::pi) + ambient[c];
                own[c * kBlockVoxels] =
                    static_cast<float>(medium.densityScale * medium.extinctionTint[c] * value * arrives);
            }
        }
    });
}

// Throws if the values would exceed the scene's memory limit. Returns the rest of the limit.
std::size_t limitBeside(const ViewScene& scene, const std::vector<bool>& wanted, bool scattered, bool indirect) {
    if (scene.memoryLimit == 0) return 0;
    double bytes = 0;
    for (const ViewVolume& volume : scene.volumes) {
        std::size_t grids = (scattered && !volume.classified ? 1 : 0) + (indirect && scattersFully(volume) ? 4 : 0);
        for (std::size_t l = 0; l < scene.lights.size(); ++l) grids += wanted[l] && litBy(volume.lights, l) ? 1 : 0;
        bytes += dividedBlocks(*volume.field) * double(grids * kBlockFloats * sizeof(float));
    }
    if (bytes >= double(scene.memoryLimit))
        throw Error(ErrorKind::memory,
                    fmt::format("the baked grids take {}, more than the {} that the memory limit leaves",
                                bytesText(static_cast<std::size_t>(bytes)), bytesText(scene.memoryLimit)));
    return scene.memoryLimit - static_cast<std::size_t>(bytes);
}

}  // namespace

std::vector<BakedVolume> bakeLight(const ViewScene& given, const std::vector<bool>& wanted, bool scattered,
                                   bool indirect, int threads, const ProgressSink& progress) {
    ViewScene baking = bakingScene(given);
    baking.memoryLimit = limitBeside(given, wanted, scattered, indirect);
    std::vector<BakedVolume> out;
    for (const ViewVolume& volume : given.volumes) {
        BakedVolume& baked = out.emplace_back(emptyBake(*volume.field));
        const std::size_t floats = baked.blockOrigins.size() * kBlockFloats;
        for (std::size_t l = 0; l < given.lights.size(); ++l)
            baked.lights.emplace_back(wanted[l] && litBy(volume.lights, l) ? floats : 0);
        if (scattered && !volume.classified) baked.scattered.resize(floats);
        if (!indirect || !scattersFully(volume)) continue;
        baked.indirect.resize(floats);
        for (auto& flux : baked.flux) flux.resize(floats);
    }
    const Plan plan = makePlan(baking, threads, partOf(progress, 0, 0), true);
    Baking bake(given, baking, plan, out);
    for (std::size_t g = 0; g < plan.groups.size(); ++g)
        bake.sweep(plan.groups[g], partOf(progress, double(g) / double(plan.groups.size()),
                                          double(g + 1) / double(plan.groups.size())));
    if (scattered || indirect) addScattered(given, indirect, progress, out);
    for (std::size_t v = 0; v < out.size(); ++v) scatter(given, given.volumes[v], out[v]);
    return out;
}

}  // namespace scrim
