// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/density_detail.h>

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/scene/noise_blocks.h>
#include <scrim/scene/ramp.h>
#include <scrim/shot/values_at.h>
#include <scrim/shot/ways_out.h>
#include <scrim/volume/coarser.h>
#include <scrim/volume/field_builder.h>
#include <scrim/volume/field_sampler.h>
#include <scrim/volume/grid_edit.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>
#include <memory>

#include <fmt/format.h>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

/// Rays gather changes of density until light is lost, over 1 / d voxels of an optical depth d each, and at most over
/// kMostWay. Changes of neighbours are as often above 0 as below, so they add up to the change of a voxel times the
/// square root of that number. Voxels are divided where the sum may be more than kShown of all light. What is deep in
/// the density has less part in that light.
constexpr double kShown = 6e-3, kMostWay = 100;

/// Beside blocks in which changes show, those that are this part as large are divided, too: there
/// is less in blocks that a silhouette only touches.
constexpr double kBeside = 0.1;

/// If more of the blocks than this are to be divided, all are.
constexpr double kMostDivided = 0.5;

/// Deeper than this nothing shows, whatever changes: exp(-7) is 0.0009.
constexpr double kDark = 7;

/// Most blocks of smaller voxels; values and place of one take 2 KB.
constexpr std::size_t kMostBlocks = std::size_t{1} << 22;

using Values = std::array<float, kBlockVoxels>;

Int3 voxelOf(int i) {
    return {i / (kBlockEdge * kBlockEdge), i / kBlockEdge % kBlockEdge, i % kBlockEdge};
}

[[noreturn]] void tooMany(const SparseField& field, int times) {
    throw Error(ErrorKind::memory,
                fmt::format("grid '{}': detail = {} needs more than {} million voxels; expected a smaller number",
                            field.name, times, kMostBlocks * kBlockVoxels / 1000000));
}

/// A field without voxels whose lattice is that of `field` with voxels divided by `times`. Voxel 0 stays where it is.
SparseField latticeOf(const SparseField& field, int times) {
    SparseField out;
    out.name = field.name;
    out.wsFromIs = field.wsFromIs;
    for (int axis = 0; axis < 3; ++axis) out.wsFromIs[axis] /= double(times);
    return out;
}

/// A field between its voxels, at the voxels of finer blocks.
class Between {
  public:
    Between(const SparseField& field, int times)
        : m_index(field), m_times(times), m_shift(std::countr_zero(unsigned(times))) {}
    /// Interpolates linearly. Returns false where all values are 0.
    bool fill(const Int3& origin, float* values) const {
        const int size = kBlockEdge / m_times + 1;  // voxels along an edge of the block, with the next one
        std::array<float, kMost * kMost * kMost> voxels;
        std::array<float, kMost * kMost * kBlockEdge> rows;
        std::array<float, kMost * kBlockEdge * kBlockEdge> layers;
        bool any = false;
        for (int i = 0; i < size * size * size; ++i) {
            const Int3 at = (origin >> m_shift) + Int3(i / (size * size), i / size % size, i % size);
            voxels[std::size_t(i)] = static_cast<float>(m_index.voxel(at));
            any = any || voxels[std::size_t(i)] > 0;
        }
        if (!any) return false;
        expand(voxels.data(), size * size, size, 1, rows.data());
        expand(rows.data(), size, size, kBlockEdge, layers.data());
        expand(layers.data(), 1, size, kBlockEdge * kBlockEdge, values);
        return true;
    }

  private:
    static constexpr int kMost = kBlockEdge / 2 + 1;
    /// Interpolates between `size` runs of `run` values, `count` times: 8 runs become of each.
    void expand(const float* from, int count, int size, int run, float* to) const {
        for (int c = 0; c < count; ++c)
            for (int i = 0; i < kBlockEdge; ++i) {
                const float* const first = from + (c * size + (i >> m_shift)) * run;
                const float part = static_cast<float>(i & (m_times - 1)) / static_cast<float>(m_times);
                for (int k = 0; k < run; ++k) *to++ = first[k] + part * (first[k + run] - first[k]);
            }
    }

    BlockIndex m_index;
    int m_times, m_shift;
};

/// The density after all of its shading, at the voxels of finer blocks.
class Shaded {
  public:
    explicit Shaded(const DetailSource& source)
        : m_source(source), m_lattice(latticeOf(*source.grid, source.times)), m_grid(*source.grid, source.times) {
        const auto placeOf = [&](const Noise& noise) {
            return noise.inWorld ? source.wsFromAsset * m_lattice.wsFromIs : m_lattice.wsFromIs;
        };
        if (source.shading.mask) m_mask.emplace(m_lattice, *source.mask);
        if (source.shading.noise) m_noise.emplace(*source.shading.noise, placeOf(*source.shading.noise));
        if (!source.displacement) return;
        m_moved.emplace(*source.grid);
        const Mat4 place = placeOf(*source.displacement);
        m_isFromPlace = glm::inverse(Mat3(place)) * source.displacement->amount / double(source.times);
        for (std::uint32_t c = 0; c < 3; ++c) m_ways.emplace_back(*source.displacement, place, c);
    }
    const SparseField& lattice() const { return m_lattice; }
    /// Returns false where all values are 0.
    bool fill(const Int3& origin, float* values) const {
        if (!(m_moved ? fillMoved(origin, values) : m_grid.fill(origin, values))) return false;
        if (m_source.shading.any()) shade(origin, values);
        if (!m_source.ramp.empty())
            for (int i = 0; i < kBlockVoxels; ++i)
                if (values[i] > 0) values[i] = static_cast<float>(ramped(m_source.ramp, double(values[i])));
        return std::any_of(values, values + kBlockVoxels, [](float v) { return v > 0; });
    }

  private:
    bool fillMoved(const Int3& origin, float* values) const {
        std::array<Values, 3> way;
        for (std::size_t c = 0; c < 3; ++c) m_ways[c].fill(origin, way[c].data());
        bool any = false;
        for (int i = 0; i < kBlockVoxels; ++i) {
            const auto n = std::size_t(i);
            const Vec3 at = Vec3(origin + voxelOf(i)) / double(m_source.times);
            values[i] = static_cast<float>(m_moved->value(at - m_isFromPlace * Vec3(way[0][n], way[1][n], way[2][n])));
            any = any || values[i] > 0;
        }
        return any;
    }
    void shade(const Int3& origin, float* values) const {
        Values pattern{};
        if (m_noise) m_noise->fill(origin, pattern.data());
        for (int i = 0; i < kBlockVoxels; ++i)
            if (values[i] > 0)
                values[i] = static_cast<float>(m_source.shading.at(
                    double(values[i]), m_mask ? m_mask->at(origin + voxelOf(i)) : 0, double(pattern[std::size_t(i)])));
    }

    const DetailSource& m_source;
    SparseField m_lattice;
    Between m_grid;
    std::optional<ValuesAt> m_mask;
    std::optional<NoiseBlocks> m_noise;
    std::optional<FieldSampler> m_moved;
    std::vector<NoiseBlocks> m_ways;
    Mat3 m_isFromPlace{0};  // times the displacement's amount, to voxels of the grid
};

/// The finer blocks in which the field has values between its voxels; with `all` inside of its
/// tiles, too, which are constant. Sorted.
std::vector<Int3> blocksOf(const SparseField& field, int times, bool all) {
    std::vector<Int3> found;
    const auto unite = [&] {
        std::sort(found.begin(), found.end(), originLess);
        found.erase(std::unique(found.begin(), found.end()), found.end());
        // Most of them turn out not to show anything; those that do are counted later.
        if (found.size() > 16 * kMostBlocks) tooMany(field, times);
    };
    std::size_t limit = 4 * kMostBlocks;
    const auto add = [&](const Int3& origin) {
        const Int3 first = (times * (origin - 1)) >> 3, last = (times * (origin + kBlockEdge) - 1) >> 3;
        for (int x = first.x; x <= last.x; ++x)
            for (int y = first.y; y <= last.y; ++y)
                for (int z = first.z; z <= last.z; ++z) found.emplace_back(Int3(x, y, z) * kBlockEdge);
        if (found.size() < limit) return;
        unite();
        limit = 2 * found.size() + kMostBlocks;
    };
    for (const Int3& origin : field.blockOrigins) add(origin);
    for (const ConstantTile& tile : field.tiles) {
        const int last = tile.edge - kBlockEdge;
        for (int x = 0; x <= last; x += kBlockEdge)
            for (int y = 0; y <= last; y += kBlockEdge) {
                const bool inside = x > 0 && x < last && y > 0 && y < last && !all;
                for (int z = 0; z <= last; z += inside && z == 0 ? last : kBlockEdge) add(tile.origin + Int3(x, y, z));
            }
    }
    unite();
    return found;
}

bool holds(const std::vector<Int3>& sorted, const Int3& origin) {
    return std::binary_search(sorted.begin(), sorted.end(), origin, originLess);
}

/// Blocks of finer voxels, sorted.
struct FinerBlocks {
    std::vector<Int3> shown;                            ///< those in which shading between voxels shows
    std::vector<std::unique_ptr<const Values>> values;  ///< theirs; null: not kept
    std::vector<Int3> others;                           ///< all others that are not empty
};

/// By how many times more than what shows shading that is `fine` at smaller voxels differs from what is `between` the
/// larger ones. `depth`: of a density of 1 along a voxel; `way`: from outside.
double changeOf(const Values& fine, const Values& between, double depth, double way) {
    double squares = 0, sum = 0;
    for (std::size_t i = 0; i < fine.size(); ++i) {
        const double change = double(fine[i]) - double(between[i]);
        squares += change * change;
        sum += double(between[i]);
    }
    const double across = depth * sum / kBlockVoxels;  // of a voxel
    return std::exp(-way) * depth * std::sqrt(squares / kBlockVoxels) /
           (kShown * std::sqrt(std::max(across, 1 / kMostWay)));
}

/// Cubes of kCube voxels, which are divided or not as a whole, with the largest change in each.
class Cubes {
  public:
    explicit Cubes(int times) : m_shift(std::countr_zero(unsigned(kCube * times))) {}
    void add(const Int3& origin, double change) {
        double& most = m_most.try_emplace(cubeOf(origin), change).first->second;
        most = std::max(most, change);
    }
    /// Whether voxels of a block are divided, because changes show in its cube, or nearly so and show beside it.
    bool divided(const Int3& origin) const {
        const Int3 cube = cubeOf(origin);
        const double own = changeAt(cube);
        if (own > 1 || own <= kBeside) return own > 1;
        for (int i = 0; i < 27; ++i)
            if (changeAt(cube + Int3(i / 9, i / 3 % 3, i % 3) - 1) > 1) return true;
        return false;
    }

  private:
    static constexpr int kCube = 4;
    struct Less {
        bool operator()(const Int3& a, const Int3& b) const { return originLess(a, b); }
    };
    Int3 cubeOf(const Int3& origin) const { return origin >> m_shift; }
    double changeAt(const Int3& cube) const {
        const auto found = m_most.find(cube);
        return found == m_most.end() ? 0 : found->second;
    }

    int m_shift;
    std::map<Int3, double, Less> m_most;
};

/// Sorts the blocks `all` by whether shading between voxels shows.
FinerBlocks finerBlocks(const std::vector<Int3>& all, const DetailSource& source, const Shaded& shaded,
                        const Between& coarse, const WaysOut& ways) {
    std::vector<std::unique_ptr<const Values>> values(all.size());
    std::vector<double> changes(all.size(), -1);  // below 0: empty
    constexpr std::size_t kChunk = 16;
    parallelFor((all.size() + kChunk - 1) / kChunk, [&](std::size_t chunk) {
        Values fine, between;
        for (std::size_t b = chunk * kChunk; b < std::min(all.size(), (chunk + 1) * kChunk); ++b) {
            const double way = ways.to(all[b] / source.times, (all[b] + kBlockEdge) / source.times);
            const bool dark = way > kDark, any = coarse.fill(all[b], between.data());
            if (dark) changes[b] = 0;
            if (!any) between.fill(0);
            const bool anyFine = !dark && shaded.fill(all[b], fine.data());
            if (dark || (!any && !anyFine)) continue;
            if (!anyFine) fine.fill(0);
            changes[b] = changeOf(fine, between, double(source.longDepth), way);
            if (changes[b] > kBeside) values[b] = std::make_unique<const Values>(fine);
        }
    });
    Cubes cubes(source.times);
    for (std::size_t b = 0; b < all.size(); ++b)
        if (changes[b] >= 0) cubes.add(all[b], changes[b]);
    FinerBlocks out;
    for (std::size_t b = 0; b < all.size(); ++b) {
        if (changes[b] < 0) continue;
        const bool shown = cubes.divided(all[b]);
        (shown ? out.shown : out.others).push_back(all[b]);
        if (shown) out.values.push_back(std::move(values[b]));
    }
    return out;
}

/// Which voxels are divided: those whose tents reach into no block that has values but does not show anything.
class Divided {
  public:
    Divided(const SparseField& field, const FinerBlocks& blocks, int times)
        : m_index(field), m_blocks(blocks), m_times(times) {}
    /// Whether any of the voxels `lower` to `upper` may be.
    bool any(const Int3& lower, const Int3& upper) const {
        bool any = false;
        forBlocks(lower, upper, [&](const Int3& origin) { any = any || holds(m_blocks.shown, origin); });
        return any;
    }
    /// Sets the divided voxels of a block to 0.
    void takeFrom(const Int3& origin, float* values) const {
        std::vector<char> left;
        const Int3 first = firstOf(origin), size = lastOf(origin + (kBlockEdge - 1)) - first + 1;
        forBlocks(origin, origin + (kBlockEdge - 1), [&](const Int3& at) { left.push_back(isLeft(at) ? 1 : 0); });
        const auto leftAt = [&](const Int3& at) {
            const Int3 step = at / kBlockEdge - first;
            return left[(std::size_t(step.x) * std::size_t(size.y) + std::size_t(step.y)) * std::size_t(size.z) +
                        std::size_t(step.z)] != 0;
        };
        for (int i = 0; i < kBlockVoxels; ++i) {
            bool kept = false;
            const Int3 voxel = origin + voxelOf(i);
            forBlocks(voxel, voxel, [&](const Int3& at) { kept = kept || leftAt(at); });
            if (!kept) values[i] = 0;
        }
    }

  private:
    // The first and the last block that the tent of a voxel reaches into, divided by a block's edge.
    Int3 firstOf(const Int3& voxel) const { return (m_times * (voxel - 1) + 1) >> 3; }
    Int3 lastOf(const Int3& voxel) const { return (m_times * (voxel + 1) - 1) >> 3; }
    template <typename Visit>
    void forBlocks(const Int3& lower, const Int3& upper, const Visit& visit) const {
        const Int3 first = firstOf(lower), last = lastOf(upper);
        for (int x = first.x; x <= last.x; ++x)
            for (int y = first.y; y <= last.y; ++y)
                for (int z = first.z; z <= last.z; ++z) visit(Int3(x, y, z) * kBlockEdge);
    }
    // The inside of constant tiles is not in any list.
    bool isLeft(const Int3& origin) const {
        if (holds(m_blocks.shown, origin)) return false;
        return holds(m_blocks.others, origin) || m_index.at((origin / m_times) >> 3).tile != nullptr;
    }

    BlockIndex m_index;
    const FinerBlocks& m_blocks;
    int m_times;
};

/// The voxels of `field` that are not divided.
FieldPointer undivided(const SparseField& field, const Divided& divided) {
    std::vector<ConstantBlock> constant;
    std::vector<ConstantTile> whole, tiles = field.tiles;
    while (!tiles.empty()) {
        const ConstantTile tile = tiles.back();
        tiles.pop_back();
        if (!divided.any(tile.origin, tile.origin + (tile.edge - 1))) {
            whole.push_back(tile);
        } else if (tile.edge == kBlockEdge) {
            constant.push_back({tile.origin, tile.value});
        } else {
            for (int i = 0; i < 8; ++i)
                tiles.push_back(
                    {tile.origin + tile.edge / 2 * Int3(i >> 2, i >> 1 & 1, i & 1), tile.edge / 2, tile.value});
        }
    }
    return changedBlocks(field, constant, std::move(whole),
                         [&](const Int3& origin, float* values) { divided.takeFrom(origin, values); });
}

/// Says from where the inside of a volume is seen or lit.
void lookInside(const Scene& scene, const SceneVolume& volume, const Mat4& wsFromIs, DetailSource& out) {
    const Mat4 isFromWs = glm::inverse(wsFromIs);
    Bounds box = out.grid->isBounds();
    if (out.displacement) {  // the volume may reach farther than its voxels
        box.lower -= box.size();
        box.upper += box.size();
    }
    const auto include = [&](const Vec3& ws) {
        if (const Vec3 is = transformPoint(isFromWs, ws); box.contains(is)) out.inside.emplace_back(glm::floor(is));
    };
    // What lies before the camera's near plane is cut away, and lamps with a surface shine from all of it.
    const bool cut = !volume.clip.empty() || scene.camera.near > 0 || scene.camera.type != CameraType::perspective;
    out.hides = !cut && std::ranges::none_of(scene.lights, [](const Light& light) { return light.area() != nullptr; });
    include(scene.camera.wsPosition);
    for (const Light& light : scene.lights)
        if (!light.distant() && !light.dome()) include(light.wsPosition);
}

/// A field with these blocks on the lattice of `shaded`; `fill` writes the values of the block with a number.
template <typename Fill>
FieldPointer finerField(const Shaded& shaded, const std::vector<Int3>& blocks, const Fill& fill) {
    FieldPieces pieces;
    pieces.name = shaded.lattice().name;
    pieces.wsFromIs = shaded.lattice().wsFromIs;
    pieces.blockOrigins = blocks;
    pieces.fill = fill;
    return std::make_shared<SparseField>(buildField(std::move(pieces)));
}

}  // namespace

DetailedDensity detailedDensity(const DetailSource& source) {
    const FieldPointer whole = source.ramp.empty() ? source.shaded : withRamp(*source.shaded, source.ramp);
    const bool varies = source.shading.noise || source.shading.mask || source.displacement;
    const std::vector<Int3> all = blocksOf(*source.displaced, source.times, varies || source.whole);
    const Shaded shaded(source);
    const auto divideAll = [&]() -> DetailedDensity {
        if (all.size() > kMostBlocks) tooMany(*source.grid, source.times);
        return {std::make_shared<SparseField>(latticeOf(*source.grid, 1)),
                finerField(shaded, all, [&](std::size_t b, float* to) {
                    if (!shaded.fill(all[b], to)) std::fill_n(to, kBlockVoxels, 0.0f);
                })};
    };
    if (source.whole) return divideAll();
    const Between coarse(*whole, source.times);
    const WaysOut ways = source.hides ? WaysOut(*whole, double(source.shortDepth), source.inside) : WaysOut();
    const FinerBlocks blocks = finerBlocks(all, source, shaded, coarse, ways);
    // Sheets for two sizes of voxels take longer than more voxels of one size.
    if (double(blocks.shown.size()) > kMostDivided * double(all.size())) return divideAll();
    if (blocks.shown.size() > kMostBlocks) tooMany(*source.grid, source.times);
    const FieldPointer left = undivided(*whole, Divided(*whole, blocks, source.times));
    const Between kept(*left, source.times);
    // Divided voxels give way to finer ones by their part of what lies between voxels, so that the
    // sum is that of all voxels where shading changes nothing.
    const auto fill = [&](std::size_t b, float* to) {
        Values sum, rest;
        const Int3& origin = blocks.shown[b];
        const auto& known = blocks.values[b];
        if (known)
            std::copy_n(known->data(), kBlockVoxels, to);
        else if (!shaded.fill(origin, to))
            std::fill_n(to, kBlockVoxels, 0.0f);
        if (!coarse.fill(origin, sum.data()) || !kept.fill(origin, rest.data())) return;
        for (std::size_t i = 0; i < sum.size(); ++i)
            if (sum[i] > 0) to[i] *= std::max(0.0f, 1 - rest[i] / sum[i]);
    };
    return {left, finerField(shaded, blocks.shown, fill)};
}

int timesFor(const Noise& noise, double edge) {
    constexpr int kMost = 4;
    const double finest = 1 / (noise.frequency * std::pow(noise.lacunarity, noise.octaves - 1));
    int times = 1;
    while (times < kMost && edge / times > 0.5 * finest) times *= 2;
    return times;
}

std::optional<DetailSource> detailOf(const Scene& scene, const SceneVolume& volume, const FieldPointer& grid) {
    const int asked = volume.edit ? volume.edit->detail : 1;
    if (asked == 1 || grid->empty()) return std::nullopt;
    DetailSource out;
    out.grid = grid;
    out.shading = volume.shading;
    out.displacement = volume.displacement;
    out.ramp = volume.ramp;
    const std::optional<Noise>& noise = volume.shading.noise;
    if ((noise && noise->inWorld) || (out.displacement && out.displacement->inWorld))
        out.wsFromAsset = volume.wsFromAsset;
    out.times = asked;
    if (asked == 0)
        for (const std::optional<Noise>* const one : {&noise, &volume.displacement})
            if (*one) {
                const Vec3 edges = voxelEdges((*one)->inWorld ? volume.wsFromAsset * grid->wsFromIs : grid->wsFromIs);
                out.times = std::max(out.times, timesFor(**one, std::max({edges.x, edges.y, edges.z})));
            }
    if (out.times <= 1) return std::nullopt;
    const Mat4 wsFromIs = volume.wsFromAsset * grid->wsFromIs;
    const Vec3 edges = voxelEdges(wsFromIs);
    Medium medium = volume.medium;
    medium.densityScale = volume.densityScale;
    // In single precision, in which they do not change while the volume turns.
    out.longDepth = static_cast<float>(medium.mostExtinction() * std::max({edges.x, edges.y, edges.z}));
    out.shortDepth = static_cast<float>(medium.mostExtinction() * std::min({edges.x, edges.y, edges.z}));
    const bool linear = volume.interpolation == GridInterpolation::linear ||
                        (volume.interpolation == GridInterpolation::automatic && scene.dials.kernel == Kernel::linear);
    out.whole = volume.classified || !linear;
    lookInside(scene, volume, wsFromIs, out);
    return out;
}

DetailedDensity DetailMaker::of(DetailSource source) {
    const auto found =
        std::find_if(m_all.begin(), m_all.end(), [&](const Made& made) { return made.source == source; });
    if (found != m_all.end()) {
        found->used = true;
        return found->density;
    }
    DetailedDensity density = detailedDensity(source);
    return m_all.emplace_back(Made{std::move(source), std::move(density)}).density;
}

void DetailMaker::forgetUnused() {
    std::erase_if(m_all, [](const Made& made) { return !made.used; });
    for (Made& made : m_all) made.used = false;
}

}  // namespace scrim
