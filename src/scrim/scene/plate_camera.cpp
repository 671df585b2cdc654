// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/plate_camera.h>

#include <scrim/base/error.h>
#include <scrim/scene/scene_keys.h>
#include <scrim/scene/scene_reader.h>

#include <fmt/format.h>

#include <cmath>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>
#include <glm/trigonometric.hpp>

namespace scrim {
namespace {

constexpr double kTolerance = 1e-3;  // relative error of matrices that renderers stored and multiplied as floats
constexpr double kNearMiddle = 0.2;  // radius around 0 and around 1/2 within which a middle is recognised

[[noreturn]] void refuse(const std::string& problem) {
    throw Error(ErrorKind::input, problem);
}

/// A matrix from 16 numbers that act on row vectors.
Mat4 matrixOf(const std::vector<float>& numbers, const char* name) {
    if (numbers.size() != 16) refuse(fmt::format("its header has no {}", name));
    Mat4 m;
    for (int i = 0; i < 16; ++i) {
        if (!std::isfinite(numbers[std::size_t(i)])) refuse(fmt::format("{} of its header is not finite", name));
        // The matrix of row vectors is the transpose, and glm stores columns.
        m[i / 4][i % 4] = numbers[std::size_t(i)];
    }
    return m;
}

/// The projection from camera to picture: ndc = slope * (x, y) / depth + middle, without the division if parallel.
struct Projection {
    bool parallel = false;
    Vec2 slope{1}, middle{0};
};

/// `front` is the sign of depth: depth = front * z.
Projection projectionOf(const Mat4& ndcFromCamera, double front) {
    const auto at = [&](int row, int column) { return ndcFromCamera[column][row]; };
    Projection out;
    const double perDepth = at(3, 2) * front, constant = at(3, 3);
    out.parallel = std::abs(constant) > std::abs(perDepth);
    double w = out.parallel ? constant : perDepth;
    const double size = std::abs(w);
    for (const double other : {at(3, 0), at(3, 1), out.parallel ? perDepth : constant})
        if (!(std::abs(other) <= kTolerance * size)) refuse("worldToNDC does not match its worldToCamera");
    for (int k = 0; k < 2; ++k) {
        const double across = at(k, 1 - k), elsewhere = out.parallel ? at(k, 2) : at(k, 3);
        out.slope[k] = at(k, k) / w;
        out.middle[k] = (out.parallel ? at(k, 3) : at(k, 2) * front) / w;
        if (!(std::abs(across) <= kTolerance * std::abs(at(k, k))) || !(std::abs(elsewhere) <= kTolerance * size))
            refuse("worldToNDC does not match its worldToCamera");
    }
    if (!out.parallel && w < 0) {
        if (glm::length(out.middle) > kTolerance)
            refuse(
                "worldToNDC has w < 0 in front of the camera and an off-center lens, so the direction of the lens "
                "shift is ambiguous; give the camera in the scene");
        out.slope = -out.slope;
        out.middle = Vec2(0);
    }
    return out;
}

/// Changes the projection to the range -1..1 over width and height, with y up.
void makeSymmetric(Projection& p, NdcRange ndc) {
    const auto far = [&](double middle) {
        return std::max(std::abs(p.middle.x - middle), std::abs(p.middle.y - middle));
    };
    const bool down = p.slope.y < 0;
    bool unit = ndc == NdcRange::unit;
    if (ndc == NdcRange::automatic) {
        unit = far(0.5) < kNearMiddle;
        if ((!unit && far(0) >= kNearMiddle) || (!unit && down))
            refuse(
                fmt::format("its worldToNDC has its center at {:.3g}, {:.3g}, so its range may be -1..1 or 0..1; set "
                            "{} in the scene",
                            p.middle.x, p.middle.y, keysOf<CameraKeys>().ndc));
    }
    if (unit) {
        p.slope *= 2;
        p.middle = 2.0 * p.middle - 1.0;
    }
    if (down) {
        p.slope.y = -p.slope.y;
        p.middle.y = -p.middle.y;
    }
    if (!(p.slope.x > 0 && p.slope.y > 0)) refuse("worldToNDC mirrors the picture");
}

void checkShape(double lens, const PictureHeader& header) {
    const double picture = header.pixelAspect * header.width / header.height;
    if (!(std::abs(lens / picture - 1) <= kTolerance))
        refuse(
            fmt::format("its camera has the aspect ratio {:.4g}, but the picture ({} x {}) has {:.4g}; was it cropped "
                        "or reformatted?",
                        lens, header.width, header.height, picture));
}

/// The camera from Scrim's own attribute.
Camera ownCamera(const PictureHeader& header, const ColourConfig& colour) {
    Camera camera = readCameraText(header.camera, "scrim:camera", colour);
    checkShape(camera.pixelAspect * camera.resolution.x / camera.resolution.y, header);
    camera.resolution = {header.width, header.height};
    camera.near = 0;
    return camera;
}

std::string numbers(const glm::dvec4& row) {
    const auto plain = [](double v) { return v + 0.0; };  // turns -0 into 0
    return fmt::format("[{}, {}, {}, {}]", plain(row.x), plain(row.y), plain(row.z), plain(row.w));
}

}  // namespace

Camera cameraOf(const PictureHeader& header, NdcRange ndc, const ColourConfig& colour) {
    if (!header.camera.empty()) return ownCamera(header, colour);
    const Mat4 cameraFromWs = matrixOf(header.worldToCamera, "worldToCamera");
    const Mat4 ndcFromWs = matrixOf(header.worldToNdc, "worldToNDC");
    const Mat3 rows = glm::transpose(Mat3(cameraFromWs));
    const double scale = glm::length(rows[0]);
    if (!(scale > 0) || !(std::abs(glm::dot(rows[0], rows[1])) <= kTolerance * scale * scale) ||
        !(std::abs(glm::length(rows[1]) / scale - 1) <= kTolerance) ||
        !(std::abs(glm::length(rows[2]) / scale - 1) <= kTolerance))
        refuse("its worldToCamera is sheared or scaled unevenly");
    const double front = glm::determinant(rows) < 0 ? 1 : -1;
    const Mat4 wsFromCamera = glm::inverse(cameraFromWs);
    Projection p = projectionOf(ndcFromWs * wsFromCamera, front);
    makeSymmetric(p, ndc);
    checkShape(p.slope.y / p.slope.x, header);

    Camera camera;
    camera.type = p.parallel ? CameraType::orthographic : CameraType::perspective;
    camera.wsPosition = Vec3(wsFromCamera[3]);
    const Vec3 back = glm::normalize(glm::cross(rows[0], rows[1])), right = glm::normalize(rows[0]);
    camera.wsFromCamera = Mat3(right, glm::cross(back, right), back);
    camera.resolution = {header.width, header.height};
    camera.pixelAspect = header.pixelAspect;
    // Lengths are in the camera's own units; with a parallel projection one world unit is `scale` of them.
    camera.fov = glm::degrees(2 * std::atan(1 / p.slope.x));
    camera.height = 2 / (p.slope.y * scale);
    camera.shift = -0.5 * p.middle / Vec2(1, p.slope.y / p.slope.x);
    return camera;
}

std::string cameraText(const Camera& camera) {
    const CameraKeys& k = keysOf<CameraKeys>();
    const bool perspective = camera.type == CameraType::perspective;
    const Mat3& axes = camera.wsFromCamera;
    std::string rows;
    for (int row = 0; row < 3; ++row)
        rows += numbers({axes[0][row], axes[1][row], axes[2][row], camera.wsPosition[row]}) + ", ";
    return fmt::format("{} = \"{}\"\n{} = [{}{}]\n{} = {}\n{} = [{}, {}]\n{} = {}\n{} = [{}, {}]\n", k.type.name,
                       k.type.words[perspective ? 0 : 1], k.matrix.name, rows, numbers({0, 0, 0, 1}),
                       perspective ? k.fov.name : k.height.name, perspective ? camera.fov : camera.height, k.shift.name,
                       camera.shift.x, camera.shift.y, k.pixelAspect.name, camera.pixelAspect, k.resolution.name,
                       camera.resolution.x, camera.resolution.y);
}

}  // namespace scrim
