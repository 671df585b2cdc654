// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/scene_help.h>

#include <scrim/scene/scene_keys.h>

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <sstream>

namespace scrim {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::size_t kWidth = 100, kIndent = 4;

/// Limits this large are not worth printing: nobody meets them.
bool unlimited(double limit) {
    return std::abs(limit) >= 1e6;
}

/// A range as text: "0 to 180 degrees", "above 0 mm", "world units".
std::string rangeText(const Range& range) {
    const bool low = !unlimited(range.low), high = !unlimited(range.high);
    std::string text;
    if (low) text += fmt::format("{}{:g}", range.openLow ? "above " : high ? "" : "at least ", range.low);
    const char* const upTo = range.openHigh          ? (low ? " and below " : "below ")
                             : low && !range.openLow ? " to "
                                                     : "up to ";
    if (high) text += fmt::format("{}{}{:g}", low && range.openLow && !range.openHigh ? ", " : "", upTo, range.high);
    if (!range.unit.empty()) text += (text.empty() ? "" : " ") + range.unit;
    return text;
}

std::string formText(const Key& key) {
    switch (key.type) {
        case Key::Type::number:
            return rangeText(key.range).empty() ? "a number" : "a number, " + rangeText(key.range);
        case Key::Type::integer:
            return "a whole number, " + rangeText(key.range);
        case Key::Type::colour:
            return key.inner == nullptr ? "a colour [r, g, b]" : "a colour [r, g, b], or a table";
        case Key::Type::text:
        case Key::Type::path:
        case Key::Type::choice:
        case Key::Type::boolean:
        case Key::Type::table:
        case Key::Type::tables:
            return key.form;
        case Key::Type::vector:
        case Key::Type::other:
            break;
    }
    const std::string range = rangeText(key.range);
    return range.empty() ? key.form : fmt::format("{}; {}", key.form, range);
}

std::string fallbackText(const Key& key) {
    if (key.isRequired) return "needed";
    return key.fallback.empty() ? "" : "default " + key.fallback;
}

std::string wrapped(const std::string& text, std::size_t indent) {
    std::string out;
    std::size_t column = 0;
    std::istringstream words(text);
    for (std::string word; words >> word;) {
        const bool fits = column > 0 && column + 1 + word.size() <= kWidth;
        if (!fits) {
            if (column > 0) out += '\n';
            out.append(indent, ' ');
            column = indent;
        } else {
            out += ' ';
            ++column;
        }
        out += word;
        column += word.size();
    }
    out += '\n';
    return out;
}

std::string keyHelp(const Key& key) {
    std::string head = fmt::format("  {}{}: {}", key.name, key.isKeyed ? " *" : "", formText(key));
    if (!key.only.empty()) head += fmt::format("; only with {}", key.only);
    if (const std::string fallback = fallbackText(key); !fallback.empty()) head += "; " + fallback;
    std::string meaning = key.meaning;
    if (key.inner != nullptr) meaning += fmt::format(" See: scrim help {}.", key.inner->topic());
    return head + '\n' + wrapped(meaning, kIndent + 2);
}

std::string sectionHelp(const Section& section) {
    std::string text = section.title() + "\n\n" + wrapped(section.meaning(), 2) + '\n';
    bool keyed = false;
    for (const Key& key : section.keys()) {
        text += keyHelp(key);
        keyed = keyed || key.isKeyed;
    }
    if (keyed) text += "\n  * may be keyed: scrim help keys\n";
    return text;
}

/// The help about the keys that "camera.fov" or "fov" names.
std::string keysNamed(const std::string& topic) {
    const std::size_t dot = topic.rfind('.');
    const std::string name = dot == std::string::npos ? topic : topic.substr(dot + 1);
    const std::string of = dot == std::string::npos ? "" : topic.substr(0, dot);
    std::string text;
    for (const Section* section : sceneSections()) {
        if (!of.empty() && of != section->topic() && !of.ends_with("." + section->topic())) continue;
        for (const Key& key : section->keys())
            if (key.name == name) text += fmt::format("{}\n{}", section->title(), keyHelp(key));
    }
    return text;
}

/// `text` escaped for a cell of a Markdown table.
std::string cell(const std::string& text) {
    std::string out;
    for (const char c : text) {
        if (c == '|') out += '\\';
        out += c;
    }
    return out;
}

Json keySchema(const Key& key);

Json sectionSchema(const Section& section) {
    Json properties = Json::object(), required = Json::array();
    for (const Key& key : section.keys()) {
        properties[key.name] = keySchema(key);
        if (key.isRequired) required.push_back(key.name);
    }
    Json schema{{"type", "object"}, {"description", section.meaning()}, {"properties", properties}};
    if (!required.empty()) schema["required"] = required;
    schema["additionalProperties"] = false;
    return schema;
}

Json numberSchema(const Range& range, const char* type) {
    Json schema{{"type", type}};
    if (std::isfinite(range.low)) schema[range.openLow ? "exclusiveMinimum" : "minimum"] = range.low;
    if (std::isfinite(range.high)) schema[range.openHigh ? "exclusiveMaximum" : "maximum"] = range.high;
    return schema;
}

Json reference(const std::string& topic) {
    return {{"$ref", "#/$defs/" + topic}};
}

Json formSchema(const Key& key) {
    const Json triple{
        {"type", "array"}, {"items", numberSchema(key.range, "number")}, {"minItems", 3}, {"maxItems", 3}};
    switch (key.type) {
        case Key::Type::number:
            return numberSchema(key.range, "number");
        case Key::Type::integer:
            return numberSchema(key.range, "integer");
        case Key::Type::boolean:
            return {{"type", "boolean"}};
        case Key::Type::text:
        case Key::Type::path:
            return {{"type", "string"}, {"minLength", 1}};
        case Key::Type::choice:
            return {{"enum", key.words}};
        case Key::Type::vector:
            return triple;
        case Key::Type::colour:
            return {{"anyOf", {triple, reference(keysOf<ColourKeys>().topic())}}};
        case Key::Type::table:
            return reference(key.inner->topic());
        case Key::Type::tables:
            return {{"type", "array"}, {"items", reference(key.inner->topic())}};
        case Key::Type::other:
            break;
    }
    return Json::parse(key.schema);
}

Json keySchema(const Key& key) {
    Json forms = Json::array({formSchema(key)});
    const bool isTable = key.type == Key::Type::table || key.type == Key::Type::tables;
    if (key.inner != nullptr && !isTable && key.type != Key::Type::other)
        forms.push_back(reference(key.inner->topic()));
    if (key.isKeyed) forms.push_back(reference(keysOf<KeyedKeys>().topic()));
    Json schema = forms.size() == 1 ? forms.front() : Json{{"anyOf", forms}};
    std::string description = key.meaning;
    if (const std::string fallback = fallbackText(key); !fallback.empty()) description += " (" + fallback + ")";
    schema["description"] = description;
    return schema;
}

void addPaths(const Section& section, const std::string& prefix, std::vector<std::string>& paths) {
    for (const Key& key : section.keys()) {
        const bool isList = key.type == Key::Type::tables;
        if (!isList && key.type != Key::Type::table) paths.push_back(prefix + key.name);
        if (isList || key.type == Key::Type::table)
            addPaths(*key.inner, prefix + key.name + (isList ? "[0]." : "."), paths);
    }
}

}  // namespace

std::vector<std::string> sceneTopics() {
    std::vector<std::string> topics;
    for (const Section* section : sceneSections()) topics.push_back(section->topic());
    return topics;
}

std::string sceneHelp(const std::string& topic) {
    for (const Section* section : sceneSections())
        if (section->topic() == topic) return sectionHelp(*section);
    return keysNamed(topic);
}

std::string scenesAsMarkdown() {
    std::string text =
        "# Scenes\n\nAll sections and keys of a scene. Printed by `scrim help --markdown`; `scrim help camera` prints "
        "a section, `scrim help camera.fov` a key, and `scrim help --schema` a JSON schema for editors.\n";
    for (const Section* section : sceneSections()) {
        text += fmt::format("\n## {}\n\n{}\n",
                            section == sceneSections().front() ? "Top level" : "`" + section->title() + "`",
                            section->meaning());
        text += "\n| key | what | without it | meaning |\n| --- | --- | --- | --- |\n";
        for (const Key& key : section->keys()) {
            const std::string only = key.only.empty() ? "" : fmt::format(" Only with {}.", key.only);
            const std::string fallback = key.isRequired         ? "needed"
                                         : key.fallback.empty() ? ""
                                                                : "`" + key.fallback + "`";
            text += fmt::format("| `{}`{} | {} | {} | {}{} |\n", key.name, key.isKeyed ? " *" : "", cell(formText(key)),
                                cell(fallback), cell(key.meaning), only);
        }
    }
    return text;
}

std::string roffText(const std::string& text) {
    std::string out;
    bool startsLine = true;
    for (const char c : text) {
        // At the start of a line these characters would begin a roff request.
        if (startsLine && (c == '.' || c == '\'')) out += "\\&";
        if (c == '\\') {
            out += "\\e";
        } else {
            // An unescaped one may be typeset as a hyphen, which shells do not understand when it is pasted.
            if (c == '-') out += '\\';
            out += c;
        }
        startsLine = c == '\n';
    }
    return out;
}

std::string scenesAsRoff() {
    std::string text;
    for (const Section* section : sceneSections()) {
        text += fmt::format(".SH \"{}\"\n{}\n",
                            section == sceneSections().front() ? "TOP LEVEL" : roffText(section->title()),
                            roffText(section->meaning()));
        for (const Key& key : section->keys()) {
            text += fmt::format(".TP\n\\fB{}\\fR{}\n{}", roffText(key.name), key.isKeyed ? " *" : "",
                                roffText(formText(key)));
            if (!key.only.empty()) text += "; only with " + roffText(key.only);
            if (const std::string fallback = fallbackText(key); !fallback.empty()) text += "; " + roffText(fallback);
            text += ".\n.br\n" + roffText(key.meaning) + "\n";
        }
    }
    return text;
}

std::string sceneSchema() {
    Json schema{{"$schema", "https://json-schema.org/draft/2020-12/schema"}, {"title", "Scrim scene"}};
    schema.update(sectionSchema(*sceneSections().front()));
    Json& definitions = schema["$defs"] = Json::object();
    for (const Section* section : sceneSections())
        if (section != sceneSections().front()) definitions[section->topic()] = sectionSchema(*section);
    return schema.dump(2) + '\n';
}

std::vector<std::string> scenePaths() {
    std::vector<std::string> paths;
    addPaths(*sceneSections().front(), "", paths);
    return paths;
}

}  // namespace scrim
