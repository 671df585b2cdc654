// SPDX-License-Identifier: Apache-2.0
// Reads what is done to the values of a volume: remap, edge, mask, noise, displacement.
#include <scrim/scene/read_sections.h>

#include <fmt/format.h>

namespace scrim {

std::array<double, 2> readPair(TomlTable& table, const Key& key, bool ascends) {
    const auto value = table.find(key);
    if (!value) return {0, 1};
    const auto ends = value->items(2);
    const std::array<double, 2> pair{ends[0].number(), ends[1].number()};
    if (ascends && !(pair[0] < pair[1]))
        value->fail(fmt::format("{} is [{}, {}]; expected ascending numbers", key, pair[0], pair[1]));
    return pair;
}

namespace {

Remap readRemap(TomlTable table, const ReadContext& context) {
    const RemapKeys& k = keysOf<RemapKeys>();
    Remap remap;
    remap.from = readPair(table, k.from, true);
    remap.to = readPair(table, k.to, false);
    table.read(k, context.frame, remap);
    table.finish();
    if (remap.at(0) != 0)
        table.fail(fmt::format("{} maps 0 to {}; expected 0, because empty space is skipped", table.description(),
                               remap.at(0)));
    return remap;
}

}  // namespace

Mask readMask(const TomlValue& value, const std::string& of) {
    const MaskKeys& k = keysOf<MaskKeys>();
    TomlTable table = value.table(fmt::format("'{}' of {}", value.name(), of));
    const TomlValue grid = table.require(k.grid);
    Mask mask;
    mask.grid = grid.string();
    mask.where = grid.where();
    mask.remap.from = readPair(table, k.from, true);
    mask.remap.to = readPair(table, k.to, false);
    table.finish();
    return mask;
}

Noise readNoise(const TomlValue& value, const std::string& of, const ReadContext& context) {
    const NoiseKeys& k = keysOf<NoiseKeys>();
    TomlTable table = value.table(fmt::format("'{}' of {}", value.name(), of));
    Noise noise;
    noise.where = value.where();
    table.read(k, context.wholeFrame, noise);
    if (const auto offset = table.find(k.offset)) noise.offset = offset->vec3At(context.wholeFrame);
    table.finish();
    return noise;
}

void readDensityShading(TomlTable& table, const ReadContext& context, DensityShading& shading) {
    const DensityKeys& k = keysOf<DensityKeys>();
    const std::string of = table.description();
    if (const auto remap = table.find(k.remap))
        shading.remap = readRemap(remap->table(fmt::format("'{}' of {}", remap->name(), of)), context);
    if (table.find(k.edge)) shading.edge = readPair(table, k.edge, true);
    if (const auto mask = table.find(k.mask)) shading.mask = readMask(*mask, of);
    if (const auto noise = table.find(k.noise)) shading.noise = readNoise(*noise, of, context);
}

}  // namespace scrim
