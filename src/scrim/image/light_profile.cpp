// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/light_profile.h>

#include <scrim/base/error.h>
#include <scrim/base/open_file.h>
#include <scrim/base/system_error.h>

#include <fmt/format.h>
#include <glm/trigonometric.hpp>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cmath>
#include <numeric>
#include <optional>
#include <stdexcept>

#include <unistd.h>

namespace scrim {
namespace {

// A defect of the text, which is reported with path and line.
using Defect = std::runtime_error;

// The words of the text, one after another. Commas part numbers as spaces do.
class Words {
  public:
    explicit Words(std::string_view text) : m_text(text) {}

    int line() const { return m_line; }

    // The rest of the line, without spaces at its ends; none at the end of the text.
    std::optional<std::string_view> restOfLine() {
        if (m_at >= m_text.size()) return std::nullopt;
        if (m_ended) ++m_line;
        const std::size_t end = std::min(m_text.find_first_of("\r\n", m_at), m_text.size());
        const std::string_view rest = m_text.substr(m_at, end - m_at);
        m_at = end;
        if (m_at < m_text.size()) m_at += m_text.substr(m_at, 2) == "\r\n" ? 2 : 1;
        m_ended = true;
        const std::size_t from = rest.find_first_not_of(" \t");
        return from == std::string_view::npos ? std::string_view()
                                              : rest.substr(from, rest.find_last_not_of(" \t") - from + 1);
    }

    // Throws where there is no number, or one that is not finite.
    double number(const std::string& what) {
        const std::string_view word = next();
        if (word.empty()) throw Defect(fmt::format("the file ends before {}", what));
        double value = 0;
        const char* first = word.data() + (word.front() == '+' ? 1 : 0);
        const auto [end, error] = std::from_chars(first, word.data() + word.size(), value);
        if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value))
            throw Defect(fmt::format("'{}' is not a number; expected {}", shortened(word, 40), what));
        return value;
    }

    int whole(const std::string& what, int least, std::size_t most) {
        const double value = number(what);
        if (value != std::floor(value) || value < least || value > double(most))
            throw Defect(fmt::format("{:g}; expected {}, a whole number from {} to {}", value, what, least, most));
        return static_cast<int>(value);
    }

    // The next word; "" at the end. A control-Z ends texts of old systems.
    std::string_view next() {
        if (m_ended) {
            ++m_line;
            m_ended = false;
        }
        while (m_at < m_text.size() && isSpace(m_text[m_at])) {
            if (m_text[m_at] == '\n' || (m_text[m_at] == '\r' && m_text.substr(m_at, 2) != "\r\n")) ++m_line;
            ++m_at;
        }
        const std::size_t from = m_at;
        while (m_at < m_text.size() && !isSpace(m_text[m_at])) ++m_at;
        return m_text.substr(from, m_at - from);
    }

  private:
    static bool isSpace(char c) { return c == ' ' || c == ',' || c == '\x1a' || (c >= '\t' && c <= '\r'); }

    std::string_view m_text;
    std::size_t m_at = 0;
    int m_line = 1;
    bool m_ended = false;  // the line that was read as a whole counts until something after it is read
};

std::vector<float> numbers(Words& words, int count, const std::string& what) {
    std::vector<float> values;
    for (int i = 0; i < count; ++i)
        values.push_back(static_cast<float>(words.number(fmt::format("{} {} of {}", what, i + 1, count))));
    return values;
}

std::vector<float> angles(Words& words, int count, const std::string& what, float least, float most) {
    std::vector<float> values;
    for (int i = 0; i < count; ++i) {
        const auto angle = static_cast<float>(words.number(fmt::format("{} {} of {}", what, i + 1, count)));
        if (!(angle >= least && angle <= most))
            throw Defect(
                fmt::format("{} {} is {:g}; expected one from {:g} to {:g} degrees", what, i + 1, angle, least, most));
        if (!values.empty() && angle <= values.back())
            throw Defect(
                fmt::format("{} {} is {:g}, after {:g}; expected ascending angles", what, i + 1, angle, values.back()));
        values.push_back(angle);
    }
    return values;
}

// Reads up to the line TILT=, and the factors that may follow it.
void readTilt(Words& words) {
    for (auto line = words.restOfLine(); line; line = words.restOfLine()) {
        if (!line->starts_with("TILT")) continue;
        const std::size_t from = line->find_first_not_of(" \t=", 4);
        const std::string_view tilt = from == std::string_view::npos ? "" : line->substr(from);
        if (tilt == "NONE") return;
        if (tilt != "INCLUDE") throw Defect(fmt::format("TILT={}; expected NONE or INCLUDE", shortened(tilt, 60)));
        words.whole("how the lamp lies in the luminaire", 1, 3);
        const int pairs = words.whole("the number of tilt angles", 1, kMostProfileAngles);
        angles(words, pairs, "tilt angle", 0, 180);
        numbers(words, pairs, "tilt factor");
        return;
    }
    throw Defect("the file ends before a line TILT=; expected a photometric file (IES LM-63)");
}

// Horizontal angles as LM-63 has them: what they leave out follows by symmetry.
void checkHorizontal(const std::vector<float>& h) {
    if (h.size() == 1) return;
    const float first = h.front(), last = h.back();
    if ((first == 0 && (last == 90 || last >= 180)) || (first == 90 && last == 270)) return;
    throw Defect(fmt::format(
        "horizontal angles from {:g} to {:g}; expected 0, 0 to 90, 0 to 180, 90 to 270 or 0 to 360", first, last));
}

void readCandelas(Words& words, double factor, FilePhotometry& out) {
    out.candela.reserve(out.horizontal.size() * out.vertical.size());
    double most = 0;
    for (std::size_t h = 0; h < out.horizontal.size(); ++h)
        for (std::size_t v = 0; v < out.vertical.size(); ++v) {
            const std::size_t count = out.horizontal.size() * out.vertical.size();
            const double candela =
                words.number(fmt::format("candela value {} of {}", out.candela.size() + 1, count)) * factor;
            if (candela < 0) throw Defect(fmt::format("a candela value of {:g}; expected 0 or more", candela / factor));
            if (!(candela <= double(kMostCandela)))
                throw Defect(fmt::format("a candela value of {:g} is too large", candela));
            most = std::max(most, candela);
            out.candela.push_back(static_cast<float>(candela));
        }
    if (!(most > 0)) throw Defect("all candela values are 0");
    if (const std::string_view rest = words.next(); !rest.empty())
        throw Defect(
            fmt::format("'{}' after the last candela value; expected the end of the file", shortened(rest, 40)));
}

void readAll(Words& words, FilePhotometry& out) {
    readTilt(words);
    words.whole("the number of lamps", 1, 1'000'000);
    words.number("the lumens of a lamp");
    const double multiplier = words.number("the multiplier of candela values");
    if (!(multiplier > 0 && multiplier <= 1e12))
        throw Defect(fmt::format("a multiplier of {:g}; expected one above 0", multiplier));
    const int vertical = words.whole("the number of vertical angles", 2, kMostProfileAngles);
    const int horizontal = words.whole("the number of horizontal angles", 1, kMostProfileAngles);
    if (std::size_t(vertical) * std::size_t(horizontal) > kMostCandelas)
        throw Defect(fmt::format("{} x {} candela values; expected at most {}", vertical, horizontal, kMostCandelas));
    const int type = words.whole("the photometric type", 1, 3);
    if (type != 1)
        throw Defect(fmt::format("photometric type {} ({}); expected 1, type C", type, type == 2 ? "B" : "A"));
    words.whole("the unit of lengths", 1, 2);
    for (const char* what : {"the width", "the length", "the height"}) words.number(what);
    for (const char* what : {"the ballast factor", "the ballast-lamp factor", "the watts"}) words.number(what);
    out.vertical = angles(words, vertical, "vertical angle", 0, 180);
    out.horizontal = angles(words, horizontal, "horizontal angle", 0, 360);
    checkHorizontal(out.horizontal);
    readCandelas(words, multiplier, out);
}

// The part of [values[i], values[i + 1]] at which `x` lies; `x` is clamped to all of them.
struct Between {
    std::size_t index;
    double part;
};

Between between(const std::vector<float>& values, double x) {
    if (values.size() == 1) return {0, 0};
    const auto above = std::upper_bound(values.begin() + 1, values.end() - 1, x);
    const std::size_t i = static_cast<std::size_t>(above - values.begin()) - 1;
    return {i, std::clamp((x - double(values[i])) / double(values[i + 1] - values[i]), 0.0, 1.0)};
}

// The candela value of the file at these angles.
double candelaAt(const FilePhotometry& file, double vertical, double horizontal) {
    const double last = double(file.horizontal.back());
    if (file.horizontal.front() == 90 && file.horizontal.size() > 1) {
        if (horizontal < 90) horizontal = 180 - horizontal;
        if (horizontal > 270) horizontal = 540 - horizontal;
    } else {
        if (last <= 180 && horizontal > 180) horizontal = 360 - horizontal;
        if (last <= 90 && horizontal > 90) horizontal = 180 - horizontal;
    }
    const Between v = between(file.vertical, vertical);
    const auto column = [&](std::size_t h) {
        const float* values = file.candela.data() + h * file.vertical.size() + v.index;
        return double(values[0]) + v.part * double(values[1] - values[0]);
    };
    if (horizontal > last && file.horizontal.size() > 1)  // of all directions but 360 degrees, which is 0
        return column(file.horizontal.size() - 1) +
               (horizontal - last) / (360 - last) * (column(0) - column(file.horizontal.size() - 1));
    const Between h = between(file.horizontal, horizontal);
    const double begin = column(h.index);
    return h.part == 0 ? begin : begin + h.part * (column(h.index + 1) - begin);
}

// The number of equal steps over `range` degrees that meet all angles, so that values between them
// are exact; steps of `least` degrees where that would take finer ones.
int stepsOver(const std::vector<float>& angles, double range, double least) {
    constexpr double kUnits = 100;  // per degree
    long step = std::lround(range * kUnits);
    for (const float angle : angles) {
        const double units = double(angle) * kUnits;
        if (std::abs(units - std::round(units)) > 1e-3 * kUnits) return static_cast<int>(range / least);
        step = std::gcd(step, std::lround(units));
    }
    return static_cast<int>(range / std::max(double(step) / kUnits, least));
}

}  // namespace

FilePhotometry parsePhotometry(std::string_view text, const std::string& path) {
    FilePhotometry out;
    Words words(text);
    try {
        readAll(words, out);
    } catch (const Defect& defect) {
        return {{}, {}, {}, fmt::format("{}:{}: {}", path, words.line(), defect.what())};
    }
    return out;
}

FilePhotometry readPhotometry(const std::string& path, int descriptor) {
    const auto refused = [&](const std::string& why) {
        return FilePhotometry{{}, {}, {}, fmt::format("{}: {}", path, why)};
    };
    std::optional<OpenFile> own;
    if (descriptor < 0) {
        own.emplace(path);
        if (!own->problem().empty()) return refused(own->problem());
        descriptor = own->fd();
    }
    std::string text;
    std::array<char, 1 << 16> part;
    for (;;) {
        const ssize_t got = ::read(descriptor, part.data(), part.size());
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) return refused(systemErrorText(errno));
        if (got == 0) break;
        text.append(part.data(), static_cast<std::size_t>(got));
        if (text.size() > kMostProfileBytes)
            return refused(
                fmt::format("larger than {}; expected a photometric file (IES LM-63)", bytesText(kMostProfileBytes)));
    }
    return parsePhotometry(text, path);
}

LightProfile::LightProfile(const FilePhotometry& file)
    : m_rows(stepsOver(file.vertical, 180, 0.25) + 1),
      m_columns(file.horizontal.size() == 1 ? 2 : stepsOver(file.horizontal, 360, 0.5) + 1),
      m_first(file.vertical.front()),
      m_last(file.vertical.back()) {
    const double most = *std::max_element(file.candela.begin(), file.candela.end());
    for (int row = 0; row < m_rows; ++row)
        for (int column = 0; column < m_columns; ++column)
            m_values.push_back(static_cast<float>(
                candelaAt(file, 180.0 * row / (m_rows - 1), 360.0 * column / (m_columns - 1)) / most));
    for (std::size_t i = 0; i < file.candela.size(); ++i)
        if (const std::size_t v = i % file.vertical.size(); file.candela[i] > 0)
            m_reach = std::max(m_reach, double(file.vertical[std::min(v + 1, file.vertical.size() - 1)]));
}

double LightProfile::at(const Vec3& direction) const {
    const double vertical = glm::degrees(std::acos(std::clamp(direction.z, -1.0, 1.0)));
    constexpr double kRounding = 1e-4;  // degrees
    if (vertical < m_first - kRounding || vertical > m_last + kRounding) return 0;
    double horizontal = glm::degrees(std::atan2(direction.x, -direction.y));
    if (horizontal < 0) horizontal += 360;
    const double y = vertical / 180 * (m_rows - 1), x = horizontal / 360 * (m_columns - 1);
    const int row = std::min(static_cast<int>(y), m_rows - 2), column = std::min(static_cast<int>(x), m_columns - 2);
    const float* corner = m_values.data() + std::size_t(row) * std::size_t(m_columns) + std::size_t(column);
    const double right = x - column;
    const auto across = [&](const float* p) { return double(p[0]) + right * double(p[1] - p[0]); };
    const double above = across(corner);
    return above + (y - row) * (across(corner + m_columns) - above);
}

}  // namespace scrim
