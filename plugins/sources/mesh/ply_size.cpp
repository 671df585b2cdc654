// SPDX-License-Identifier: Apache-2.0
#include "ply_size.h"

#include <array>
#include <cstdint>
#include <sstream>
#include <stdexcept>
#include <string_view>
#include <vector>

#include <fmt/format.h>

namespace mesh {
namespace {

/// A type of numbers by both of its names.
struct Type {
    std::string_view name, other;
    std::uint64_t bytes;
    bool whole;
};
constexpr std::array<Type, 8> kTypes{{{"char", "int8", 1, true},
                                      {"uchar", "uint8", 1, true},
                                      {"short", "int16", 2, true},
                                      {"ushort", "uint16", 2, true},
                                      {"int", "int32", 4, true},
                                      {"uint", "uint32", 4, true},
                                      {"float", "float32", 4, false},
                                      {"double", "float64", 8, false}}};

struct Property {
    const Type* count = nullptr;  ///< of a list: the type of its length; null: a single number
    const Type* value = nullptr;
};

struct Element {
    std::string name;
    std::uint64_t count = 0;
    std::vector<Property> properties;
};

[[noreturn]] void refuse(const std::string& reason) {
    throw std::runtime_error(reason);
}

const Type& typeCalled(const std::string& name) {
    for (const Type& type : kTypes)
        if (name == type.name || name == type.other) return type;
    refuse(
        fmt::format("its header has a property of type '{}', expected char, uchar, short, ushort, int, uint, float "
                    "or double",
                    name.substr(0, 40)));
}

struct Header {
    std::string format;
    std::vector<Element> elements;
    std::uint64_t end = 0;  ///< where the elements begin
};

Property propertyIn(std::istringstream& words) {
    Property property;
    std::string type, count;
    if (words >> type && type == "list") {
        words >> count >> type;
        property.count = &typeCalled(count);
        if (!property.count->whole) refuse("its header has a list whose length is no whole number");
    }
    property.value = &typeCalled(type);
    return property;
}

Header headerOf(const std::string& bytes) {
    constexpr std::string_view kEnd = "end_header";
    const std::size_t end = bytes.find(kEnd);
    if (!bytes.starts_with("ply") || end == std::string::npos) refuse("has no PLY header");
    Header header;
    header.end = end + kEnd.size();
    while (header.end < bytes.size() && bytes[header.end - 1] != '\n' && std::isspace(bytes[header.end]) != 0)
        ++header.end;
    std::istringstream text(bytes.substr(0, end));
    for (std::string line; std::getline(text, line);) {
        std::istringstream words(line);
        std::string word;
        words >> word;
        if (word == "format") words >> header.format;
        if (word == "element") {
            Element& element = header.elements.emplace_back();
            if (!(words >> element.name >> element.count) || element.count > bytes.size() - end - kEnd.size())
                refuse(fmt::format("declares more of '{}' than its {} bytes can hold", element.name.substr(0, 40),
                                   bytes.size()));
        }
        if (word != "property") continue;
        if (header.elements.empty()) refuse("its header has a property before the first element");
        header.elements.back().properties.push_back(propertyIn(words));
    }
    return header;
}

/// Walks binary elements.
class Walk {
  public:
    Walk(const std::string& bytes, const Header& header)
        : m_bytes(bytes), m_at(header.end), m_big(header.format == "binary_big_endian") {}

    void pass(const Element& element) {
        std::uint64_t fixed = 0;
        bool lists = false;
        for (const Property& property : element.properties) {
            fixed += property.count == nullptr ? property.value->bytes : 0;
            lists = lists || property.count != nullptr;
        }
        if (!lists) return skip(element.count * fixed, element);  // neither is more than the file's size
        for (std::uint64_t i = 0; i < element.count; ++i)
            for (const Property& property : element.properties)
                skip((property.count == nullptr ? 1 : number(*property.count, element)) * property.value->bytes,
                     element);
    }

  private:
    void skip(std::uint64_t bytes, const Element& element) {
        if (bytes > m_bytes.size() - m_at)
            refuse(fmt::format("is cut off: its {} bytes end before all of its {} '{}' elements", m_bytes.size(),
                               element.count, element.name.substr(0, 40)));
        m_at += bytes;
    }
    /// A list's length. A negative one becomes a large one, which no file holds.
    std::uint64_t number(const Type& type, const Element& element) {
        const std::uint64_t from = m_at;
        skip(type.bytes, element);
        std::uint64_t value = 0;
        for (std::uint64_t i = 0; i < type.bytes; ++i) {
            const std::uint64_t at = m_big ? from + i : from + type.bytes - 1 - i;
            value = value << 8 | static_cast<unsigned char>(m_bytes[at]);
        }
        return value;
    }

    const std::string& m_bytes;
    std::uint64_t m_at;
    bool m_big;
};

}  // namespace

void checkPlySize(const std::string& bytes) {
    const Header header = headerOf(bytes);
    if (header.format.starts_with("binary")) {
        Walk walk(bytes, header);
        for (const Element& element : header.elements) walk.pass(element);
        return;
    }
    const std::uint64_t rest = bytes.size() - header.end;
    std::uint64_t least = 0;
    for (const Element& element : header.elements) least += element.count * 2 * element.properties.size();
    if (least > rest + 1)  // the last separator may be missing
        refuse(fmt::format("has {} bytes after its header, which declares at least {}", rest, least));
}

}  // namespace mesh
