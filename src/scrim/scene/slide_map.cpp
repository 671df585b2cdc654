// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/slide_map.h>

#include <scrim/geometry/camera.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>

namespace scrim {
namespace {

// The picture's axes in world space and half its extent along them, in world units (distant lights)
// or as tangents (others).
struct SlideFrame {
    Vec3 right, down;
    double halfWidth, halfHeight;
};

SlideFrame frameOf(const Light& light) {
    const Slide& slide = *light.slide;
    const Mat3 viewer = lookAt(Vec3(0), light.wsDirection, light.wsUp);  // right, up, back
    const double roll = glm::radians(slide.roll), c = std::cos(roll), s = std::sin(roll);
    SlideFrame frame;
    frame.right = c * viewer[0] - s * viewer[1];
    frame.down = -s * viewer[0] - c * viewer[1];
    if (light.distant()) {
        frame.halfWidth = 0.5 * slide.width;
        frame.halfHeight = slide.height > 0 ? 0.5 * slide.height : frame.halfWidth / slide.image->aspect();
    } else {
        frame.halfWidth = std::tan(glm::radians(0.5 * slide.fov));
        frame.halfHeight = frame.halfWidth / slide.image->aspect();
    }
    return frame;
}

// The index of a pixel along one axis of a level. Outside of the picture it is the border's pixel
// or, where the slide repeats, the next copy's.
int placed(long i, int size, SlideOutside outside) {
    if (outside != SlideOutside::repeat) return static_cast<int>(std::clamp(i, 0L, long(size) - 1));
    const long rest = i % size;
    return static_cast<int>(rest < 0 ? rest + size : rest);
}

}  // namespace

SlideMap slideMap(const Light& light) {
    const SlideFrame frame = frameOf(light);
    const double width = light.slide->image->width(), height = light.slide->image->height();
    const Vec3 x = frame.right * (0.5 * width / frame.halfWidth), y = frame.down * (0.5 * height / frame.halfHeight);
    SlideMap map;
    map.wsOrigin = light.wsPosition;
    if (light.distant()) {
        map.perWs = glm::transpose(Mat3(x, y, Vec3(0)));
        map.atOrigin = {0.5 * width, 0.5 * height, 1};
    } else {
        const Vec3 w = light.wsDirection;
        map.perWs = glm::transpose(Mat3(x + 0.5 * width * w, y + 0.5 * height * w, w));
        map.atOrigin = Vec3(0);
    }
    return map;
}

Rgb slideValue(const Light& light, const SlideMap& map, const Vec3& ws) {
    const Vec3 h = map.homogeneous(ws);
    if (!(h.z > 0)) return Rgb(0);
    const Texture::Level& level = light.slide->image->levels().front();
    const SlideOutside outside = light.slide->outside;
    double x = h.x / h.z, y = h.y / h.z;
    if (outside == SlideOutside::black && (x < 0 || y < 0 || x > level.width || y > level.height)) return Rgb(0);
    // A float cannot resolve pixels at such distances, and a long can still count them.
    constexpr double kFar = 1e12;
    x = std::clamp(x, -kFar, kFar) - 0.5;
    y = std::clamp(y, -kFar, kFar) - 0.5;
    const double fx = std::floor(x), fy = std::floor(y);
    Rgb sum(0);
    for (int j = 0; j < 2; ++j)
        for (int i = 0; i < 2; ++i) {
            const float* pixel = level.pixel(placed(static_cast<long>(fx) + i, level.width, outside),
                                             placed(static_cast<long>(fy) + j, level.height, outside));
            const double weight = (i ? x - fx : 1 - (x - fx)) * (j ? y - fy : 1 - (y - fy));
            sum += weight * Rgb(pixel[0], pixel[1], pixel[2]);
        }
    return sum;
}

SlideMap::OnSheet sheetMap(const SlideMap& map, const Sheets& sheets, double middle) {
    const Mat3 wsFromSs = glm::transpose(sheets.ssFromWs);
    SlideMap::OnSheet out;
    out.atOrigin = map.homogeneous(sheets.wsPoint({0, 0, middle}));
    out.perU = map.perWs * (wsFromSs[0] * sheets.texel);
    out.perV = map.perWs * (wsFromSs[1] * sheets.texel);
    out.perN = map.perWs * (wsFromSs[2] * sheets.thickness);
    return out;
}

double slideHalfAngle(const Light& light) {
    const SlideFrame frame = frameOf(light);
    return std::atan(std::hypot(frame.halfWidth, frame.halfHeight));
}

std::vector<Vec3> slideCorners(const Light& light) {
    const SlideFrame frame = frameOf(light);
    std::vector<Vec3> corners;
    for (const double x : {-1.0, 1.0})
        for (const double y : {-1.0, 1.0})
            corners.push_back(glm::normalize(light.wsDirection + x * frame.halfWidth * frame.right +
                                             y * frame.halfHeight * frame.down));
    return corners;
}

std::vector<Vec3> distantSlideCorners(const Light& light) {
    const SlideFrame frame = frameOf(light);
    std::vector<Vec3> corners;
    for (const double x : {-1.0, 1.0})
        for (const double y : {-1.0, 1.0})
            corners.push_back(light.wsPosition + x * frame.halfWidth * frame.right + y * frame.halfHeight * frame.down);
    return corners;
}

std::optional<double> slidePixel(const Light& light, const Vec3& ws) {
    const SlideFrame frame = frameOf(light);
    const Texture& image = *light.slide->image;
    const double edge = std::min(2 * frame.halfWidth / image.width(), 2 * frame.halfHeight / image.height());
    if (light.distant()) return edge;
    const double depth = glm::dot(ws - light.wsPosition, light.wsDirection);
    if (!(depth > 0)) return std::nullopt;
    return edge * depth;
}

}  // namespace scrim
