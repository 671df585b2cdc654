// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/read_ramp.h>
#include <scrim/scene/read_sections.h>

#include <fmt/format.h>

namespace scrim {
namespace {

TransferPoint readPoint(TomlTable table, const ReadContext& context) {
    const TransferKeys& k = keysOf<TransferKeys>();
    TransferPoint point;
    if (const auto color = table.find(k.color)) point.color = color->colour(context.colour);
    table.read(k, context.frame, point);
    table.finish();
    return point;
}

std::vector<TransferPoint> readTransfer(const TomlValue& value, const ReadContext& context) {
    std::vector<TransferPoint> points;
    for (const TomlValue& item : value.items(0)) {
        points.push_back(readPoint(item.table(fmt::format("'{}'", item.name())), context));
        if (points.size() > 1 && points.back().value < points[points.size() - 2].value)
            item.fail(fmt::format("'{}': {} comes after {}; expected ascending values", value.name(),
                                  points.back().value, points[points.size() - 2].value));
    }
    if (points.size() < 2) value.failExpecting("at least two points { value, color, extinction }");
    if (points.back().value <= 0)
        value.fail(fmt::format(
            "'{}' ends at a value of 0 or less; expected a last value above 0, because those values are empty space",
            value.name()));
    Classified probe;
    probe.transfer = points;
    if (classify(probe, 0).extinction > 0)
        value.fail(fmt::format(
            "'{}' has extinction above 0 at value 0; expected 0 there, because empty space is skipped", value.name()));
    return points;
}

std::vector<TransferPoint> readWindow(const TomlValue& value, double zero) {
    if (!value.isArray()) {
        static const std::vector<std::string> names{"bone", "soft tissue", "lung", "vessels"};
        return transferOf(static_cast<ScanWindow>(value.choice(names)), zero);
    }
    const auto window = value.items(2);
    const double centre = window[0].number(), width = window[1].number();
    if (!(width > 0)) value.failExpecting("[centre, width] with a width above 0");
    if (!(centre + 0.5 * width + zero > 0))
        value.fail(fmt::format("'{}' ends at {}; expected an end above {}, because grid values below 0 are empty",
                               value.name(), centre + 0.5 * width, -zero));
    return transferOf(centre, width, zero);
}

std::vector<std::pair<double, double>> readGradient(const TomlValue& value) {
    return readRamp<double>(value, "[length, factor]",
                            [](const TomlValue& factor) { return factor.number(Range::fromTo(0, 1)); });
}

}  // namespace

Classified readClassified(TomlTable table, const ReadContext& context) {
    const ClassifiedKeys& k = keysOf<ClassifiedKeys>();
    Classified out;
    const double zero = table.number(k.windowZero);
    if (const auto window = table.find(k.window)) {
        out.transfer = readWindow(*window, zero);
        out.perVoxel = true;
    } else {
        out.transfer = readTransfer(table.require(k.transfer), context);
    }
    if (const auto gradient = table.find(k.gradient)) out.gradientRamp = readGradient(*gradient);
    table.read(k, context.frame, out);
    if (const auto albedo = table.find(k.albedo)) {
        if (!out.scatters)
            albedo->fail(fmt::format("{} has {} without {}; expected both, or none", table.description(), k.albedo,
                                     k.albedo.only));
        out.albedo = readBounded(*albedo, context, 1);
    }
    if (const double most = mostScattered(out); out.scatters && most > kMostScattered)
        table.find(k.scattering)
            ->fail(
                fmt::format("{} has {}, and {} times a colour is {:.4g}; expected at most 1, since more light would be "
                            "scattered than there is",
                            table.description(), k.albedo.only, k.albedo, most));
    table.finish();
    return out;
}

}  // namespace scrim
