// SPDX-License-Identifier: Apache-2.0
// Internal: reads checked values out of TOML. A TomlValue knows where it stands and what it is called, so
// every complaint about it is made here, in the same words. A TomlTable remembers which keys it was asked
// for: in the end nobody may have written another one.
#pragma once

#include <scrim/geometry/spaces.h>
#include <scrim/image/colour.h>
#include <scrim/scene/keyed.h>
#include <scrim/scene/scene_keys.h>
#include <scrim/scene/toml_document.h>

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace scrim {

class TomlTable;

class TomlValue {
  public:
    /// `key` says what it may be; null: anything.
    TomlValue(const toml::node& node, std::string name, const Key* key = nullptr)
        : m_node(&node), m_name(std::move(name)), m_key(key) {}

    std::string where() const { return whereOf(m_node->source()); }
    const std::string& name() const { return m_name; }
    bool isString() const { return m_node->is_string(); }
    bool isBoolean() const { return m_node->is_boolean(); }
    bool isNumber() const { return m_node->is_number(); }
    bool isArray() const { return m_node->is_array(); }
    bool isTable() const { return m_node->is_table(); }

    /// What is allowed is the key's business unless it is said here. Items of a list have the key of the list.
    double number() const;
    double number(const Range& range) const;
    int integer() const;
    bool boolean() const;
    std::string string() const;  ///< not empty
    /// The place of the word in the key's `words`, or in those given.
    std::size_t choice() const;
    std::size_t choice(const std::vector<std::string>& words) const;
    Vec3 vec3() const;
    /// A list of `count` (0: of any number); `expected` is said where it is none.
    std::vector<TomlValue> items(std::size_t count, const std::string& expected) const;
    std::vector<TomlValue> items(std::size_t count) const;
    /// [r, g, b], not negative, in the working space, or { rgb, colorspace }.
    Rgb colour(const ColourConfig& config) const;
    /// Throws where keys of it exclude one another.
    TomlTable table(std::string description) const;  ///< of the section that the key leads to
    TomlTable table(std::string description, const Section* section) const;

    /// Each of these may be keyed: { keys = [[frame, value], ...], interpolation }.
    double numberAt(double frame) const;
    Vec3 vec3At(double frame) const;
    Vec2 pairAt(double frame) const;  ///< two numbers
    Rgb colourAt(double frame, const ColourConfig& config) const;
    Vec3 scaleAt(double frame) const;  ///< a number or three, none of them 0
    /// The keys as they are, frames ascending; one for all frames where there are none.
    template <typename T>
    Keyed<T> keysOf(const std::function<T(const TomlValue&)>& read) const;

    [[noreturn]] void fail(const std::string& problem) const;            ///< "where: problem"
    [[noreturn]] void failExpecting(const std::string& expected) const;  ///< "where: 'x' is ...; expected ..."

  private:
    const toml::node* m_node;
    std::string m_name;  ///< "fov", "position[1]"
    const Key* m_key;
};

class TomlTable {
  public:
    /// `description` is for messages: "[camera]". Throws where keys of `section` exclude one another; null: none do.
    TomlTable(const toml::table& table, std::string description, const Section* section = nullptr);

    std::string where() const { return whereOf(m_table->source()); }
    const std::string& description() const { return m_description; }
    /// Says more of the table, once it is known: "[camera] of type 'perspective'".
    void describe(std::string description) { m_description = std::move(description); }

    /// The value of `key`, which is thereby known here.
    std::optional<TomlValue> find(const Key& key);
    /// Throws where it is missing; `expected` says what it would be, in place of the key's form.
    TomlValue require(const Key& key, const std::string& expected = "");
    /// [[key]]: its tables, each called "[[key]]".
    std::vector<TomlTable> tables(const Key& key);

    // The value of `key`, or what it is without one.
    double number(const Key& key);
    double numberAt(double frame, const Key& key);
    int integer(const Key& key);
    bool boolean(const Key& key);
    std::string string(const Key& key);  ///< "" without one
    std::size_t choice(const Key& key);

    /// All values in the order they are written in; all keys are thereby known.
    std::vector<TomlValue> all();

    /// Throws at the first key that nobody asked for.
    void finish() const;

    [[noreturn]] void fail(const std::string& problem) const;  ///< "where: problem"

  private:
    /// The keys that somebody asked for, in the order of the section.
    std::vector<std::string> known() const;

    const toml::table* m_table;
    std::string m_description;
    const Section* m_section;
    std::vector<std::string> m_known;
};

template <typename T>
Keyed<T> TomlValue::keysOf(const std::function<T(const TomlValue&)>& read) const {
    Keyed<T> keyed;
    // A table without keys may be what `read` expects: a colour with its space.
    const KeyedKeys& k = scrim::keysOf<KeyedKeys>();
    if (!isTable() || m_node->as_table()->get(k.keys.name) == nullptr) {
        keyed.keys.emplace_back(0, read(*this));
        return keyed;
    }
    TomlTable table = this->table(fmt::format("the keyed '{}'", m_name), &k);
    const TomlValue list = table.require(k.keys);
    keyed.interpolation = static_cast<Interpolation>(table.choice(k.interpolation));
    table.finish();
    for (const TomlValue& item : list.items(0)) {
        const std::vector<TomlValue> pair = item.items(2, "[frame, value]");
        const double at = pair[0].number();
        if (!keyed.keys.empty() && at <= keyed.keys.back().first)
            pair[0].fail(fmt::format("'{}': frame {} does not come after frame {}; expected ascending frames", m_name,
                                     at, keyed.keys.back().first));
        keyed.keys.emplace_back(at, read(TomlValue(*pair[1].m_node, pair[1].m_name, m_key)));
    }
    if (keyed.keys.empty()) list.failExpecting("at least one [frame, value]");
    return keyed;
}

}  // namespace scrim
