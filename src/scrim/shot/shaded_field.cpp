// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/shaded_field.h>

#include <scrim/base/error.h>
#include <scrim/scene/noise_blocks.h>
#include <scrim/shot/values_at.h>
#include <scrim/volume/field_builder.h>
#include <scrim/volume/field_sampler.h>

#include <algorithm>
#include <array>
#include <optional>

#include <fmt/format.h>
#include <glm/common.hpp>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

/// Most blocks that a field may get, which take 4 GB.
constexpr std::size_t kMostBlocks = std::size_t{1} << 21;

/// No noise is larger; a sum of octaves is a mean of such values, of which evolution adds two with squared weights
/// of 1.
constexpr double kNoiseBound = 1.04 * 1.4143;

using Values = std::array<float, kBlockVoxels>;

[[noreturn]] void tooLarge(const SparseField& field) {
    throw Error(ErrorKind::memory,
                fmt::format("grid '{}' has constant regions that are too large for masks, noise or displacement: these "
                            "need voxels, more than {} million",
                            field.name, kMostBlocks * kBlockVoxels / 1000000));
}

Int3 voxelOf(int i) {
    return {i / (kBlockEdge * kBlockEdge), i / kBlockEdge % kBlockEdge, i % kBlockEdge};
}

/// Where noise is evaluated: in the scene's world, or in the asset's.
Mat4 placeOf(const Noise& noise, const SparseField& field, const Mat4& wsFromAsset) {
    return noise.inWorld ? wsFromAsset * field.wsFromIs : field.wsFromIs;
}

/// The field with `fill(origin, values)` run on each of its blocks. Its tiles become blocks.
template <typename Fill>
FieldPointer changedField(const SparseField& field, const Fill& fill) {
    std::vector<ConstantBlock> constant;
    for (const ConstantTile& tile : field.tiles) {
        const std::size_t edge = std::size_t(tile.edge / kBlockEdge);
        if (edge * edge * edge + field.blockCount() + constant.size() > kMostBlocks) tooLarge(field);
        for (int x = 0; x < tile.edge; x += kBlockEdge)
            for (int y = 0; y < tile.edge; y += kBlockEdge)
                for (int z = 0; z < tile.edge; z += kBlockEdge)
                    constant.push_back({tile.origin + Int3(x, y, z), tile.value});
    }
    return changedBlocks(field, constant, {}, fill);
}

/// The field with each value above 0 mapped by `map`; tiles stay tiles.
template <typename Map>
FieldPointer mappedField(const SparseField& field, const Map& map) {
    FieldPieces pieces;
    pieces.name = field.name;
    pieces.wsFromIs = field.wsFromIs;
    pieces.blockOrigins = field.blockOrigins;
    for (const ConstantTile& tile : field.tiles)
        pieces.tiles.push_back({tile.origin, tile.edge, static_cast<float>(map(double(tile.value)))});
    pieces.fill = [&](std::size_t b, float* to) {
        const float* const from = field.block(b);
        for (int i = 0; i < kBlockVoxels; ++i) to[i] = from[i] > 0 ? static_cast<float>(map(double(from[i]))) : 0.0f;
    };
    return std::make_shared<SparseField>(buildField(std::move(pieces)));
}

/// The blocks that the field may touch after the noise has moved it by at most `reach` voxels along each axis.
std::vector<Int3> blocksWithin(const SparseField& field, const BlockIndex& index, const Noise& noise,
                               const Vec3& reach) {
    std::vector<Int3> found;
    if (dividedBlocks(field) > double(kMostBlocks)) tooLarge(field);
    const auto refuse = [&] {
        throw Error(
            ErrorKind::input,
            fmt::format("{}{}displacement by {:g} spreads grid '{}' over more than {} million voxels; expected a "
                        "smaller 'amount'",
                        noise.where, noise.where.empty() ? "" : ": ", noise.amount, field.name,
                        kMostBlocks * kBlockVoxels / 1000000));
    };
    const auto add = [&](const Int3& origin, int edge) {
        const Vec3 first = glm::floor((Vec3(origin) - reach - 1.0) / double(kBlockEdge));
        const Vec3 last = glm::floor(glm::ceil(Vec3(origin + (edge - 1)) + reach + 1.0) / double(kBlockEdge));
        const Vec3 size = last - first + 1.0;
        if (!(size.x * size.y * size.z <= double(kMostBlocks))) refuse();
        const Int3 low(first), high(last);
        for (int x = low.x; x <= high.x; ++x)
            for (int y = low.y; y <= high.y; ++y)
                for (int z = low.z; z <= high.z; ++z)
                    found.emplace_back(x * kBlockEdge, y * kBlockEdge, z * kBlockEdge);
    };
    const auto unite = [&] {
        std::sort(found.begin(), found.end(), originLess);
        found.erase(std::unique(found.begin(), found.end()), found.end());
        if (found.size() > kMostBlocks) refuse();
    };
    for (const ConstantTile& tile : field.tiles) {
        add(tile.origin, tile.edge);
        if (found.size() > 4 * kMostBlocks) unite();
    }
    for (const Int3& origin : field.blockOrigins) {
        add(origin, kBlockEdge);
        if (found.size() > 4 * kMostBlocks) unite();
    }
    unite();
    std::erase_if(found, [&](const Int3& origin) {
        return !index.anyIn({Vec3(origin) - reach - 1.0, Vec3(origin + (kBlockEdge - 1)) + reach + 1.0});
    });
    return found;
}

}  // namespace

FieldPointer shadedDensity(const FieldPointer& density, const DensityShading& shading, const FieldPointer& mask,
                           const Mat4& wsFromAsset) {
    if (density->empty()) return density;
    if (!shading.mask && !shading.noise) return mappedField(*density, [&](double v) { return shading.at(v, 0, 0); });
    std::optional<ValuesAt> masks;
    if (shading.mask) masks.emplace(*density, *mask);
    std::optional<NoiseBlocks> noise;
    if (shading.noise) noise.emplace(*shading.noise, placeOf(*shading.noise, *density, wsFromAsset));
    return changedField(*density, [&](const Int3& origin, float* values) {
        Values pattern{};
        if (noise) noise->fill(origin, pattern.data());
        for (int i = 0; i < kBlockVoxels; ++i)
            if (values[i] > 0)
                values[i] = static_cast<float>(shading.at(double(values[i]), masks ? masks->at(origin + voxelOf(i)) : 0,
                                                          double(pattern[std::size_t(i)])));
    });
}

FieldPointer displacedField(const FieldPointer& field, const Noise& noise, const Mat4& wsFromAsset) {
    if (field->empty() || noise.amount == 0) return field;
    const FieldSampler from(*field);
    const Mat4 placeFromIs = placeOf(noise, *field, wsFromAsset);
    const Mat3 isFromPlace = glm::inverse(Mat3(placeFromIs));
    Vec3 reach(0);
    for (int axis = 0; axis < 3; ++axis) reach += std::abs(noise.amount) * kNoiseBound * glm::abs(isFromPlace[axis]);
    FieldPieces pieces;
    pieces.name = field->name;
    pieces.wsFromIs = field->wsFromIs;
    pieces.blockOrigins = blocksWithin(*field, from.index(), noise, reach);
    const std::vector<Int3> origins = pieces.blockOrigins;
    const NoiseBlocks patterns[3]{{noise, placeFromIs, 0}, {noise, placeFromIs, 1}, {noise, placeFromIs, 2}};
    pieces.fill = [&](std::size_t b, float* to) {
        std::array<Values, 3> way;
        for (std::size_t c = 0; c < 3; ++c) patterns[c].fill(origins[b], way[c].data());
        for (std::size_t i = 0; i < kBlockVoxels; ++i) {
            const Vec3 place = noise.amount * Vec3(way[0][i], way[1][i], way[2][i]);
            to[i] = static_cast<float>(from.value(Vec3(origins[b] + voxelOf(int(i))) - isFromPlace * place));
        }
    };
    return std::make_shared<SparseField>(buildField(std::move(pieces)));
}

FieldPointer maskedField(const FieldPointer& field, const Mask& mask, const FieldPointer& grid) {
    if (field->empty()) return field;
    const ValuesAt masks(*field, *grid);
    return changedField(*field, [&](const Int3& origin, float* values) {
        for (int i = 0; i < kBlockVoxels; ++i)
            if (values[i] > 0)
                values[i] = static_cast<float>(double(values[i]) * mask.remap.at(masks.at(origin + voxelOf(i))));
    });
}

FieldPointer clippedField(const FieldPointer& field, const std::vector<HalfSpace>& spaces) {
    if (field->empty()) return field;
    const Mat3 edges(field->wsFromIs);
    return changedField(*field, [&](const Int3& origin, float* values) {
        for (int i = 0; i < kBlockVoxels; ++i)
            if (values[i] > 0)
                values[i] *= static_cast<float>(
                    partIn(spaces, transformPoint(field->wsFromIs, Vec3(origin + voxelOf(i))), edges));
    });
}

FieldPointer FieldShader::density(const SceneVolume& volume, const FieldPointer& field, const FieldPointer& mask) {
    const DensityShading& shading = volume.shading;
    if (!shading.any()) return field;
    const Mat4 place = shading.noise && shading.noise->inWorld ? volume.wsFromAsset : Mat4(1.0);
    return kept({field, mask, shading, {}, place}, [&] { return shadedDensity(field, shading, mask, place); });
}

FieldPointer FieldShader::displaced(const SceneVolume& volume, const FieldPointer& field) {
    const auto& displacement = volume.displacement;
    if (!displacement) return field;
    const Mat4 place = displacement->inWorld ? volume.wsFromAsset : Mat4(1.0);
    return kept({field, nullptr, {}, displacement, place}, [&] { return displacedField(field, *displacement, place); });
}

FieldPointer FieldShader::kept(Shaded wanted, const std::function<FieldPointer()>& make) {
    const auto same = [&](const Shaded& s) {
        return s.field == wanted.field && s.mask == wanted.mask && s.shading == wanted.shading &&
               s.displacement == wanted.displacement && s.wsFromAsset == wanted.wsFromAsset;
    };
    const auto found = std::find_if(m_all.begin(), m_all.end(), same);
    if (found != m_all.end()) {
        found->used = true;
        return found->made;
    }
    wanted.made = make();
    m_all.push_back(std::move(wanted));
    return m_all.back().made;
}

void FieldShader::forgetUnused() {
    std::erase_if(m_all, [](const Shaded& s) { return !s.used; });
    for (Shaded& s : m_all) s.used = false;
}

}  // namespace scrim
