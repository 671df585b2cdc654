// SPDX-License-Identifier: Apache-2.0
// Grids that lie in the world in every way an affine map allows: turned, mirrored, stretched, sheared. Brute force sees
// the same field through the same map.
#include "truth/stability/scenes.h"
#include "support/verified.h"

namespace scrim::test {
namespace {

Mat3 rotation(const Vec3& axis, double degrees) {
    const Vec3 a = glm::normalize(axis);
    const double angle = degrees * std::acos(-1.0) / 180, c = std::cos(angle), s = std::sin(angle);
    const Mat3 cross(0, a.z, -a.y, -a.z, 0, a.x, a.y, -a.x, 0);
    return c * Mat3(1.0) + s * cross + (1 - c) * glm::outerProduct(a, a);
}

struct Lie {
    const char* name;
    Mat3 map;
};
void PrintTo(const Lie& lie, std::ostream* out) {
    *out << lie.name;
}

class GridThatIs : public testing::TestWithParam<Lie> {
  protected:
    // The map applied to the grid only; stretched grids keep about their optical depth.
    ViewScene scene(const Way& way) const {
        ViewScene scene = smallScene(way, 40, smoothField());
        scene.volumes[0].wsFromIs = Mat4(GetParam().map) * scene.volumes[0].wsFromIs;
        scene.lights[1].wsPosition = {60, 72, 60};
        look(scene, {14, 20, 70}, {0, 0, 0}, 36);
        return scene;
    }
};

// A smooth field, so that what is left is the method's own error at one texel a voxel of the smallest edge.
TEST_P(GridThatIs, AgreesWithBruteForceOnEveryWay) {
    for (const Way& way : {kTexels, kPixels, kPerView}) {
        const ViewScene s = scene(way);
        const Frame frame = renderScene(s);
        ASSERT_TRUE(sane(frame.image)) << way.name;
        expectConvergence(s, 30, 1, 0.005, way.name);
    }
}

INSTANTIATE_TEST_SUITE_P(
    Everywhere, GridThatIs,
    testing::Values(Lie{"plain", Mat3(1.0)}, Lie{"turned", rotation({1, 2, 3}, 77)},
                    Lie{"turnedAQuarter", rotation({0, 1, 0}, 90)}, Lie{"mirrored", Mat3(-1, 0, 0, 0, 1, 0, 0, 0, 1)},
                    Lie{"mirroredThrice", Mat3(-1.0)}, Lie{"flat", Mat3(1, 0, 0, 0, 0.5, 0, 0, 0, 1)},
                    Lie{"long", Mat3(0.5, 0, 0, 0, 0.5, 0, 0, 0, 2)},
                    Lie{"flatTurnedAndMirrored", rotation({1, -1, 2}, 50) * Mat3(1, 0, 0, 0, -0.5, 0, 0, 0, 1)},
                    Lie{"sheared", Mat3(1, 0, 0, 0.8, 1, 0, 0, -0.6, 1)}),
    [](const auto& test) { return std::string(test.param.name); });

// x -> -x of everything gives the mirrored picture. Table steps are rounded to one side, so that this holds to the
// error of footprints' positions, which is of second order in their steps.
class Mirrored : public testing::TestWithParam<Way> {};

TEST_P(Mirrored, SceneGivesTheMirroredPicture) {
    constexpr int kPixelsWide = 32;
    ViewScene scene = smallScene(GetParam(), kPixelsWide), other = scene;
    const auto mirror = [](Vec3& p) { p.x = -p.x; };
    other.volumes[0].wsFromIs = Mat4(Mat3(-1, 0, 0, 0, 1, 0, 0, 0, 1)) * other.volumes[0].wsFromIs;
    for (Light& light : other.lights) {
        mirror(light.wsPosition);
        mirror(light.wsDirection);
    }
    mirror(other.camera.wsPosition);
    Mat3& axes = other.camera.wsFromCamera;
    for (int axis = 0; axis < 3; ++axis) mirror(axes[axis]);
    axes[0] = -axes[0];  // right-handed again: the picture runs the other way
    const Frame a = renderScene(scene), b = renderScene(other);
    double most = 0;
    for (int y = 0; y < kPixelsWide; ++y)
        for (int x = 0; x < kPixelsWide; ++x)
            for (std::size_t c = 0; c < 4; ++c)
                most = std::max(most, std::abs(pixelOf(a, x, y)[c] - pixelOf(b, kPixelsWide - 1 - x, y)[c]));
    RecordProperty("change", std::to_string(most / brightest(a.image)));
    EXPECT_LT(most, 1e-3 * brightest(a.image));
}

INSTANTIATE_TEST_SUITE_P(Ways, Mirrored, testing::Values(kTexels, kPixels, kPerView, kSurface), nameOfWay);

}  // namespace
}  // namespace scrim::test
