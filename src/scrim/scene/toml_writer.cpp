// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/toml_writer.h>

#include <scrim/scene/toml_text.h>

#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <string_view>

namespace scrim {
namespace {

constexpr std::size_t kWidth = 100;  // of a list, beyond which each of its items gets a line of its own

std::string keyText(std::string_view key) {
    const bool bare = !key.empty() && std::all_of(key.begin(), key.end(), [](char c) {
        return c == '-' || c == '_' || (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z');
    });
    return bare ? std::string(key) : tomlString(std::string(key));
}

/// A float of TOML, which has a point or an exponent; without them it would be an integer.
std::string numberText(double value) {
    const std::string text = fmt::format("{}", value);
    return text.find_first_not_of("-0123456789") == std::string::npos ? text + ".0" : text;
}

std::string valueText(const toml::node& node);

std::string listText(const toml::array& list) {
    std::string text, lines;
    for (const toml::node& item : list) {
        const std::string one = valueText(item);
        text += (text.empty() ? "" : ", ") + one;
        lines += "    " + one + ",\n";
    }
    return text.size() <= kWidth ? "[" + text + "]" : "[\n" + lines + "]";
}

std::string inlineText(const toml::table& table) {
    std::string text;
    for (const auto& [key, node] : table)
        text += fmt::format("{} {} = {}", text.empty() ? "" : ",", keyText(key.str()), valueText(node));
    return text.empty() ? "{}" : "{" + text + " }";
}

std::string valueText(const toml::node& node) {
    if (const auto* text = node.as_string()) return tomlString(text->get());
    if (const auto* number = node.as_floating_point()) return numberText(number->get());
    if (const auto* number = node.as_integer()) return fmt::format("{}", number->get());
    if (const auto* yes = node.as_boolean()) return yes->get() ? "true" : "false";
    if (const auto* list = node.as_array()) return listText(*list);
    if (const auto* table = node.as_table()) return inlineText(*table);
    std::ostringstream time;
    if (const auto* date = node.as_date()) time << date->get();
    if (const auto* hour = node.as_time()) time << hour->get();
    if (const auto* both = node.as_date_time()) time << both->get();
    return time.str();
}

bool isSection(const toml::node& node) {
    const toml::table* const table = node.as_table();
    return table != nullptr && !table->is_inline();
}

/// True for a list that is written as sections [[key]].
bool isSections(const toml::node& node) {
    const toml::array* const list = node.as_array();
    return list != nullptr && list->is_array_of_tables() && isSection(*list->get(0));
}

class Writer {
  public:
    /// Writes the keys of `table`, whose own header is written: values first, since a header ends them.
    void add(const toml::table& table, const std::string& path) {
        for (const auto& [key, node] : table)
            if (!isSection(node) && !isSections(node))
                m_text += fmt::format("{} = {}\n", keyText(key.str()), valueText(node));
        for (const auto& [key, node] : table) {
            const std::string inner = path + (path.empty() ? "" : ".") + keyText(key.str());
            if (isSection(node)) addSection(*node.as_table(), inner);
            if (!isSections(node)) continue;
            for (const toml::node& item : *node.as_array()) addUnder("[[" + inner + "]]", *item.as_table(), inner);
        }
    }
    const std::string& text() const { return m_text; }

  private:
    /// A table of tables alone needs no header of its own.
    void addSection(const toml::table& table, const std::string& path) {
        const bool onlyTables = !table.empty() && std::all_of(table.begin(), table.end(), [](const auto& pair) {
            return isSection(pair.second) || isSections(pair.second);
        });
        if (onlyTables) return add(table, path);
        addUnder("[" + path + "]", table, path);
    }
    void addUnder(const std::string& header, const toml::table& table, const std::string& path) {
        m_text += (m_text.empty() ? "" : "\n") + header + '\n';
        add(table, path);
    }

    std::string m_text;
};

}  // namespace

std::string tomlText(const toml::table& root) {
    Writer writer;
    writer.add(root, "");
    return writer.text();
}

}  // namespace scrim
