// SPDX-License-Identifier: Apache-2.0
#include "shape_list.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

#include <fmt/format.h>
#include <glm/geometric.hpp>

namespace primitives {
namespace {

constexpr std::string_view kBlank = " \t\r";
constexpr double kLargest = 1e9;  ///< largest number allowed; larger ones lose their voxels to rounding
constexpr std::size_t kMostShapes = 100000;

/// "a, b or c".
std::string choices(const std::vector<std::string_view>& names) {
    std::string text;
    for (std::size_t i = 0; i < names.size(); ++i)
        text += fmt::format("{}'{}'", i == 0 ? "" : i + 1 == names.size() ? " or " : ", ", names[i]);
    return text;
}

/// The pieces of `text` between characters of `separators`, including empty ones.
std::vector<std::string_view> split(std::string_view text, std::string_view separators) {
    std::vector<std::string_view> pieces;
    for (;;) {
        const std::size_t end = text.find_first_of(separators);
        pieces.push_back(text.substr(0, end));
        if (end == std::string_view::npos) return pieces;
        text.remove_prefix(end + 1);
    }
}

bool parseNumber(std::string_view text, double& value) {
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error == std::errc() && stop == text.data() + text.size() && std::abs(value) <= kLargest;
}

/// The words of one shape. Reading a key removes it, so that what is left at the end is unknown.
class Entry {
  public:
    Entry(std::size_t number, const std::vector<std::string_view>& words)
        : m_where(fmt::format("shape {}", number)), m_kind(words[0]) {
        if (m_kind.find('=') != std::string_view::npos)
            fail(fmt::format("'{}': expected a kind of shape before its keys", m_kind.substr(0, 80)));
        for (std::size_t i = 1; i < words.size(); ++i) {
            const std::size_t equals = words[i].find('=');
            if (equals == std::string_view::npos || equals == 0)
                fail(fmt::format("'{}': expected key=value without blanks", words[i].substr(0, 80)));
            const std::string_view key = words[i].substr(0, equals);
            if (find(key) != m_values.size()) fail(fmt::format("'{}' is given twice", key.substr(0, 80)));
            m_values.emplace_back(key, words[i].substr(equals + 1));
        }
    }

    std::string_view kind() const { return m_kind; }
    void nameKind() { m_where += fmt::format(" ({})", m_kind); }

    [[noreturn]] void fail(const std::string& reason) const { throw std::runtime_error(m_where + ": " + reason); }

    bool has(std::string_view key) const { return find(key) != m_values.size(); }

    /// The number of a key; `fallback` where it is missing. Without a fallback the key is required.
    double number(std::string_view key, double least, const char* expected, const double* fallback = nullptr) {
        if (!has(key) && fallback != nullptr) return know(key), *fallback;
        const std::string_view text = take(key, expected);
        double value = 0;
        if (!parseNumber(text, value) || value < least) refuse(key, text, expected);
        return value;
    }
    Vec3 vec3(std::string_view key, const char* expected, const Vec3* fallback = nullptr) {
        if (!has(key) && fallback != nullptr) return know(key), *fallback;
        const std::string_view text = take(key, expected);
        const auto parts = split(text, ",");
        Vec3 value(0);
        if (parts.size() != 3) refuse(key, text, expected);
        for (int k = 0; k < 3; ++k)
            if (!parseNumber(parts[static_cast<std::size_t>(k)], value[k])) refuse(key, text, expected);
        return value;
    }
    std::string text(std::string_view key, const char* fallback, const char* expected) {
        if (!has(key)) return know(key), fallback;
        const std::string_view value = take(key, expected);
        if (value.empty()) refuse(key, value, expected);
        return std::string(value);
    }
    [[noreturn]] void refuse(std::string_view key, std::string_view text, const char* expected) const {
        fail(fmt::format("'{}' is '{}', expected {}", key, text.substr(0, 80), expected));
    }

    void finish() const {
        if (!m_values.empty())
            fail(fmt::format("unknown key '{}', expected {}", m_values[0].first.substr(0, 80), choices(m_known)));
    }

  private:
    std::size_t find(std::string_view key) const {
        const auto found =
            std::find_if(m_values.begin(), m_values.end(), [&](const auto& v) { return v.first == key; });
        return static_cast<std::size_t>(found - m_values.begin());
    }
    void know(std::string_view key) { m_known.push_back(key); }
    std::string_view take(std::string_view key, const char* expected) {
        know(key);
        const std::size_t i = find(key);
        if (i == m_values.size()) fail(fmt::format("lacks '{}', expected {}", key, expected));
        const std::string_view value = m_values[i].second;
        m_values.erase(m_values.begin() + static_cast<std::ptrdiff_t>(i));
        return value;
    }

    std::string m_where;
    std::string_view m_kind;
    std::vector<std::pair<std::string_view, std::string_view>> m_values;
    std::vector<std::string_view> m_known;
};

constexpr const char* kPlace = "three numbers such as 0,1.5,0";
constexpr const char* kPositive = "a number above 0";
constexpr const char* kNotNegative = "a number of at least 0";
constexpr const char* kExtents = "three numbers above 0 such as 1,2,0.5";
constexpr double kSmallest = 1e-12;  ///< smallest number that counts as above 0
const Vec3 kOrigin(0), kUp(0, 1, 0);
const double kZero = 0, kOne = 1;

double positive(Entry& e, std::string_view key) {
    return e.number(key, kSmallest, kPositive);
}

Vec3 extents(Entry& e, std::string_view key) {
    const Vec3 v = e.vec3(key, kExtents);
    if (!(v.x >= kSmallest && v.y >= kSmallest && v.z >= kSmallest))
        e.refuse(key, fmt::format("{},{},{}", v.x, v.y, v.z), kExtents);
    return v;
}

Vec3 direction(Entry& e, std::string_view key) {
    constexpr const char* kExpected = "a direction such as 0,1,0";
    const Vec3 v = e.vec3(key, kExpected, &kUp);
    if (!(glm::length(v) >= kSmallest)) e.refuse(key, fmt::format("{},{},{}", v.x, v.y, v.z), kExpected);
    return v;
}

/// Reads the radius of rounded edges, limited to what fits.
void readRound(Entry& e, Shape& s) {
    s.round = e.number("round", 0, kNotNegative, &kZero);
    const double most = std::min({s.half.x, s.half.y, s.half.z});
    if (s.round > most)
        e.fail(fmt::format("'round' is {}, expected at most {}, half of the least extent", s.round, most));
}

void readBox(Entry& e, Shape& s) {
    s.wsCentre = e.vec3("center", kPlace, &kOrigin);
    s.half = 0.5 * extents(e, "size");
    readRound(e, s);
}

void readSphere(Entry& e, Shape& s) {
    s.wsCentre = e.vec3("center", kPlace, &kOrigin);
    s.half = Vec3(positive(e, "radius"));
}

void readEllipsoid(Entry& e, Shape& s) {
    s.wsCentre = e.vec3("center", kPlace, &kOrigin);
    s.half = 0.5 * extents(e, "size");
}

/// Reads a cylinder or capsule, from the centre of one end to that of the other.
void readRod(Entry& e, Shape& s) {
    const Vec3 from = e.vec3("from", kPlace), to = e.vec3("to", kPlace);
    const double radius = positive(e, "radius"), length = glm::length(to - from);
    if (!(length >= kSmallest)) e.fail("'from' and 'to' are the same point");
    s.wsCentre = 0.5 * (from + to);
    s.wsFromLocal = rotationFromY(to - from);
    const bool capsule = s.kind == Kind::capsule;
    s.half = Vec3(radius, 0.5 * length + (capsule ? radius : 0), radius);
    if (!capsule) readRound(e, s);
}

void readTorus(Entry& e, Shape& s) {
    s.wsCentre = e.vec3("center", kPlace, &kOrigin);
    s.wsFromLocal = rotationFromY(direction(e, "axis"));
    const double radius = positive(e, "radius");
    s.round = positive(e, "tube");
    s.half = Vec3(radius + s.round, s.round, radius + s.round);
}

/// Reads a plane: a thin box below its surface.
void readPlane(Entry& e, Shape& s) {
    const Vec3 surface = e.vec3("center", kPlace, &kOrigin), normal = direction(e, "normal");
    constexpr const char* kExpected = "two numbers above 0 such as 10,10";
    const std::string size = e.text("size", "", kExpected);
    const auto parts = split(size, ",");
    double width = 0, depth = 0;
    if (size.empty()) e.fail(fmt::format("lacks 'size', expected {}", kExpected));
    if (parts.size() != 2 || !parseNumber(parts[0], width) || !parseNumber(parts[1], depth) || width < kSmallest ||
        depth < kSmallest)
        e.refuse("size", size, kExpected);
    const double thickness = positive(e, "thickness");
    s.kind = Kind::box;
    s.half = 0.5 * Vec3(width, thickness, depth);
    s.wsFromLocal = rotationFromY(normal);
    s.wsCentre = surface - 0.5 * thickness * s.wsFromLocal[1];
}

struct KindReader {
    std::string_view name;
    Kind kind;
    void (*read)(Entry&, Shape&);
};
constexpr std::array<KindReader, 7> kKinds{{{"box", Kind::box, readBox},
                                            {"sphere", Kind::sphere, readSphere},
                                            {"ellipsoid", Kind::ellipsoid, readEllipsoid},
                                            {"cylinder", Kind::cylinder, readRod},
                                            {"capsule", Kind::capsule, readRod},
                                            {"torus", Kind::torus, readTorus},
                                            {"plane", Kind::box, readPlane}}};

Shape parseShape(Entry entry) {
    const auto* found =
        std::find_if(kKinds.begin(), kKinds.end(), [&](const KindReader& k) { return k.name == entry.kind(); });
    if (found == kKinds.end()) {
        std::vector<std::string_view> names;
        for (const KindReader& k : kKinds) names.push_back(k.name);
        entry.fail(fmt::format("unknown kind '{}', expected {}", entry.kind().substr(0, 80), choices(names)));
    }
    entry.nameKind();
    Shape shape;
    shape.kind = found->kind;
    found->read(entry, shape);
    shape.wsFromLocal = rotationFromDegrees(entry.vec3("rotate", kPlace, &kOrigin)) * shape.wsFromLocal;
    shape.density = entry.number("density", 0, kNotNegative, &kOne);
    shape.soft = entry.number("soft", 0, kNotNegative, &kZero);
    shape.grid = entry.text("grid", "density", "the name of a grid");
    entry.finish();
    return shape;
}

}  // namespace

std::vector<Shape> parseShapes(std::string_view text) {
    std::vector<Shape> shapes;
    for (std::string_view line : split(text, "\n")) {
        line = line.substr(0, line.find('#'));  // the rest is a comment
        for (const std::string_view piece : split(line, ";")) {
            std::vector<std::string_view> words = split(piece, kBlank);
            std::erase_if(words, [](std::string_view word) { return word.empty(); });
            if (words.empty()) continue;
            shapes.push_back(parseShape(Entry(shapes.size() + 1, words)));
            if (shapes.size() > kMostShapes)
                throw std::runtime_error(fmt::format("'shapes' lists more than {} shapes", kMostShapes));
        }
    }
    if (shapes.empty())
        throw std::runtime_error("'shapes' lists none, expected some such as 'box size=1,1,1; sphere radius=0.7'");
    return shapes;
}

}  // namespace primitives
