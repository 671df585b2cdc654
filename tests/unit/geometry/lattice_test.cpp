// SPDX-License-Identifier: Apache-2.0
#include <scrim/geometry/lattice.h>

#include <gtest/gtest.h>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

// A view from (3, -2, -20) whose raster leans against the sheets.
Lattice leaningView() {
    Lattice raster;
    raster.kind = Lattice::Kind::perspective;
    const Vec3 eye(3, -2, -20), x(40, 3, 8), y(-2, 35, 5), w(0.2, 0.1, 1);
    const auto row = [&](const Vec3& form) { return glm::dvec4(form, -glm::dot(form, eye)); };
    const glm::dvec4 rx = row(x), ry = row(y), rw = row(w);
    for (int c = 0; c < 4; ++c) raster.rsFromTs[c] = {rx[c], ry[c], c == 2 ? 1.0 : 0.0, rw[c]};
    return raster;
}

TEST(Lattice, PointsOfOneRayHaveOnePlace) {
    const Lattice raster = leaningView();
    const Vec3 point(5, 4, 7), place = raster.place(point);
    const Vec3 ray = raster.rayThrough(place.x, place.y);
    for (const double t : {-0.001, 0.002, 0.004}) {
        const Vec3 other = raster.place(point + t * ray);
        EXPECT_NEAR(other.x, place.x, 1e-9);
        EXPECT_NEAR(other.y, place.y, 1e-9);
    }
}

TEST(Lattice, IsItsLinearisationToFirstOrder) {
    const Lattice raster = leaningView();
    const Vec3 point(5, 4, 7);
    const Mat4 map = raster.linearised(point);
    const double h = 1e-5;
    for (int axis = 0; axis < 3; ++axis) {
        Vec3 step(0);
        step[axis] = h;
        const Vec3 slope = (raster.place(point + step) - raster.place(point - step)) / (2 * h);
        EXPECT_NEAR(map[axis].x, slope.x, 1e-6);
        EXPECT_NEAR(map[axis].y, slope.y, 1e-6);
        EXPECT_EQ(map[axis].z, axis == 2 ? 1 : 0) << "sheets stay sheets";
    }
    EXPECT_NEAR(transformPoint(map, point).x, raster.place(point).x, 1e-9);
    EXPECT_NEAR(transformPoint(map, point).z, point.z, 1e-9);
}

TEST(Lattice, MapsThePlanesOfSheets) {
    const Lattice raster = leaningView();
    const Vec3 p = raster.fromPlane(6.5) * Vec3(2, 3, 1), place = raster.place({2, 3, 6.5});
    EXPECT_NEAR(p.x / p.z, place.x, 1e-12);
    EXPECT_NEAR(p.y / p.z, place.y, 1e-12);
}

}  // namespace
}  // namespace scrim::test
