// SPDX-License-Identifier: Apache-2.0
#include <scrim/geometry/camera.h>

#include <cmath>

#include <glm/geometric.hpp>
#include <glm/trigonometric.hpp>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

// Half the width and height of the picture: at depth 1 (perspective) or at any depth (orthographic).
Vec2 halfExtent(const Camera& camera) {
    const double aspect = camera.pixelAspect * camera.resolution.x / camera.resolution.y;
    if (camera.type == CameraType::orthographic) return {0.5 * camera.height * aspect, 0.5 * camera.height};
    const double halfWidth = std::tan(glm::radians(0.5 * camera.fov));
    return {halfWidth, halfWidth / aspect};
}

}  // namespace

Mat3 lookAt(const Vec3& position, const Vec3& target, const Vec3& up) {
    const Vec3 back = glm::normalize(position - target);
    Vec3 right = glm::cross(up, back);
    // The camera looks straight along `up`. Any perpendicular direction will do, but it must not depend on rounding.
    if (glm::dot(right, right) < 1e-20 * glm::dot(up, up)) {
        right = glm::cross(Vec3(0, 0, -1), back);
        if (glm::dot(right, right) < 1e-20) right = Vec3(1, 0, 0);
    }
    right = glm::normalize(right);
    return Mat3(right, glm::cross(back, right), back);
}

RayFamily wsRays(const Camera& camera) {
    const Vec3 right = camera.wsFromCamera[0], up = camera.wsFromCamera[1], back = camera.wsFromCamera[2];
    const Vec2 half = halfExtent(camera);
    const Vec3 stepX = right * (2 * half.x / camera.resolution.x);
    const Vec3 stepY = -up * (2 * half.y / camera.resolution.y);
    const Vec2 middle = 2 * half.x * camera.shift;
    const Vec3 topLeft = right * (middle.x - half.x) + up * (middle.y + half.y);

    RayFamily rays;
    rays.near = camera.near;
    rays.origin0 = camera.wsPosition;
    rays.direction0 = -back;
    if (camera.type == CameraType::orthographic) {
        rays.origin0 += topLeft;
        rays.originX = stepX;
        rays.originY = stepY;
    } else {
        rays.direction0 += topLeft;
        rays.directionX = stepX;
        rays.directionY = stepY;
    }
    return rays;
}

double pixelAt(const Camera& camera, double distance) {
    const RayFamily rays = wsRays(camera);
    return camera.type == CameraType::orthographic ? glm::length(rays.originX)
                                                   : glm::length(rays.directionX) * distance;
}

Vec3 travelToEye(const Camera& camera, const Vec3& ws) {
    if (camera.type == CameraType::orthographic) return -viewingAxis(camera);
    const Vec3 way = camera.wsPosition - ws;
    const double length = glm::length(way);
    return length > 0 ? way / length : -viewingAxis(camera);
}

// The window moves against the eye, by as much as the eye's move shows at the focus.
Camera throughLens(Camera camera, const Lens& lens, const Vec2& place) {
    const Vec2 moved = lens.radius * place;
    camera.wsPosition += camera.wsFromCamera[0] * moved.x + camera.wsFromCamera[1] * moved.y;
    camera.shift -= moved / (2 * halfExtent(camera).x * lens.focus);
    return camera;
}

double blurAt(const Camera& camera, const Lens& lens, double depth) {
    return 2 * lens.radius * std::abs(1 / lens.focus - 1 / depth) / pixelAt(camera, 1);
}

Camera supersampled(Camera camera, int n) {
    camera.resolution *= n;
    return camera;
}

Mat4 worldToCamera(const Camera& camera) {
    const Mat3 rotation = glm::transpose(camera.wsFromCamera);
    Mat4 m(rotation);
    m[3] = glm::dvec4(-(rotation * camera.wsPosition), 1.0);
    return m;
}

Mat4 worldToNdc(const Camera& camera) {
    const Vec2 half = halfExtent(camera);
    Mat4 projection(0.0);
    projection[0][0] = 1 / half.x;
    projection[1][1] = 1 / half.y;
    // There is no far plane: z maps to itself, since EXR readers only use x and y.
    projection[2][2] = -1;
    const Vec2 middle = 2 * half.x * camera.shift / half;
    if (camera.type == CameraType::orthographic) {
        projection[3] = glm::dvec4(-middle, 0, 1);
    } else {
        projection[2][0] = middle.x;
        projection[2][1] = middle.y;
        projection[2][3] = -1;
    }
    return projection * worldToCamera(camera);
}

}  // namespace scrim
