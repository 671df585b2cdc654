// SPDX-License-Identifier: Apache-2.0
// Internal: reads checked values out of TOML. A TomlValue knows where it stands and what it is called, so
// every complaint about it is made here, in the same words. A TomlTable remembers which keys it was asked
// for: in the end nobody may have written another one.
#pragma once

#include <scrim/geometry/spaces.h>
#include <scrim/image/colour.h>
#include <scrim/scene/keyed.h>
#include <scrim/scene/toml_document.h>

#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace scrim {

/// What a number may be.
struct Range {
    double low = -std::numeric_limits<double>::infinity();
    double high = std::numeric_limits<double>::infinity();
    bool openLow = false, openHigh = false;  ///< the limit itself is not allowed
    std::string unit;                        ///< "degrees"

    static Range atLeast(double low, std::string unit = "");
    static Range above(double low, std::string unit = "");
    static Range fromTo(double low, double high, std::string unit = "");
    static Range between(double low, double high, std::string unit = "");  ///< without its limits
    /// Coordinates and lengths in the world: their squares fit a double with room to spare.
    static Range coordinate();
    static Range length();  ///< 0 or more
    static Range positiveLength();
};

class TomlTable;

class TomlValue {
  public:
    TomlValue(const toml::node& node, std::string name) : m_node(&node), m_name(std::move(name)) {}

    std::string where() const { return whereOf(m_node->source()); }
    const std::string& name() const { return m_name; }
    bool isString() const { return m_node->is_string(); }
    bool isBoolean() const { return m_node->is_boolean(); }
    bool isNumber() const { return m_node->is_number(); }
    bool isArray() const { return m_node->is_array(); }
    bool isTable() const { return m_node->is_table(); }

    double number(const Range& range = {}) const;
    int integer(int low, int high, const std::string& unit = "") const;
    bool boolean() const;
    std::string string() const;  ///< not empty
    /// The place of the word in `words`.
    std::size_t choice(const std::vector<std::string>& words) const;
    Vec3 vec3(const Range& range = {}) const;
    /// "three numbers": what `items` must be, for messages. `count` 0: any number.
    std::vector<TomlValue> items(std::size_t count, const std::string& expected) const;
    /// [r, g, b], not negative, in the working space, or { rgb, colorspace }.
    Rgb colour(const ColourConfig& config) const;
    TomlTable table(std::string description) const;

    /// Each of these may be keyed: { keys = [[frame, value], ...], interpolation }.
    double numberAt(double frame, const Range& range = {}) const;
    Vec3 vec3At(double frame, const Range& range = {}) const;
    Rgb colourAt(double frame, const ColourConfig& config) const;
    Vec3 scaleAt(double frame) const;  ///< a number or three, none of them 0

    [[noreturn]] void fail(const std::string& problem) const;            ///< "where: problem"
    [[noreturn]] void failExpecting(const std::string& expected) const;  ///< "where: 'x' is ...; expected ..."

  private:
    template <typename T>
    T keyedAt(double frame, const std::function<T(const TomlValue&)>& read) const;

    const toml::node* m_node;
    std::string m_name;  ///< "fov", "position[1]"
};

class TomlTable {
  public:
    /// `description` is for messages: "[camera]".
    TomlTable(const toml::table& table, std::string description);

    std::string where() const { return whereOf(m_table->source()); }
    const std::string& description() const { return m_description; }
    /// Says more of the table, once it is known: "[camera] of type 'perspective'".
    void describe(std::string description) { m_description = std::move(description); }

    /// The value of `key`, which is thereby known.
    std::optional<TomlValue> find(std::string_view key);
    /// Throws where it is missing; `expected` says what it would be.
    TomlValue require(std::string_view key, const std::string& expected);
    /// [[key]]: its tables, each called "[[key]]".
    std::vector<TomlTable> tables(std::string_view key);

    double number(std::string_view key, double fallback, const Range& range = {});
    int integer(std::string_view key, int fallback, int low, int high, const std::string& unit = "");
    bool boolean(std::string_view key, bool fallback);
    std::string string(std::string_view key, std::string fallback);
    std::size_t choice(std::string_view key, const std::vector<std::string>& words, std::size_t fallback);
    double numberAt(double frame, std::string_view key, double fallback, const Range& range = {});

    /// All values in the order they are written in; all keys are thereby known.
    std::vector<TomlValue> all();

    /// Throws at the first key that nobody asked for.
    void finish() const;

    [[noreturn]] void fail(const std::string& problem) const;  ///< "where: problem"

  private:
    const toml::table* m_table;
    std::string m_description;
    std::vector<std::string> m_known;
};

}  // namespace scrim
