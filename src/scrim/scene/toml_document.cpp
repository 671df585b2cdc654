// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/toml_document.h>

#include <scrim/scene/scene_keys.h>
#include <scrim/scene/toml_text.h>

#include <scrim/base/error.h>

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <string_view>
#include <vector>

namespace scrim {
namespace {

// Limits on nesting. Each level costs the parser, and the destructor of its result, a few stack
// frames. Scenes need about five levels.
constexpr int kMostBrackets = 32;
constexpr int kMostKeyParts = 16;

constexpr std::string_view kOverride = "--set ";

/// The position after the string that begins at `i`: behind its closing quotes, or where the parser will give up.
std::size_t endOfString(const std::string& text, std::size_t i) {
    const char quote = text[i];
    const std::string three(3, quote);
    if (text.compare(i, 3, three) == 0) {
        for (i += 3; i < text.size(); ++i) {
            if (quote == '"' && text[i] == '\\')
                ++i;
            else if (text.compare(i, 3, three) == 0)
                return text.find_first_not_of(quote, i);
        }
        return text.size();
    }
    for (++i; i < text.size() && text[i] != '\n'; ++i) {
        if (quote == '"' && text[i] == '\\')
            ++i;
        else if (text[i] == quote)
            return i + 1;
    }
    return i;
}

/// Refuses text whose nesting would exhaust the parser's stack. It reads the text as TOML up to the
/// first mistake, where the parser stops, too.
void checkNesting(const std::string& text, const std::string& file) {
    int brackets = 0, keyParts = 1, line = 1;
    const auto refuse = [&](const std::string& problem) {
        const bool located = file.compare(0, kOverride.size(), kOverride) != 0;
        throw Error(ErrorKind::input,
                    fmt::format("{}: {}", located ? fmt::format("{}:{}:1", file, line) : file, problem));
    };
    for (std::size_t i = 0; i < text.size();) {
        const char c = text[i];
        if (c == '"' || c == '\'') {
            const std::size_t end = std::min(endOfString(text, i), text.size());
            line += static_cast<int>(std::count(text.begin() + static_cast<std::ptrdiff_t>(i),
                                                text.begin() + static_cast<std::ptrdiff_t>(end), '\n'));
            i = end;
            continue;
        }
        if (c == '#') {
            i = std::min(text.find('\n', i), text.size());
            continue;
        }
        if (c == '[' || c == '{') ++brackets;
        if (c == ']' || c == '}') --brackets;
        if (c == '.') ++keyParts;
        if (c == '\n') ++line;
        if (std::string_view("=,{}[]\n").find(c) != std::string_view::npos) keyParts = 1;
        if (brackets > kMostBrackets)
            refuse(fmt::format("more than {} brackets are open; a scene needs no more than a few", kMostBrackets));
        if (keyParts > kMostKeyParts)
            refuse(fmt::format("a key has more than {} parts; a scene needs no more than a few", kMostKeyParts));
        ++i;
    }
}

/// One part of an override's path: a key and the indices after it.
struct PathPart {
    std::string key;
    std::vector<std::size_t> indices;
};

class Override {
  public:
    explicit Override(const std::string& assignment) {
        // The first '=' outside of quotes ends the path.
        bool quoted = false;
        std::size_t equals = 0;
        for (; equals < assignment.size() && (quoted || assignment[equals] != '='); ++equals)
            if (assignment[equals] == '"') quoted = !quoted;
        m_path = trimmed(assignment.substr(0, equals));
        m_where = std::string(kOverride) + shortened(m_path, 120);
        if (!isUtf8(assignment)) fail("it is not UTF-8; scenes must be UTF-8 text");
        if (equals == assignment.size()) fail("there is no '='; expected key.path=value");
        m_value = trimmed(assignment.substr(equals + 1));
        splitPath();
    }

    void applyTo(toml::table& root) const {
        toml::table* table = &root;
        const Section* section = &keysOf<SceneKeys>();
        for (std::size_t i = 0; i < m_parts.size(); ++i) {
            const PathPart& part = m_parts[i];
            const bool last = i + 1 == m_parts.size();
            toml::node* node = table->get(part.key);
            if (last && part.indices.empty()) return put(*table, section, i);
            if (node == nullptr) {
                if (!part.indices.empty()) fail(fmt::format("there is no list '{}'", part.key));
                return put(*table, section, i);
            }
            section = sectionOf(section, part.key);
            for (std::size_t k = 0; k < part.indices.size(); ++k) {
                toml::array& list = listOf(*node, part.key);
                const std::size_t index = part.indices[k];
                if (index >= list.size())
                    fail(fmt::format("'{}' has {} elements, counted from 0", part.key, list.size()));
                if (last && k + 1 == part.indices.size()) return replace(list, index);
                node = list.get(index);
            }
            if (toml::array* list = node->as_array(); list != nullptr && part.indices.empty()) {
                node = elementNamed(*list, part.key, m_parts[++i]);
                if (i + 1 == m_parts.size()) fail("the path ends at a table; add the key to set");
            }
            table = node->as_table();
            if (table == nullptr) fail(fmt::format("'{}' is not a table", m_parts[i].key));
        }
    }

  private:
    std::string m_path, m_value, m_where;
    std::vector<PathPart> m_parts;

    [[noreturn]] void fail(const std::string& problem) const {
        throw Error(ErrorKind::input, fmt::format("{}: {}", m_where, shortened(problem)));
    }

    static std::string trimmed(const std::string& text) {
        const std::size_t first = text.find_first_not_of(" \t\r\n"), last = text.find_last_not_of(" \t\r\n");
        return first == std::string::npos ? "" : text.substr(first, last - first + 1);
    }

    void splitPath() {
        std::size_t i = 0;
        do {
            PathPart part;
            if (i < m_path.size() && m_path[i] == '"') {
                const std::size_t end = m_path.find('"', i + 1);
                if (end == std::string::npos) fail("a quote is not closed");
                part.key = m_path.substr(i + 1, end - i - 1);
                i = end + 1;
            } else {
                const std::size_t end = std::min(m_path.find_first_of(".[", i), m_path.size());
                part.key = m_path.substr(i, end - i);
                i = end;
                const bool bare = std::all_of(part.key.begin(), part.key.end(), [](char c) {
                    return c == '-' || c == '_' || (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') ||
                           (c >= 'a' && c <= 'z');
                });
                if (part.key.empty() || !bare)
                    fail(fmt::format("'{}' is not a key; expected letters, digits, '-' and '_', or anything in quotes",
                                     part.key));
            }
            while (i < m_path.size() && m_path[i] == '[') {
                std::size_t index = 0;
                const char* const end = m_path.data() + m_path.size();
                const auto [stop, error] = std::from_chars(m_path.data() + i + 1, end, index);
                if (error != std::errc() || stop == end || *stop != ']')
                    fail("'[' is not followed by an index (from 0) and ']'");
                part.indices.push_back(index);
                i = std::size_t(stop - m_path.data()) + 1;
            }
            if (m_parts.size() == std::size_t(kMostKeyParts))
                fail(fmt::format("the path has more than {} parts", kMostKeyParts));
            m_parts.push_back(std::move(part));
            if (i < m_path.size() && m_path[i] != '.') fail("a part of the path is not followed by '.' or '['");
        } while (i++ < m_path.size());
    }

    toml::array& listOf(toml::node& node, const std::string& key) const {
        toml::array* list = node.as_array();
        if (list == nullptr) fail(fmt::format("'{}' is not a list", key));
        return *list;
    }

    /// The element of a list of tables whose name `part` gives.
    toml::node* elementNamed(toml::array& list, const std::string& key, const PathPart& part) const {
        if (!list.is_array_of_tables())
            fail(fmt::format("'{}' is a list; write {}[0] for its first element", key, key));
        std::vector<std::string> names;
        for (std::size_t i = 0; i < list.size(); ++i) {
            const toml::table* table = list[i].as_table();
            const toml::node* name = table == nullptr ? nullptr : table->get("name");
            names.push_back(name != nullptr && name->is_string() ? name->as_string()->get()
                                                                 : fmt::format("{}{}", key, i + 1));
            if (table != nullptr && names.back() == part.key) {
                if (!part.indices.empty()) fail(fmt::format("'{}' is a table, not a list", part.key));
                return list.get(i);
            }
        }
        fail(fmt::format("there is no {} '{}'; expected {}", key, part.key, choices(names)));
    }

    /// The value as a tree under the key parts from `first` on; its nodes carry the override as their place.
    toml::table parsed(std::size_t first) const {
        std::string key;
        for (std::size_t i = first; i < m_parts.size(); ++i) {
            if (i > first && !m_parts[i].indices.empty()) fail(fmt::format("there is no list '{}'", m_parts[i].key));
            key += (i > first ? "." : "") + tomlString(m_parts[i].key);
        }
        // A value that begins like none of TOML's is a string. So is one that contains a '#' but starts with no quote
        // or bracket, since "smoke.####.vdb" and "12####.vdb" are file names, not values with comments.
        const bool delimited =
            !m_value.empty() && std::string_view("\"'[{").find(m_value.front()) != std::string_view::npos;
        if (delimited || (m_value.find('#') == std::string::npos && isToml(m_value)))
            return checked(parseToml(key + " = " + m_value, m_where));
        return parseToml(key + " = " + (isShellNumber(m_value) ? "0" + m_value : tomlString(m_value)), m_where);
    }

    /// True for numbers such as ".7", which TOML alone does not accept.
    static bool isShellNumber(const std::string& value) {
        return value.size() > 1 && value[0] == '.' && value.find_first_not_of("0123456789", 1) == std::string::npos;
    }

    static bool isToml(const std::string& value) {
        try {
            parseToml("value = " + value, "override");
            return true;
        } catch (const Error&) {
            return false;
        }
    }

    toml::table checked(toml::table table) const {
        if (table.size() != 1) fail("there is more than one value");
        return table;
    }

    /// The section that `key` of `section` leads to; null where there is none.
    static const Section* sectionOf(const Section* section, const std::string& key) {
        if (section == nullptr) return nullptr;
        for (const Key& known : section->keys())
            if (known.name == key) return known.inner;
        return nullptr;
    }

    /// Removes a key, and with a volume's source its parameters, unless an expression has some, too.
    static void erase(toml::table& table, const std::string& key) {
        const VolumeKeys& k = keysOf<VolumeKeys>();
        if (table.erase(key) > 0 && key == k.source.name && !table.contains(k.ax.name) &&
            !table.contains(k.axFile.name))
            table.erase(k.parameters.name);
    }

    /// Puts the value into `table` and removes the keys that would contradict it: whoever sets a
    /// lens wants no field of view.
    void put(toml::table& table, const Section* section, std::size_t first) const {
        toml::table value = parsed(first);
        if (section != nullptr)
            for (const std::string& rival : section->rivalsOf(m_parts[first].key)) erase(table, rival);
        const toml::key key = value.begin()->first;
        table.erase(key.str());
        value.begin()->second.visit([&](auto& node) { table.insert_or_assign(key, std::move(node)); });
    }

    void replace(toml::array& list, std::size_t index) const {
        toml::table value = parsed(m_parts.size() - 1);
        const auto place = list.cbegin() + static_cast<std::ptrdiff_t>(index);
        value.begin()->second.visit([&](auto& node) { list.replace(place, std::move(node)); });
    }
};

}  // namespace

std::string whereOf(const toml::source_region& region) {
    const std::string file = region.path ? *region.path : "scene";
    if (file.compare(0, kOverride.size(), kOverride) == 0) return file;
    return fmt::format("{}:{}:{}", file, region.begin.line, region.begin.column);
}

toml::table parseToml(const std::string& text, const std::string& file) {
    if (const std::size_t good = utf8Length(text); good < text.size()) {
        const std::size_t line =
            text.rfind('\n', good) == std::string::npos || good == 0 ? 0 : text.rfind('\n', good) + 1;
        throw Error(ErrorKind::input,
                    fmt::format("{}:{}:{}: the byte 0x{:02x} is not UTF-8; scenes must be UTF-8 text", file,
                                1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(good), '\n'),
                                1 + good - line, static_cast<unsigned char>(text[good])));
    }
    checkNesting(text, file);
    try {
        return toml::parse(text, file);
    } catch (const toml::parse_error& error) {
        throw Error(ErrorKind::input, fmt::format("{}: malformed TOML: {}", whereOf(error.source()),
                                                  shortened(error.description(), 200)));
    }
}

void applyOverride(toml::table& root, const std::string& assignment) {
    Override(assignment).applyTo(root);
}

}  // namespace scrim
