// SPDX-License-Identifier: Apache-2.0
// A key of a scene's table: its name, range, default, meaning, and the member that it sets. Reading a scene, checking
// one that was made in code, `scrim help`, examples/SCENES.md and the JSON schema all use it.
#pragma once

#include <scrim/scene/key_member.h>

#include <deque>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include <fmt/format.h>

namespace scrim {

/// The numbers that a key allows.
struct Range {
    double low = -std::numeric_limits<double>::infinity();
    double high = std::numeric_limits<double>::infinity();
    bool openLow = false, openHigh = false;  ///< the limit itself is excluded
    std::string unit;                        ///< "degrees"

    bool holds(double value) const;
    /// " from 0 to 180 degrees"; empty where all finite numbers are allowed.
    std::string text() const;

    static Range atLeast(double low, std::string unit = "");
    static Range above(double low, std::string unit = "");
    static Range fromTo(double low, double high, std::string unit = "");
    static Range between(double low, double high, std::string unit = "");  ///< excludes both limits
    static Range aboveTo(double low, double high, std::string unit = "");  ///< excludes the lower limit
    /// The range of coordinates and lengths in the world: their squares fit a double with room to spare.
    static Range coordinate();
    static Range length();  ///< 0 or more
    static Range positiveLength();
};

class Section;

struct Key {
    enum class Type { number, integer, boolean, text, path, choice, vector, colour, table, tables, other };

    std::string name;
    Type type = Type::other;
    Range range;                     ///< of the number, or of each number of a vector or list
    std::vector<std::string> words;  ///< the words of a choice
    std::string form;                ///< the form of a value, for messages and help: "a point [x, y, z]"
    std::optional<double> value;     ///< the default: a number, 0 or 1 for a boolean, or the index of a word
    std::string fallback;            ///< the default as text; empty: none, or the key is required
    std::string meaning;             ///< one or two sentences
    std::string only;                ///< the only case in which the key is known: "orthographic"
    bool isKeyed = false;            ///< the value may be { keys = [[frame, value], ...] }
    bool isRequired = false;
    const Section* inner = nullptr;  ///< the section of a table, also where a table is one of two forms
    std::string schema;              ///< JSON schema, for the type `other`
    KeyMember member;                ///< the member that it sets; none where that takes more than a number

    Key& keyed() { return isKeyed = true, *this; }
    Key& required() { return isRequired = true, *this; }
    Key& onlyFor(std::string what) { return only = std::move(what), *this; }
    Key& unless(std::string text) { return fallback = std::move(text), *this; }
    Key& startingWith(const std::string& word);                       ///< sets the default of a choice
    Key& otherwise(int number);                                       ///< sets the default of a whole number
    Key& needed() { return value.reset(), fallback.clear(), *this; }  ///< no default, in the case that knows the key
    Key& orTable(const Section& section) { return inner = &section, *this; }
};

/// A table of the scene with its keys, in the order in which help explains them.
class Section {
  public:
    Section(const Section&) = delete;
    Section& operator=(const Section&) = delete;

    const std::string& topic() const { return m_topic; }      ///< the name that `scrim help` takes: "slide"
    const std::string& title() const { return m_title; }      ///< "slide = { ... } of a [[light]]"
    const std::string& meaning() const { return m_meaning; }  ///< paragraphs of text
    const std::deque<Key>& keys() const { return m_keys; }
    /// The keys that cannot stand beside `name` in one table; --set of `name` removes them.
    std::vector<std::string> rivalsOf(const std::string& name) const;

  protected:
    Section(std::string topic, std::string title, std::string meaning);
    ~Section() = default;

    Key& number(std::string name, Range range, std::optional<double> value, std::string meaning);
    Key& integer(std::string name, int low, int high, std::string unit, int value, std::string meaning);
    Key& boolean(std::string name, bool value, std::string meaning);
    Key& text(std::string name, std::string form, std::string meaning);
    Key& path(std::string name, std::string form, std::string meaning);
    /// The first word is the default.
    Key& choice(std::string name, std::vector<std::string> words, std::string meaning);
    Key& vector(std::string name, std::string form, Range range, std::string meaning);  ///< three numbers
    Key& colour(std::string name, std::string fallback, std::string meaning);
    Key& table(const Section& section, std::string name, std::string meaning);
    Key& tables(const Section& section, std::string name, std::string meaning);
    /// A key of any other type: `schema` is its JSON schema, `range` that of each number in it.
    Key& other(std::string name, std::string form, std::string schema, Range range, std::string meaning);

    /// Declares that no key of `some` can stand beside a key of `others`.
    void exclude(const std::vector<const Key*>& some, const std::vector<const Key*>& others);

  private:
    Key& add(Key::Type type, std::string name, std::string form, Range range, std::string meaning);

    std::string m_topic, m_title, m_meaning;
    std::deque<Key> m_keys;
    std::vector<std::pair<std::string, std::string>> m_rivals;
};

/// A section whose keys set members of an Object. Their defaults are those of the Object, which states them alone.
template <typename Object>
class SectionOf : public Section {
  protected:
    using Section::boolean;
    using Section::choice;
    using Section::integer;
    using Section::number;

    SectionOf(std::string topic, std::string title, std::string meaning)
        : Section(std::move(topic), std::move(title), std::move(meaning)) {}

    // In place of the default, each of the following takes the member, as KeyMember does.
    template <MemberOf<Object> Member>
    Key& number(std::string name, Range range, Member member, std::string meaning) {
        const KeyMember bound = KeyMember::of<Object>(member);
        return with(bound, number(std::move(name), std::move(range), bound.get(Object()), std::move(meaning)));
    }
    template <MemberOf<Object> Member>
    Key& integer(std::string name, int low, int high, std::string unit, Member member, std::string meaning) {
        const KeyMember bound = KeyMember::of<Object>(member);
        const int value = static_cast<int>(bound.get(Object()));
        return with(bound, integer(std::move(name), low, high, std::move(unit), value, std::move(meaning)));
    }
    template <MemberOf<Object> Member>
    Key& boolean(std::string name, Member member, std::string meaning) {
        const KeyMember bound = KeyMember::of<Object>(member);
        return with(bound, boolean(std::move(name), bound.get(Object()) != 0, std::move(meaning)));
    }
    /// A boolean member is true at the word number `yes`.
    template <MemberOf<Object> Member>
    Key& choice(std::string name, std::vector<std::string> words, Member member, std::string meaning, int yes = 1) {
        const KeyMember bound = KeyMember::of<Object>(member, yes);
        const std::string word = words[static_cast<std::size_t>(bound.get(Object()))];
        return with(bound, choice(std::move(name), std::move(words), std::move(meaning)).startingWith(word));
    }

  private:
    static Key& with(const KeyMember& member, Key& key) { return key.member = member, key; }
};

/// The single object of each class of keys.
template <typename Keys>
const Keys& keysOf() {
    static const Keys keys;
    return keys;
}

// JSON schemas of values that are neither numbers nor tables.
inline constexpr const char* kTwoNumbersOrWord =
    R"({"type":["string","array"],"items":{"type":"number"},"minItems":2,"maxItems":2})";
inline constexpr const char* kTwoNumbers = R"({"type":"array","items":{"type":"number"},"minItems":2,"maxItems":2})";
inline constexpr const char* kColourForm =
    "a colour [r, g, b], each of at least 0, or { rgb = [r, g, b], colorspace = \"...\" }";
inline constexpr const char* kStrings = R"({"type":"array","items":{"type":"string"}})";
inline constexpr const char* kNumbers = R"({"type":["number","array"],"items":{"type":"number"}})";
inline constexpr const char* kMatrix = R"({"type":"array","minItems":4,"maxItems":4,"items":)"
                                       R"({"type":"array","items":{"type":"number"},"minItems":4,"maxItems":4}})";
inline constexpr const char* kPoints = R"({"type":"array","minItems":1,"items":)"
                                       R"({"type":"array","items":{"type":"number"},"minItems":2,"maxItems":2}})";
inline constexpr const char* kAnyTable = R"({"type":"object"})";

/// The largest count of pixels along an edge, and the largest file number.
inline constexpr int kMostPixels = 65536, kLastFrame = 1'000'000'000;

}  // namespace scrim

/// Formats a key in messages as its name in quotes.
template <>
struct fmt::formatter<scrim::Key> : fmt::formatter<std::string> {
    template <typename Context>
    auto format(const scrim::Key& key, Context& context) const {
        return fmt::formatter<std::string>::format("'" + key.name + "'", context);
    }
};
