// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/toml_reader.h>

#include <scrim/base/error.h>
#include <scrim/scene/nearest_name.h>

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace scrim {
namespace {

std::string numberText(const Range& range) {
    return "a number" + range.text();
}
std::string vectorText(const Range& range) {
    return "three numbers [x, y, z], each" + (range.text().empty() ? " finite" : range.text());
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

// ---- values

void TomlValue::fail(const std::string& problem) const {
    throw Error(ErrorKind::input, fmt::format("{}: {}", where(), problem));
}

void TomlValue::failExpecting(const std::string& expected) const {
    fail(fmt::format("'{}' is {}; expected {}", shortened(m_name, 80), foundText(*m_node), expected));
}

double TomlValue::number() const {
    return number(m_key == nullptr ? Range() : m_key->range);
}

double TomlValue::number(const Range& range) const {
    if (!m_node->is_number()) failExpecting(numberText(range));
    const double v =
        m_node->is_integer() ? static_cast<double>(m_node->as_integer()->get()) : m_node->as_floating_point()->get();
    if (!range.holds(v)) failExpecting(numberText(range));
    return v;
}

int TomlValue::integer() const {
    const Range& range = m_key->range;
    const auto* value = m_node->as_integer();
    if (value == nullptr || !range.holds(static_cast<double>(value->get())))
        failExpecting("a whole number" + range.text());
    return static_cast<int>(value->get());
}

bool TomlValue::boolean() const {
    if (!m_node->is_boolean()) failExpecting("true or false");
    return m_node->as_boolean()->get();
}

std::string TomlValue::string() const {
    const auto* text = m_node->as_string();
    if (text == nullptr || text->get().empty()) failExpecting("a string that is not empty");
    // A NUL would cut off a file's name.
    if (text->get().find('\0') != std::string::npos) failExpecting("a string without NUL characters");
    return text->get();
}

TextPlace TomlValue::textPlace() const {
    const toml::source_region& region = m_node->source();
    if (whereOf(region) !=
        fmt::format("{}:{}:{}", region.path ? *region.path : "scene", region.begin.line, region.begin.column))
        return {};
    const std::string text = string();
    const auto isCharacter = [](char c) { return (static_cast<unsigned char>(c) & 0xC0) != 0x80; };
    const auto characters = std::count_if(text.begin(), text.end(), isCharacter);
    const int lines = static_cast<int>(region.end.line) - static_cast<int>(region.begin.line);
    TextPlace place{region.path ? *region.path : "scene", static_cast<int>(region.begin.line),
                    static_cast<int>(region.begin.column)};
    // A newline right behind three quotes is no part of the string.
    if (lines > std::count(text.begin(), text.end(), '\n')) return {place.file, place.line + 1, 1};
    const bool three = lines > 0 || static_cast<int>(region.end.column) - place.column >= characters + 6;
    place.column += three ? 3 : 1;
    return place;
}

std::size_t TomlValue::choice() const {
    return choice(m_key->words);
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
    for (std::size_t i = 0; i < list->size(); ++i)
        values.emplace_back((*list)[i], fmt::format("{}[{}]", m_name, i), m_key);
    return values;
}

std::vector<TomlValue> TomlValue::items(std::size_t count) const {
    return items(count, m_key->form);
}

Vec3 TomlValue::vec3() const {
    const std::vector<TomlValue> parts = items(3, vectorText(m_key == nullptr ? Range() : m_key->range));
    return {parts[0].number(), parts[1].number(), parts[2].number()};
}

Rgb TomlValue::colour(const ColourConfig& config) const {
    const auto components = [](const TomlValue& value, const std::string& expected) {
        const std::vector<TomlValue> parts = value.items(3, expected);
        const Range range = Range::atLeast(0);
        return Rgb(parts[0].number(range), parts[1].number(range), parts[2].number(range));
    };
    if (!isTable()) return components(*this, kColourForm);
    const ColourKeys& k = scrim::keysOf<ColourKeys>();
    TomlTable table = this->table(fmt::format("the colour '{}'", m_name), &k);
    table.find(k.rgb);
    table.find(k.colorspace);
    // This refuses unknown keys before it requires both known ones, because { grid = ... } is not a misspelt colour.
    table.finish();
    const TomlValue rgb = table.require(k.rgb);
    const TomlValue space = table.require(k.colorspace);
    const Rgb given = components(rgb, kColourForm);
    try {
        return config.toWorking(given, space.string());
    } catch (const Error& error) {
        space.fail(error.what());
    }
}

TomlTable TomlValue::table(std::string description) const {
    return table(std::move(description), m_key == nullptr ? nullptr : m_key->inner);
}

TomlTable TomlValue::table(std::string description, const Section* section) const {
    if (!isTable()) failExpecting("a table");
    return {*m_node->as_table(), std::move(description), section};
}

double TomlValue::numberAt(double frame) const {
    return keysOf<double>([](const TomlValue& value) { return value.number(); }).at(frame);
}

Vec3 TomlValue::vec3At(double frame) const {
    return keysOf<Vec3>([](const TomlValue& value) { return value.vec3(); }).at(frame);
}

Vec2 TomlValue::pairAt(double frame) const {
    const Vec3 pair = keysOf<Vec3>([](const TomlValue& value) {
                          const std::vector<TomlValue> parts = value.items(2);
                          return Vec3(parts[0].number(), parts[1].number(), 0);
                      }).at(frame);
    return {pair.x, pair.y};
}

Rgb TomlValue::colourAt(double frame, const ColourConfig& config) const {
    return keysOf<Rgb>([&](const TomlValue& value) { return value.colour(config); }).at(frame);
}

Vec3 TomlValue::scaleAt(double frame) const {
    const Vec3 scale = keysOf<Vec3>([&](const TomlValue& value) {
                           return value.isNumber() ? Vec3(value.number()) : value.vec3();
                       }).at(frame);
    if (scale.x == 0 || scale.y == 0 || scale.z == 0)
        fail(fmt::format("'{}' is 0 at frame {}; expected {}", m_name, frame, m_key->form));
    return scale;
}

// ---- tables

TomlTable::TomlTable(const toml::table& table, std::string description, const Section* section)
    : m_table(&table), m_description(std::move(description)), m_section(section) {
    if (section == nullptr) return;
    for (const auto& [key, node] : table)
        for (const std::string& rival : section->rivalsOf(std::string(key.str()))) {
            const toml::node* other = table.get(rival);
            // The error is reported once, at the later of the two keys.
            if (other == nullptr || node.source().begin < other->source().begin) continue;
            throw Error(ErrorKind::input, fmt::format("{}: {} has both '{}' and '{}'; expected one of them",
                                                      whereOf(node.source()), m_description, rival, key.str()));
        }
}

void TomlTable::fail(const std::string& problem) const {
    throw Error(ErrorKind::input, fmt::format("{}: {}", where(), problem));
}

std::optional<TomlValue> TomlTable::find(const Key& key) {
    if (std::find(m_known.begin(), m_known.end(), key.name) == m_known.end()) m_known.push_back(key.name);
    const toml::node* node = m_table->get(key.name);
    if (node == nullptr) return std::nullopt;
    return TomlValue(*node, key.name, &key);
}

TomlValue TomlTable::require(const Key& key, const std::string& expected) {
    if (const auto value = find(key)) return *value;
    // If the table has a key that looks like a misspelling of this one, the message names it.
    for (const auto& [other, node] : *m_table) {
        const std::string name(other.str());
        const bool known = std::find(m_known.begin(), m_known.end(), name) != m_known.end();
        if (!known && nearestName(name, {key.name}) == key.name)
            throw Error(ErrorKind::input,
                        fmt::format("{}: '{}' is not known here ({}); did you mean '{}'?", whereOf(other.source()),
                                    shortened(name, 60), m_description, key.name));
    }
    fail(fmt::format("{} lacks {}; expected {}", m_description, key, expected.empty() ? key.form : expected));
}

std::vector<TomlTable> TomlTable::tables(const Key& key) {
    std::vector<TomlTable> out;
    const auto list = find(key);
    if (!list) return out;
    for (const TomlValue& item : list->items(0)) {
        if (!item.isTable()) item.failExpecting(key.form);
        out.push_back(item.table(fmt::format("[[{}]]", key.name)));
    }
    return out;
}

double TomlTable::number(const Key& key) {
    const auto value = find(key);
    return value ? value->number() : *key.value;
}

double TomlTable::numberAt(double frame, const Key& key) {
    const auto value = find(key);
    return value ? value->numberAt(frame) : *key.value;
}

int TomlTable::integer(const Key& key) {
    const auto value = find(key);
    return value ? value->integer() : static_cast<int>(*key.value);
}

bool TomlTable::boolean(const Key& key) {
    const auto value = find(key);
    return value ? value->boolean() : *key.value != 0;
}

std::string TomlTable::string(const Key& key) {
    const auto value = find(key);
    return value ? value->string() : "";
}

std::size_t TomlTable::choice(const Key& key) {
    const auto value = find(key);
    return value ? value->choice() : static_cast<std::size_t>(*key.value);
}

double TomlTable::plainValue(const Key& key, double frame) {
    if (key.isRequired || !key.value) require(key);
    switch (key.type) {
        case Key::Type::boolean:
            return boolean(key) ? 1 : 0;
        case Key::Type::integer:
            return integer(key);
        case Key::Type::choice:
            return static_cast<double>(choice(key));
        default:
            return key.isKeyed ? numberAt(frame, key) : number(key);
    }
}

std::vector<TomlValue> TomlTable::all() {
    std::vector<TomlValue> values;
    for (const auto& [key, node] : *m_table) {
        m_known.emplace_back(key.str());
        values.emplace_back(node, std::string(key.str()));
    }
    // The table is sorted by name, but people read lines in order. Overrides, which have no line, keep their order.
    std::stable_sort(values.begin(), values.end(), [this](const TomlValue& a, const TomlValue& b) {
        const auto begin = [this](const TomlValue& v) { return m_table->get(v.name())->source().begin; };
        return begin(a) < begin(b);
    });
    return values;
}

std::vector<std::string> TomlTable::known() const {
    if (m_section == nullptr) return m_known;
    std::vector<std::string> known;
    for (const Key& key : m_section->keys())
        if (std::find(m_known.begin(), m_known.end(), key.name) != m_known.end()) known.push_back(key.name);
    return known;
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
                            shortened(name, 60), m_description, didYouMean(name, known()), choices(known())));
}

}  // namespace scrim
