// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/toml_reader.h>

#include <scrim/base/error.h>
#include <scrim/scene/nearest_name.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace scrim {
namespace {

/// "1000000", but "1e+15".
std::string limitText(double v) {
    return std::abs(v) > 1e6 ? fmt::format("{:g}", v) : fmt::format("{}", v);
}

/// " of at least 0 degrees".
std::string limitsText(const Range& range) {
    std::string text;
    const bool low = std::isfinite(range.low), high = std::isfinite(range.high);
    if (low && high && !range.openLow && !range.openHigh) {
        text = fmt::format(" from {} to {}", limitText(range.low), limitText(range.high));
    } else {
        if (low) text += fmt::format(" {} {}", range.openLow ? "greater than" : "of at least", limitText(range.low));
        if (low && high) text += " and";
        if (high) text += fmt::format(" {} {}", range.openHigh ? "less than" : "of at most", limitText(range.high));
    }
    if (range.unit.empty()) return text;
    return text + (low || high ? " " : " of ") + range.unit;
}

bool holds(const Range& range, double v) {
    if (!std::isfinite(v)) return false;
    return (range.openLow ? v > range.low : v >= range.low) && (range.openHigh ? v < range.high : v <= range.high);
}

std::string numberText(const Range& range) {
    return "a number" + limitsText(range);
}
std::string vectorText(const Range& range) {
    return "three numbers [x, y, z], each" + (limitsText(range).empty() ? " finite" : limitsText(range));
}

std::string foundText(const toml::node& node) {
    if (const auto* text = node.as_string()) return fmt::format("the string \"{}\"", shortened(text->get(), 80));
    if (const auto* value = node.as_integer()) return fmt::format("{}", value->get());
    if (const auto* value = node.as_floating_point()) return fmt::format("{}", value->get());
    if (const auto* value = node.as_boolean()) return value->get() ? "true" : "false";
    if (const auto* list = node.as_array()) return fmt::format("a list of {}", list->size());
    if (node.is_table()) return "a table";
    return "a date or time";
}

}  // namespace

/// Far beyond any scene.
constexpr double kFarthest = 1e15;

Range Range::atLeast(double low, std::string unit) {
    Range range;
    range.low = low;
    range.unit = std::move(unit);
    return range;
}

Range Range::above(double low, std::string unit) {
    Range range = atLeast(low, std::move(unit));
    range.openLow = true;
    return range;
}

Range Range::fromTo(double low, double high, std::string unit) {
    return {low, high, false, false, std::move(unit)};
}
Range Range::between(double low, double high, std::string unit) {
    return {low, high, true, true, std::move(unit)};
}
Range Range::coordinate() {
    return fromTo(-kFarthest, kFarthest, "world units");
}
Range Range::length() {
    return fromTo(0, kFarthest, "world units");
}
Range Range::positiveLength() {
    return {0, kFarthest, true, false, "world units"};
}

// ---- values

void TomlValue::fail(const std::string& problem) const {
    throw Error(ErrorKind::input, fmt::format("{}: {}", where(), problem));
}

void TomlValue::failExpecting(const std::string& expected) const {
    fail(fmt::format("'{}' is {}; expected {}", shortened(m_name, 80), foundText(*m_node), expected));
}

double TomlValue::number(const Range& range) const {
    if (!m_node->is_number()) failExpecting(numberText(range));
    const double v =
        m_node->is_integer() ? static_cast<double>(m_node->as_integer()->get()) : m_node->as_floating_point()->get();
    if (!holds(range, v)) failExpecting(numberText(range));
    return v;
}

int TomlValue::integer(int low, int high, const std::string& unit) const {
    const std::string expected =
        fmt::format("a whole number from {} to {}{}", low, high, unit.empty() ? "" : " " + unit);
    const auto* value = m_node->as_integer();
    if (value == nullptr || value->get() < low || value->get() > high) failExpecting(expected);
    return static_cast<int>(value->get());
}

bool TomlValue::boolean() const {
    if (!m_node->is_boolean()) failExpecting("true or false");
    return m_node->as_boolean()->get();
}

std::string TomlValue::string() const {
    const auto* text = m_node->as_string();
    if (text == nullptr || text->get().empty()) failExpecting("a string that is not empty");
    // A NUL would cut a file's name short.
    if (text->get().find('\0') != std::string::npos) failExpecting("a string without NUL characters");
    return text->get();
}

std::size_t TomlValue::choice(const std::vector<std::string>& words) const {
    const auto* text = m_node->as_string();
    const auto found = text == nullptr ? words.end() : std::find(words.begin(), words.end(), text->get());
    if (found == words.end()) failExpecting(choices(words));
    return std::size_t(found - words.begin());
}

std::vector<TomlValue> TomlValue::items(std::size_t count, const std::string& expected) const {
    const auto* list = m_node->as_array();
    if (list == nullptr || (count > 0 && list->size() != count)) failExpecting(expected);
    std::vector<TomlValue> values;
    for (std::size_t i = 0; i < list->size(); ++i) values.emplace_back((*list)[i], fmt::format("{}[{}]", m_name, i));
    return values;
}

Vec3 TomlValue::vec3(const Range& range) const {
    const std::vector<TomlValue> parts = items(3, vectorText(range));
    return {parts[0].number(range), parts[1].number(range), parts[2].number(range)};
}

Rgb TomlValue::colour(const ColourConfig& config) const {
    constexpr const char* kExpected =
        "a colour [r, g, b], each of at least 0, or { rgb = [r, g, b], colorspace = \"...\" }";
    const auto components = [&](const TomlValue& value) {
        const std::vector<TomlValue> parts = value.items(3, kExpected);
        return Rgb(parts[0].number(Range::atLeast(0)), parts[1].number(Range::atLeast(0)),
                   parts[2].number(Range::atLeast(0)));
    };
    if (!isTable()) return components(*this);
    TomlTable table = this->table(fmt::format("the colour '{}'", m_name));
    table.find("rgb");
    table.find("colorspace");
    table.finish();  // before asking for both: { grid = ... } is no misspelt colour
    const TomlValue rgb = table.require("rgb", "three numbers [r, g, b]");
    const TomlValue space = table.require("colorspace", "the name of a colour space");
    try {
        return config.toWorking(components(rgb), space.string());
    } catch (const Error& error) {
        if (config.hasSpace(space.string())) throw;
        space.fail(error.what());
    }
}

TomlTable TomlValue::table(std::string description) const {
    if (!isTable()) failExpecting("a table");
    return {*m_node->as_table(), std::move(description)};
}

template <typename T>
T TomlValue::keyedAt(double frame, const std::function<T(const TomlValue&)>& read) const {
    // A table without 'keys' may be what `read` expects: a colour with its space.
    if (!isTable() || m_node->as_table()->get("keys") == nullptr) return read(*this);
    TomlTable table = this->table(fmt::format("the keyed '{}'", m_name));
    const TomlValue list = table.require("keys", "a list of [frame, value]");
    Keyed<T> keyed;
    if (table.choice("interpolation", {"linear", "smooth"}, 0) == 1) keyed.interpolation = Interpolation::smooth;
    table.finish();
    for (const TomlValue& key : list.items(0, "a list of [frame, value]")) {
        const std::vector<TomlValue> pair = key.items(2, "[frame, value]");
        const double at = pair[0].number(Range::fromTo(-1e9, 1e9, "frames"));
        if (!keyed.keys.empty() && at <= keyed.keys.back().first)
            pair[0].fail(fmt::format("'{}': frame {} does not come after frame {}; expected ascending frames", m_name,
                                     at, keyed.keys.back().first));
        keyed.keys.emplace_back(at, read(pair[1]));
    }
    if (keyed.keys.empty()) list.failExpecting("at least one [frame, value]");
    return keyed.at(frame);
}

double TomlValue::numberAt(double frame, const Range& range) const {
    return keyedAt<double>(frame, [&](const TomlValue& value) { return value.number(range); });
}

Vec3 TomlValue::vec3At(double frame, const Range& range) const {
    return keyedAt<Vec3>(frame, [&](const TomlValue& value) { return value.vec3(range); });
}

Rgb TomlValue::colourAt(double frame, const ColourConfig& config) const {
    return keyedAt<Rgb>(frame, [&](const TomlValue& value) { return value.colour(config); });
}

Vec3 TomlValue::scaleAt(double frame) const {
    const Vec3 scale = keyedAt<Vec3>(frame, [&](const TomlValue& value) {
        return value.isNumber() ? Vec3(value.number(Range::fromTo(-1e12, 1e12)))
                                : value.vec3(Range::fromTo(-1e12, 1e12));
    });
    if (scale.x == 0 || scale.y == 0 || scale.z == 0)
        fail(fmt::format("'{}' is 0 at frame {}; expected a number or three numbers, none of them 0", m_name, frame));
    return scale;
}

// ---- tables

TomlTable::TomlTable(const toml::table& table, std::string description)
    : m_table(&table), m_description(std::move(description)) {}

void TomlTable::fail(const std::string& problem) const {
    throw Error(ErrorKind::input, fmt::format("{}: {}", where(), problem));
}

std::optional<TomlValue> TomlTable::find(std::string_view key) {
    if (std::find(m_known.begin(), m_known.end(), key) == m_known.end()) m_known.emplace_back(key);
    const toml::node* node = m_table->get(key);
    if (node == nullptr) return std::nullopt;
    return TomlValue(*node, std::string(key));
}

TomlValue TomlTable::require(std::string_view key, const std::string& expected) {
    if (const auto value = find(key)) return *value;
    // Behind a misspelt key the unknown one is the better message; it is reported only if it is close.
    for (const auto& [other, node] : *m_table) {
        const std::string name(other.str());
        const bool known = std::find(m_known.begin(), m_known.end(), name) != m_known.end();
        if (!known && nearestName(name, {std::string(key)}) == key)
            throw Error(ErrorKind::input,
                        fmt::format("{}: '{}' is not known here ({}); did you mean '{}'?", whereOf(other.source()),
                                    shortened(name, 60), m_description, key));
    }
    fail(fmt::format("{} lacks '{}'; expected {}", m_description, key, expected));
}

std::vector<TomlTable> TomlTable::tables(std::string_view key) {
    std::vector<TomlTable> out;
    const auto list = find(key);
    if (!list) return out;
    const std::string description = fmt::format("[[{}]]", key);
    const std::string expected = fmt::format("a list of tables, each written {}", description);
    for (const TomlValue& item : list->items(0, expected)) {
        if (!item.isTable()) item.failExpecting(expected);
        out.push_back(item.table(description));
    }
    return out;
}

double TomlTable::number(std::string_view key, double fallback, const Range& range) {
    const auto value = find(key);
    return value ? value->number(range) : fallback;
}

int TomlTable::integer(std::string_view key, int fallback, int low, int high, const std::string& unit) {
    const auto value = find(key);
    return value ? value->integer(low, high, unit) : fallback;
}

bool TomlTable::boolean(std::string_view key, bool fallback) {
    const auto value = find(key);
    return value ? value->boolean() : fallback;
}

std::string TomlTable::string(std::string_view key, std::string fallback) {
    const auto value = find(key);
    return value ? value->string() : fallback;
}

std::size_t TomlTable::choice(std::string_view key, const std::vector<std::string>& words, std::size_t fallback) {
    const auto value = find(key);
    return value ? value->choice(words) : fallback;
}

double TomlTable::numberAt(double frame, std::string_view key, double fallback, const Range& range) {
    const auto value = find(key);
    return value ? value->numberAt(frame, range) : fallback;
}

std::vector<TomlValue> TomlTable::all() {
    std::vector<TomlValue> values;
    for (const auto& [key, node] : *m_table) {
        m_known.emplace_back(key.str());
        values.emplace_back(node, std::string(key.str()));
    }
    // The table is sorted by name; people think in lines. Overrides, which have none, keep that order.
    std::stable_sort(values.begin(), values.end(), [this](const TomlValue& a, const TomlValue& b) {
        const auto begin = [this](const TomlValue& v) { return m_table->get(v.name())->source().begin; };
        return begin(a) < begin(b);
    });
    return values;
}

void TomlTable::finish() const {
    const toml::key* first = nullptr;
    for (const auto& [key, node] : *m_table) {
        if (std::find(m_known.begin(), m_known.end(), key.str()) != m_known.end()) continue;
        if (first == nullptr || key.source().begin < first->source().begin) first = &key;
    }
    if (first == nullptr) return;
    const std::string name(first->str());
    throw Error(ErrorKind::input,
                fmt::format("{}: '{}' is not known here ({}){}; allowed: {}", whereOf(first->source()),
                            shortened(name, 60), m_description, didYouMean(name, m_known), choices(m_known)));
}

}  // namespace scrim
