// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/source_parameters.h>

#include <scrim/base/error.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string_view>

#include <fmt/format.h>

namespace scrim {

namespace {

std::string_view trimmed(std::string_view text) {
    const auto blank = [](char c) { return c == ' ' || c == '\t'; };
    while (!text.empty() && blank(text.front())) text.remove_prefix(1);
    while (!text.empty() && blank(text.back())) text.remove_suffix(1);
    return text;
}

/// Parses all of `text` as a number.
template <typename T>
bool parse(std::string_view text, T& value) {
    text = trimmed(text);
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && stop == text.data() + text.size();
}

bool parseFinite(std::string_view text, double& value) {
    return parse(text, value) && std::isfinite(value);
}

/// Parses "x, y, z", with or without brackets around it.
bool parseVec3(std::string_view text, double* value) {
    text = trimmed(text);
    if (text.size() >= 2 && text.front() == '[' && text.back() == ']') text = text.substr(1, text.size() - 2);
    for (int i = 0; i < 3; ++i) {
        const std::size_t comma = text.find(',');
        if ((comma == std::string_view::npos) != (i == 2)) return false;
        if (!parseFinite(text.substr(0, comma), value[i])) return false;
        text.remove_prefix(comma == std::string_view::npos ? text.size() : comma + 1);
    }
    return true;
}

std::string expectation(const ParameterDescription& d) {
    switch (d.type) {
        case ParameterType::number:
            return "a number such as 0.5";
        case ParameterType::integer:
            return "a whole number such as 12";
        case ParameterType::vec3:
            return "three numbers such as 0, 1.5, 0";
        case ParameterType::boolean:
            return "true or false";
        case ParameterType::string:
            break;
    }
    return choices(d.choices);
}

scrim_value parseValue(const ParameterDescription& d, const std::string& text, const std::string& where,
                       std::deque<std::string>& texts) {
    scrim_value value{};
    value.type = static_cast<std::int32_t>(d.type);
    bool good = true;
    bool inRange = true;
    const auto limit = [&](double v) { inRange = inRange && (!d.limited() || (v >= d.minimum && v <= d.maximum)); };
    switch (d.type) {
        case ParameterType::number:
            good = parseFinite(text, value.number[0]);
            limit(value.number[0]);
            break;
        case ParameterType::integer:
            good = parse(text, value.integer);
            limit(static_cast<double>(value.integer));
            break;
        case ParameterType::vec3:
            good = parseVec3(text, value.number);
            for (const double v : value.number) limit(v);
            break;
        case ParameterType::boolean:
            good = text == "true" || text == "false";
            value.boolean = text == "true";
            break;
        case ParameterType::string:
            good = d.choices.empty() || std::find(d.choices.begin(), d.choices.end(), text) != d.choices.end();
            value.text = texts.emplace_back(text).c_str();
            break;
    }
    if (!good)
        throw Error(ErrorKind::input, fmt::format("{}: parameter '{}' is '{}', expected {}", where, d.name,
                                                  shortened(text, 80), expectation(d)));
    if (!inRange)
        throw Error(ErrorKind::input, fmt::format("{}: parameter '{}' is {}, expected {} to {}", where, d.name,
                                                  shortened(text, 80), d.minimum, d.maximum));
    return value;
}

}  // namespace

std::string typeName(ParameterType type) {
    switch (type) {
        case ParameterType::number:
            return "number";
        case ParameterType::integer:
            return "integer";
        case ParameterType::vec3:
            return "vec3";
        case ParameterType::string:
            return "string";
        case ParameterType::boolean:
            break;
    }
    return "bool";
}

ParameterValues parseParameters(const std::vector<ParameterDescription>& descriptions, const SourceParameters& given,
                                const std::string& where) {
    std::vector<const std::string*> texts(descriptions.size(), nullptr);
    for (const auto& [key, text] : given) {
        const auto found = std::find_if(descriptions.begin(), descriptions.end(),
                                        [&key = key](const auto& d) { return d.name == key; });
        if (found == descriptions.end()) {
            std::vector<std::string> names;
            for (const auto& d : descriptions) names.push_back(d.name);
            throw Error(ErrorKind::input, fmt::format("{}: unknown parameter '{}', expected {}", where,
                                                      shortened(key, 80), choices(names)));
        }
        const std::string*& place = texts[found - descriptions.begin()];
        if (place != nullptr)
            throw Error(ErrorKind::input, fmt::format("{}: parameter '{}' is given twice", where, key));
        place = &text;
    }
    ParameterValues out;
    for (std::size_t i = 0; i < descriptions.size(); ++i) {
        const ParameterDescription& d = descriptions[i];
        out.values.push_back(parseValue(d, texts[i] != nullptr ? *texts[i] : d.defaultText, where, out.texts));
    }
    return out;
}

}  // namespace scrim
