// SPDX-License-Identifier: Apache-2.0
// Internal: reads checked values out of TOML. A TomlValue knows its place in the text and its name,
// so that every error about it is reported here in the same words. A TomlTable remembers which keys
// it was asked for; finish() then refuses any other key.
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

/// A place in a file; "" where the text does not come from a file.
struct TextPlace {
    std::string file;
    int line = 1, column = 1;
};

class TomlValue {
  public:
    /// `key` states what the value may be; null: anything.
    TomlValue(const toml::node& node, std::string name, const Key* key = nullptr)
        : m_node(&node), m_name(std::move(name)), m_key(key) {}

    std::string where() const { return whereOf(m_node->source()); }
    const std::string& name() const { return m_name; }
    bool isString() const { return m_node->is_string(); }
    bool isBoolean() const { return m_node->is_boolean(); }
    bool isNumber() const { return m_node->is_number(); }
    bool isArray() const { return m_node->is_array(); }
    bool isTable() const { return m_node->is_table(); }

    /// Each value is checked against its key's range unless a range is passed. Items of a list have
    /// the key of the list.
    double number() const;
    double number(const Range& range) const;
    int integer() const;
    bool boolean() const;
    std::string string() const;  ///< never empty
    /// The place of a string's first character, behind its quotes. It is exact for strings without escapes.
    TextPlace textPlace() const;
    /// The index of the word in the key's `words`, or in `words`.
    std::size_t choice() const;
    std::size_t choice(const std::vector<std::string>& words) const;
    Vec3 vec3() const;
    /// The items of a list of `count` values (0: of any number). The error about any other value says `expected`.
    std::vector<TomlValue> items(std::size_t count, const std::string& expected) const;
    std::vector<TomlValue> items(std::size_t count) const;
    /// Reads [r, g, b], not negative, in the working space, or { rgb, colorspace }, which is converted to it.
    Rgb colour(const ColourConfig& config) const;
    /// Throws where two keys of the table exclude one another.
    TomlTable table(std::string description) const;  ///< a table of the section that the key leads to
    TomlTable table(std::string description, const Section* section) const;

    /// Each of the following accepts a keyed value: { keys = [[frame, value], ...], interpolation }.
    double numberAt(double frame) const;
    Vec3 vec3At(double frame) const;
    Vec2 pairAt(double frame) const;  ///< two numbers
    Rgb colourAt(double frame, const ColourConfig& config) const;
    Vec3 scaleAt(double frame) const;  ///< one number or three, none of them 0
    /// The keys as written, frames ascending. A value without keys becomes a single key, which holds for all frames.
    template <typename T>
    Keyed<T> keysOf(const std::function<T(const TomlValue&)>& read) const;

    [[noreturn]] void fail(const std::string& problem) const;            ///< throws "where: problem"
    [[noreturn]] void failExpecting(const std::string& expected) const;  ///< throws "where: 'x' is ...; expected ..."

  private:
    const toml::node* m_node;
    std::string m_name;  ///< "fov", "position[1]"
    const Key* m_key;
};

class TomlTable {
  public:
    /// `description` names the table in messages: "[camera]". Throws where two keys exclude one
    /// another by `section`; null: none do.
    TomlTable(const toml::table& table, std::string description, const Section* section = nullptr);

    std::string where() const { return whereOf(m_table->source()); }
    const std::string& description() const { return m_description; }
    /// Extends the description once more is known: "[camera] of type 'perspective'".
    void describe(std::string description) { m_description = std::move(description); }

    /// The value of `key`. The key is known from now on.
    std::optional<TomlValue> find(const Key& key);
    /// The value of `key`. Throws where it is missing; the message says `expected` in place of the key's form.
    TomlValue require(const Key& key, const std::string& expected = "");
    /// The tables of [[key]], each of which messages call "[[key]]".
    std::vector<TomlTable> tables(const Key& key);

    // Each of the following returns the value of `key`, or the key's default where it is missing.
    double number(const Key& key);
    double numberAt(double frame, const Key& key);
    int integer(const Key& key);
    bool boolean(const Key& key);
    std::string string(const Key& key);  ///< "" where it is missing
    std::size_t choice(const Key& key);

    /// Sets the members of `object` that keys of `section` set, each to the key's value, at `frame` where it is keyed,
    /// or to its default. Keys that are known in some cases only are left out: see below.
    template <typename Object>
    void read(const SectionOf<Object>& section, double frame, Object& object) {
        for (const Key& key : section.keys())
            if (key.member && key.only.empty()) read(key, frame, object);
    }
    /// The same for one key. Throws where it has no default and is missing.
    template <typename Object>
    void read(const Key& key, double frame, Object& object) {
        key.member.set(object, plainValue(key, frame));
    }

    /// All values in the order of the text. All keys are known from now on.
    std::vector<TomlValue> all();

    /// Throws at the first key that nobody asked for.
    void finish() const;

    [[noreturn]] void fail(const std::string& problem) const;  ///< "where: problem"

  private:
    /// A number, 0 or 1, or the index of a word.
    double plainValue(const Key& key, double frame);
    /// The keys that were asked for, in the order of the section.
    std::vector<std::string> known() const;

    const toml::table* m_table;
    std::string m_description;
    const Section* m_section;
    std::vector<std::string> m_known;
};

template <typename T>
Keyed<T> TomlValue::keysOf(const std::function<T(const TomlValue&)>& read) const {
    Keyed<T> keyed;
    // A table without `keys` may itself be a value that `read` accepts: a colour with its space.
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
