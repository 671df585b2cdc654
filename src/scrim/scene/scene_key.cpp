// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/scene_key.h>

#include <scrim/base/error.h>

#include <algorithm>
#include <cmath>
#include <utility>

namespace scrim {
namespace {

/// The largest coordinate or length, which is far beyond any scene.
constexpr double kFarthest = 1e15;

/// A limit as text: "1000000", but "1e+15".
std::string limitText(double v) {
    return std::abs(v) > 1e6 ? fmt::format("{:g}", v) : fmt::format("{}", v);
}

}  // namespace

bool Range::holds(double v) const {
    if (!std::isfinite(v)) return false;
    return (openLow ? v > low : v >= low) && (openHigh ? v < high : v <= high);
}

std::string Range::text() const {
    std::string text;
    const bool hasLow = std::isfinite(low), hasHigh = std::isfinite(high);
    if (hasLow && hasHigh && !openLow && !openHigh) {
        text = fmt::format(" from {} to {}", limitText(low), limitText(high));
    } else {
        if (hasLow) text += fmt::format(" {} {}", openLow ? "greater than" : "of at least", limitText(low));
        if (hasLow && hasHigh) text += " and";
        if (hasHigh) text += fmt::format(" {} {}", openHigh ? "less than" : "of at most", limitText(high));
    }
    if (unit.empty()) return text;
    return text + (hasLow || hasHigh ? " " : " of ") + unit;
}

Range Range::atLeast(double low, std::string unit) {
    return {low, std::numeric_limits<double>::infinity(), false, false, std::move(unit)};
}
Range Range::above(double low, std::string unit) {
    return {low, std::numeric_limits<double>::infinity(), true, false, std::move(unit)};
}
Range Range::fromTo(double low, double high, std::string unit) {
    return {low, high, false, false, std::move(unit)};
}
Range Range::between(double low, double high, std::string unit) {
    return {low, high, true, true, std::move(unit)};
}
Range Range::aboveTo(double low, double high, std::string unit) {
    return {low, high, true, false, std::move(unit)};
}
Range Range::coordinate() {
    return fromTo(-kFarthest, kFarthest, "world units");
}
Range Range::length() {
    return fromTo(0, kFarthest, "world units");
}
Range Range::positiveLength() {
    return aboveTo(0, kFarthest, "world units");
}

Key& Key::startingWith(const std::string& word) {
    value = static_cast<double>(std::find(words.begin(), words.end(), word) - words.begin());
    fallback = '"' + word + '"';
    return *this;
}

Key& Key::otherwise(int number) {
    value = number;
    fallback = fmt::format("{}", number);
    return *this;
}

Section::Section(std::string topic, std::string title, std::string meaning)
    : m_topic(std::move(topic)), m_title(std::move(title)), m_meaning(std::move(meaning)) {}

std::vector<std::string> Section::rivalsOf(const std::string& name) const {
    std::vector<std::string> rivals;
    for (const auto& [a, b] : m_rivals) {
        if (a == name) rivals.push_back(b);
        if (b == name) rivals.push_back(a);
    }
    return rivals;
}

void Section::exclude(const std::vector<const Key*>& some, const std::vector<const Key*>& others) {
    for (const Key* a : some)
        for (const Key* b : others) m_rivals.emplace_back(a->name, b->name);
}

Key& Section::add(Key::Type type, std::string name, std::string form, Range range, std::string meaning) {
    Key& key = m_keys.emplace_back();
    key.type = type;
    key.name = std::move(name);
    key.form = std::move(form);
    key.range = std::move(range);
    key.meaning = std::move(meaning);
    return key;
}

Key& Section::number(std::string name, Range range, std::optional<double> value, std::string meaning) {
    const std::string form = "a number" + range.text();
    Key& key = add(Key::Type::number, std::move(name), form, std::move(range), std::move(meaning));
    key.value = value;
    if (value) key.fallback = fmt::format("{}", *value);
    return key;
}

Key& Section::integer(std::string name, int low, int high, std::string unit, int value, std::string meaning) {
    Range range = Range::fromTo(low, high, std::move(unit));
    const std::string form = "a whole number" + range.text();
    Key& key = add(Key::Type::integer, std::move(name), form, std::move(range), std::move(meaning));
    key.value = value;
    key.fallback = fmt::format("{}", value);
    return key;
}

Key& Section::boolean(std::string name, bool value, std::string meaning) {
    Key& key = add(Key::Type::boolean, std::move(name), "true or false", {}, std::move(meaning));
    key.value = value ? 1 : 0;
    key.fallback = value ? "true" : "false";
    return key;
}

Key& Section::text(std::string name, std::string form, std::string meaning) {
    return add(Key::Type::text, std::move(name), std::move(form), {}, std::move(meaning));
}

Key& Section::path(std::string name, std::string form, std::string meaning) {
    return add(Key::Type::path, std::move(name), std::move(form), {}, std::move(meaning));
}

Key& Section::choice(std::string name, std::vector<std::string> words, std::string meaning) {
    Key& key = add(Key::Type::choice, std::move(name), choices(words), {}, std::move(meaning));
    key.words = std::move(words);
    return key.startingWith(key.words.front());
}

Key& Section::vector(std::string name, std::string form, Range range, std::string meaning) {
    return add(Key::Type::vector, std::move(name), std::move(form), std::move(range), std::move(meaning));
}

Key& Section::colour(std::string name, std::string fallback, std::string meaning) {
    Key& key = add(Key::Type::colour, std::move(name), kColourForm, Range::atLeast(0), std::move(meaning));
    key.fallback = std::move(fallback);
    return key;
}

Key& Section::table(const Section& section, std::string name, std::string meaning) {
    Key& key = add(Key::Type::table, std::move(name), "a table", {}, std::move(meaning));
    key.inner = &section;
    return key;
}

Key& Section::tables(const Section& section, std::string name, std::string meaning) {
    const std::string form = fmt::format("a list of tables, each written [[{}]]", name);
    Key& key = add(Key::Type::tables, std::move(name), form, {}, std::move(meaning));
    key.inner = &section;
    return key;
}

Key& Section::other(std::string name, std::string form, std::string schema, Range range, std::string meaning) {
    Key& key = add(Key::Type::other, std::move(name), std::move(form), std::move(range), std::move(meaning));
    key.schema = std::move(schema);
    return key;
}

}  // namespace scrim
