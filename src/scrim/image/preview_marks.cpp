// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/preview_marks.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <glm/geometric.hpp>

namespace scrim {
namespace {

struct Line {
    Vec2 from, to;
    Rgb color;
};

// Letters are strokes between the points of a grid, 3 wide and 5 high:
//     a b c
//     d e f
//     g h i
//     j k l
//     m n o
// The strokes of a letter are apart by spaces.
std::string_view strokesOf(char letter) {
    switch (letter) {
        case '0':
            return "acoma";
        case '1':
            return "dbn";
        case '2':
            return "acigmo";
        case '3':
            return "acom gi";
        case '4':
            return "agi co";
        case '5':
            return "cagiom";
        case '6':
            return "camoig";
        case '7':
            return "acn";
        case '8':
            return "acoma gi";
        case '9':
            return "igacom";
        case '.':
            return "nn";
        case '-':
            return "gi";
        case '+':
            return "gi ek";
        case 'e':
            return "gifdmo";
        case 'x':
            return "go im";
        case 'y':
            return "gn im";
        case 'z':
            return "gimo";
        default:
            return "";
    }
}

Vec2 gridPoint(char name) {
    const int at = name - 'a';
    return {at % 3, at / 3};
}

class Drawing {
  public:
    explicit Drawing(DisplayImage& picture)
        : m_picture(picture),
          m_unit(std::max(1.0, std::min(picture.window.width(), picture.window.height()) / 360.0)) {}

    // Pixels that are about as wide in pictures of any size.
    double unit() const { return m_unit; }

    void line(const Vec2& from, const Vec2& to, const Rgb& color = Rgb(1)) { m_lines.push_back({from, to, color}); }

    // Half of a text's width, pixels.
    double halfOf(const std::string& letters) const { return step() * (2.0 * double(letters.size()) - 1); }

    // Text whose middle is `middle`.
    void text(const std::string& letters, const Vec2& middle, const Rgb& color = Rgb(1)) {
        const double step = this->step();
        Vec2 corner = middle - Vec2(halfOf(letters), 2 * step);
        for (const char letter : letters) {
            const std::string_view strokes = strokesOf(letter);
            for (std::size_t i = 1; i < strokes.size(); ++i)
                if (strokes[i - 1] != ' ' && strokes[i] != ' ')
                    line(corner + step * gridPoint(strokes[i - 1]), corner + step * gridPoint(strokes[i]), color);
            corner.x += 4 * step;
        }
    }

    // Rims first, so that none covers a line.
    void draw() {
        const double half = 0.6 * m_unit;
        for (const Line& line : m_lines) stroke(line.from, line.to, Rgb(0), half + m_unit, 0.6);
        for (const Line& line : m_lines) stroke(line.from, line.to, line.color, half, 1);
    }

  private:
    double step() const { return 2.2 * m_unit; }  // of the letters' grid

    // A line with round ends, `half` pixels to either side; its rim covers pixels in part.
    void stroke(const Vec2& from, const Vec2& to, const Rgb& color, double half, double opacity) {
        const PixelWindow& window = m_picture.window;
        const auto first = [&](double a, double b, int least) {
            return std::max(least, static_cast<int>(std::floor(std::min(a, b) - half - 1)));
        };
        const auto last = [&](double a, double b, int most) {
            return std::min(most, static_cast<int>(std::ceil(std::max(a, b) + half + 1)));
        };
        const Vec2 way = to - from;
        const double length2 = std::max(glm::dot(way, way), 1e-12);
        for (int y = first(from.y, to.y, 0); y < last(from.y, to.y, window.height()); ++y)
            for (int x = first(from.x, to.x, 0); x < last(from.x, to.x, window.width()); ++x) {
                const Vec2 at(x + 0.5, y + 0.5);
                const double along = std::clamp(glm::dot(at - from, way) / length2, 0.0, 1.0);
                const double covered =
                    std::clamp(half + 0.5 - glm::length(at - from - along * way), 0.0, 1.0) * opacity;
                std::uint8_t* const pixel =
                    m_picture.rgba.data() + 4 * (std::size_t(y) * std::size_t(window.width()) + std::size_t(x));
                for (int c = 0; c < 3; ++c)
                    pixel[c] = static_cast<std::uint8_t>(std::lround(pixel[c] + covered * (255 * color[c] - pixel[c])));
            }
    }

    DisplayImage& m_picture;
    double m_unit;
    std::vector<Line> m_lines;
};

void drawBar(Drawing& drawing, const Vec2& size, double worldOfPixel) {
    constexpr double kPart = 0.3;  // of the picture's width, at most
    const double length = roundLength(kPart * size.x * worldOfPixel), pixels = length / worldOfPixel;
    const double unit = drawing.unit(), x = 14 * unit, y = size.y - 14 * unit;
    drawing.line({x, y}, {x + pixels, y});
    for (const double end : {x, x + pixels}) drawing.line({end, y - 4 * unit}, {end, y + 4 * unit});
    const std::string text = fmt::format("{:g}", length);
    drawing.text(text, {x + std::max(pixels / 2, drawing.halfOf(text)), y - 12 * unit});
}

void drawAxes(Drawing& drawing, const Vec2& size, const Camera& camera) {
    constexpr std::array<char, 3> kNames{'x', 'y', 'z'};
    constexpr double kFaint = 0.35;  // apart from its own channel
    const double length = 24 * drawing.unit();
    const Vec2 origin = size - Vec2(1.8 * length);
    const Mat3 axes = glm::transpose(Mat3(camera.wsFromCamera));  // world axes in camera space, by columns
    std::array<int, 3> order{0, 1, 2};
    // Those that point at the eye are drawn last.
    std::sort(order.begin(), order.end(), [&](int a, int b) { return axes[a].z < axes[b].z; });
    for (const int axis : order) {
        Rgb color(kFaint);
        color[axis] = 1;
        const Vec2 way(axes[axis].x, -axes[axis].y);
        drawing.line(origin, origin + length * way, color);
        // The letter of one that points at the eye stands beside it.
        const double seen = glm::length(way);
        const Vec2 beyond = seen > 0.2 ? way / seen : Vec2(-0.7, 0.7);
        drawing.text(std::string(1, kNames[std::size_t(axis)]), origin + length * way + 9 * drawing.unit() * beyond,
                     color);
    }
}

}  // namespace

double roundLength(double length) {
    const double power = std::pow(10, std::floor(std::log10(length)));
    double round = power;
    for (const double factor : {2.0, 5.0, 10.0})
        if (factor * power <= length * (1 + 1e-9)) round = factor * power;
    return round;
}

void drawMarks(DisplayImage& picture, const PreviewMarks& marks) {
    Drawing drawing(picture);
    const Vec2 size(picture.window.width(), picture.window.height());
    const Camera& camera = marks.camera;
    const double away = glm::dot(marks.wsMiddle - camera.wsPosition, viewingAxis(camera));
    // The size of a pixel behind the eye, or of no pixels, is none.
    if (away > 0 || camera.type == CameraType::orthographic) drawBar(drawing, size, pixelAt(camera, away));
    drawAxes(drawing, size, camera);
    drawing.draw();
}

}  // namespace scrim
