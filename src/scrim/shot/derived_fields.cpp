// SPDX-License-Identifier: Apache-2.0
#include <scrim/shot/derived_fields.h>

#include <scrim/base/parallel.h>
#include <scrim/scene/ramp.h>
#include <scrim/shot/values_at.h>
#include <scrim/volume/field_builder.h>
#include <scrim/volume/field_sampler.h>

#include <algorithm>

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

using Ramp = std::vector<std::pair<double, double>>;

// Values of an albedo grid at the voxels of another grid.
class AlbedoAt {
  public:
    AlbedoAt(const SparseField& density, const std::array<FieldPointer, 3>& albedo, const ColourGrid& look)
        : m_look(look) {
        for (const FieldPointer& channel : albedo) m_channels.emplace_back(density, *channel);
    }
    Rgb at(const Int3& voxel) const {
        const auto part = [&](std::size_t c) { return m_channels[c].at(voxel); };
        const Rgb value = m_look.ramp.empty() ? Rgb(part(0), part(1), part(2)) : ramped(m_look.ramp, part(0));
        return glm::clamp(m_look.scale * (m_look.workingFromGrid * value), Rgb(0), Rgb(1));
    }

  private:
    const ColourGrid& m_look;
    std::vector<ValuesAt> m_channels;
};

// A block of a field's voxels; tiles are divided into blocks.
struct Block {
    Int3 origin;
    const float* values;  // null: `constant` everywhere
    float constant;
};
std::vector<Block> blocksOf(const SparseField& field) {
    std::vector<Block> blocks;
    for (std::size_t b = 0; b < field.blockCount(); ++b) blocks.push_back({field.blockOrigins[b], field.block(b), 0});
    for (const ConstantTile& tile : field.tiles)
        for (int x = 0; x < tile.edge; x += kBlockEdge)
            for (int y = 0; y < tile.edge; y += kBlockEdge)
                for (int z = 0; z < tile.edge; z += kBlockEdge)
                    blocks.push_back({tile.origin + Int3(x, y, z), nullptr, tile.value});
    return blocks;
}

// Three fields: the density times the components of `at` for each of its voxels, clamped to at least 0.
template <typename At>
std::vector<FieldPointer> productFields(const SparseField& density, const At& at) {
    const std::vector<Block> blocks = blocksOf(density);
    std::array<std::vector<float>, 3> values;
    for (auto& channel : values) channel.resize(blocks.size() * kBlockVoxels);
    parallelFor(blocks.size(), [&](std::size_t b) {
        for (int i = 0; i < kBlockVoxels; ++i) {
            const float value = blocks[b].values ? blocks[b].values[i] : blocks[b].constant;
            if (value == 0) continue;
            const Int3 within(i / (kBlockEdge * kBlockEdge), i / kBlockEdge % kBlockEdge, i % kBlockEdge);
            const Vec3 factor = at(blocks[b].origin + within);
            for (std::size_t c = 0; c < 3; ++c)
                values[c][b * kBlockVoxels + std::size_t(i)] = value * static_cast<float>(factor[static_cast<int>(c)]);
        }
    });
    std::vector<FieldPointer> fields;
    for (const std::vector<float>& channel : values) {
        FieldPieces pieces;
        pieces.name = density.name;
        pieces.wsFromIs = density.wsFromIs;
        for (const Block& block : blocks) pieces.blockOrigins.push_back(block.origin);
        pieces.fill = [&](std::size_t i, float* to) {
            std::copy_n(channel.data() + i * kBlockVoxels, kBlockVoxels, to);
        };
        fields.push_back(std::make_shared<SparseField>(buildField(std::move(pieces))));
    }
    return fields;
}

}  // namespace

FieldPointer withRamp(const SparseField& field, const Ramp& ramp) {
    auto out = std::make_shared<SparseField>(field);
    auto values = std::make_shared<std::vector<float>>(field.blockCount() * kBlockVoxels);
    parallelFor(field.blockCount(), [&](std::size_t b) {
        for (int i = 0; i < kBlockVoxels; ++i) {
            const float v = field.block(b)[i];
            (*values)[b * kBlockVoxels + std::size_t(i)] = v > 0 ? static_cast<float>(ramped(ramp, double(v))) : 0.0f;
        }
    });
    out->blockValues = std::shared_ptr<const float>(values, values->data());
    out->maxValue = 0;
    for (const float v : *values) out->maxValue = std::max(out->maxValue, v);
    for (ConstantTile& tile : out->tiles) {
        tile.value = static_cast<float>(ramped(ramp, double(tile.value)));
        out->maxValue = std::max(out->maxValue, tile.value);
    }
    return out;
}

namespace {

// A block or tile in which no ray has much optical depth.
struct Faint {
    Bounds is;
    std::size_t number;  // of the block, or, beyond them, of the tile
    double mass;         // optical depth integrated over the area across rays, squares of a voxel's edge
};

Bounds boundsOf(const Int3& origin, int edge) {
    Bounds is;
    is.include(Vec3(origin));
    is.include(Vec3(origin) + double(edge - 1));
    return is;
}

double volumeOf(const Bounds& box) {
    const Vec3 size = box.size() + 1.0;
    return size.x * size.y * size.z;
}

}  // namespace

FieldPointer withoutStrays(const FieldPointer& field, double extinction) {
    constexpr double kSparse = 1e-3, kFaint = 0.05, kMostLost = 1e-4, kSmaller = 0.5, kDiagonal = 1.7320508;
    const Bounds all = field->isBounds();
    if (field->empty() || double(field->activeVoxels) > kSparse * volumeOf(all)) return field;
    std::vector<Faint> faint;
    Bounds rest;
    const auto sort = [&](const Int3& origin, int edge, std::size_t number, double most, double sum) {
        if (extinction * kDiagonal * std::min(edge * most, sum) < kFaint)
            faint.push_back({boundsOf(origin, edge), number, extinction * sum});
        else
            rest.include(boundsOf(origin, edge));
    };
    for (std::size_t b = 0; b < field->blockCount(); ++b) {
        double most = 0, sum = 0;
        for (int i = 0; i < kBlockVoxels; ++i) {
            most = std::max(most, double(field->block(b)[i]));
            sum += double(field->block(b)[i]);
        }
        sort(field->blockOrigins[b], kBlockEdge, b, most, sum);
    }
    for (std::size_t t = 0; t < field->tiles.size(); ++t) {
        const ConstantTile& tile = field->tiles[t];
        sort(tile.origin, tile.edge, field->blockCount() + t, double(tile.value),
             double(tile.value) * std::pow(double(tile.edge), 3));
    }
    if (rest.empty()) return field;
    // The farthest go first, as long as all of them together take little of the light on the smallest face of the rest.
    const Vec3 size = rest.size() + 1.0, middle = rest.center();
    const double face = std::min({size.x * size.y, size.y * size.z, size.z * size.x});
    const auto away = [&](const Faint& f) { return glm::distance(f.is.center(), middle); };
    std::sort(faint.begin(), faint.end(), [&](const Faint& a, const Faint& b) {
        return away(a) != away(b) ? away(a) > away(b) : a.number < b.number;
    });
    std::vector<bool> dropped(field->blockCount() + field->tiles.size(), false);
    double lost = 0;
    for (const Faint& f : faint) {
        lost += f.mass / face;
        if (lost > kMostLost || rest.contains(f.is.center())) break;
        dropped[f.number] = true;
    }
    for (const Faint& f : faint)
        if (!dropped[f.number]) rest.include(f.is);
    if (volumeOf(rest) > kSmaller * volumeOf(all)) return field;
    FieldPieces pieces;
    pieces.name = field->name;
    pieces.wsFromIs = field->wsFromIs;
    std::vector<std::size_t> kept;
    for (std::size_t b = 0; b < field->blockCount(); ++b)
        if (!dropped[b]) kept.push_back(b), pieces.blockOrigins.push_back(field->blockOrigins[b]);
    for (std::size_t t = 0; t < field->tiles.size(); ++t)
        if (!dropped[field->blockCount() + t]) pieces.tiles.push_back(field->tiles[t]);
    pieces.fill = [&](std::size_t i, float* values) { std::copy_n(field->block(kept[i]), kBlockVoxels, values); };
    auto out = std::make_shared<SparseField>(buildField(std::move(pieces)));
    out->nonFinite = field->nonFinite;
    out->negative = field->negative;
    return out;
}

std::vector<FieldPointer> scatteringFields(const SparseField& density, const std::array<FieldPointer, 3>& albedo,
                                           const ColourGrid& look) {
    const AlbedoAt albedoAt(density, albedo, look);
    return productFields(density, [&](const Int3& voxel) { return albedoAt.at(voxel); });
}

std::vector<FieldPointer> flowFields(const SparseField& density, const Mat4& assetFromIs,
                                     const std::vector<FieldPointer>& velocity, const Vec3& least) {
    std::vector<FieldSampler> parts;
    std::vector<Mat4> toPart;
    for (const FieldPointer& part : velocity) {
        parts.emplace_back(*part);
        toPart.push_back(glm::inverse(part->wsFromIs) * assetFromIs);
    }
    return productFields(density, [&](const Int3& voxel) {
        const auto part = [&](int i) { return parts[i].value(transformPoint(toPart[i], Vec3(voxel))); };
        return glm::max(Vec3(part(0) - part(1), part(2) - part(3), part(4) - part(5)) - least, Vec3(0));
    });
}

std::vector<EmittedField> emittedFields(const FieldPointer& field, const Emission& emission) {
    if (emission.ramp.empty()) return {{field, emission.scale * emission.color}};
    // Tests whether all points have the colour of the brightest one, up to a factor.
    Rgb color(0);
    for (const auto& [value, rgb] : emission.ramp)
        if (glm::length(rgb) > glm::length(color)) color = rgb;
    if (color == Rgb(0)) return {};
    bool shades = true;
    Ramp strength;
    for (const auto& [value, rgb] : emission.ramp) {
        const double s = glm::dot(rgb, color) / glm::dot(color, color);
        shades = shades && glm::length(rgb - s * color) <= 1e-6 * glm::length(color);
        strength.emplace_back(value, s);
    }
    if (shades) return {{withRamp(*field, strength), emission.scale * color}};
    std::vector<EmittedField> fields;
    for (int c = 0; c < 3; ++c) {
        Ramp channel;
        for (const auto& [value, rgb] : emission.ramp) channel.emplace_back(value, rgb[c]);
        Rgb only(0);
        only[c] = emission.scale;
        fields.push_back({withRamp(*field, channel), only});
    }
    return fields;
}

FieldPointer changedBlocks(const SparseField& field, const std::vector<ConstantBlock>& constant,
                           std::vector<ConstantTile> tiles,
                           const std::function<void(const Int3& origin, float* values)>& change) {
    FieldPieces pieces;
    pieces.name = field.name;
    pieces.wsFromIs = field.wsFromIs;
    pieces.blockOrigins = field.blockOrigins;
    for (const ConstantBlock& block : constant) pieces.blockOrigins.push_back(block.origin);
    pieces.tiles = std::move(tiles);
    pieces.fill = [&](std::size_t b, float* to) {
        const bool own = b < field.blockCount();
        if (own)
            std::copy_n(field.block(b), kBlockVoxels, to);
        else
            std::fill_n(to, kBlockVoxels, constant[b - field.blockCount()].value);
        change(own ? field.blockOrigins[b] : constant[b - field.blockCount()].origin, to);
    };
    return std::make_shared<SparseField>(buildField(std::move(pieces)));
}

}  // namespace scrim
