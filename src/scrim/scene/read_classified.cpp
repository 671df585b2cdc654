// SPDX-License-Identifier: Apache-2.0
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

}  // namespace

Classified readClassified(TomlTable table, const ReadContext& context) {
    const ClassifiedKeys& k = keysOf<ClassifiedKeys>();
    Classified out;
    out.transfer = readTransfer(table.require(k.transfer), context);
    table.read(k, context.frame, out);
    table.finish();
    return out;
}

}  // namespace scrim
