// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/read_sections.h>

#include <fmt/format.h>

namespace scrim {
namespace {

TransferPoint readPoint(TomlTable table, const ReadContext& context) {
    TransferPoint point;
    point.value = table.require("value", "a value of the grid").number();
    if (const auto color = table.find("color")) point.color = color->colour(context.colour);
    point.extinction =
        table.require("extinction", "extinction per world unit").number(Range::fromTo(0, 1e30, "per world unit"));
    table.finish();
    return point;
}

std::vector<TransferPoint> readTransfer(const TomlValue& value, const ReadContext& context) {
    std::vector<TransferPoint> points;
    for (const TomlValue& item : value.items(0, "a list of { value, color, extinction }")) {
        points.push_back(readPoint(item.table(fmt::format("'{}'", item.name())), context));
        if (points.size() > 1 && points.back().value < points[points.size() - 2].value)
            item.fail(fmt::format("'transfer': {} comes after {}; expected ascending values", points.back().value,
                                  points[points.size() - 2].value));
    }
    if (points.size() < 2) value.failExpecting("at least two points { value, color, extinction }");
    if (points.back().value <= 0)
        value.fail("'transfer' ends at a value that is not above 0; the field has no others than such");
    Classified probe;
    probe.transfer = points;
    if (classify(probe, 0).extinction > 0)
        value.fail(
            "'transfer' maps 0 to more extinction than 0; expected 0, since empty space, which is 0, is never looked "
            "at");
    return points;
}

}  // namespace

Classified readClassified(TomlTable table, const ReadContext& context) {
    Classified out;
    out.transfer = readTransfer(table.require("transfer", "a list of { value, color, extinction }"), context);
    const Range share = Range::fromTo(0, 1e6);
    out.ambient = table.number("ambient", out.ambient, share);
    out.diffuse = table.number("diffuse", out.diffuse, share);
    out.specular = table.number("specular", out.specular, share);
    out.exponent = table.number("exponent", out.exponent, Range::fromTo(0, 1e4));
    out.twoSided = table.boolean("two_sided", out.twoSided);
    table.finish();
    return out;
}

}  // namespace scrim
