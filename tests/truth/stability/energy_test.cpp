// SPDX-License-Identifier: Apache-2.0
// What no picture may do, whatever the errors of its sheets: shine more than it is lit, be less than empty or more than
// opaque, or grow brighter behind more smoke.
#include "truth/stability/scenes.h"

namespace scrim::test {
namespace {

const double kPi = std::acos(-1.0);

// Fields from smooth to as rough as a lattice can be.
std::shared_ptr<SparseField> sparks() {
    return makeField(Int3(-9), Int3(9), 1, [](const Vec3& is) {
        const auto h = static_cast<unsigned>(int(is.x) * 73856093 ^ int(is.y) * 19349663 ^ int(is.z) * 83492791);
        return h * 2654435761u >> 24 < 24 ? 1.0 : 0.0;
    });
}

std::vector<std::shared_ptr<SparseField>> fields() {
    return {smoothField(), smokeField(9), sparks()};
}

class Energy : public testing::TestWithParam<Way> {
  protected:
    // Both kinds of camera, and both orders.
    static std::vector<ViewScene> scenes(double extinction, const Vec3& albedo) {
        std::vector<ViewScene> all;
        for (const auto& field : fields())
            for (const bool perspective : {false, true})
                for (const double side : {-1.0, 1.0}) {
                    Medium medium;
                    medium.densityScale = extinction;
                    medium.albedo = albedo;
                    ViewScene scene = orthographicScene(field, medium, 24, 32);
                    if (perspective) look(scene, {9.1, 13.3, 42.7}, {0.1, 0, 0}, 32);
                    scene.lights = {distantLight({0.6, -0.5, side}, 1)};
                    take(GetParam(), scene);
                    all.push_back(scene);
                }
        return all;
    }
};
class EnergyOfMedia : public Energy {};

// A white medium in an environment of radiance 1 that shadows nothing gives back 1 where it is opaque, and alpha
// elsewhere: every channel is alpha to the rounding of sums over some fifty sheets.
TEST_P(EnergyOfMedia, OfAWhiteFurnaceIsAlpha) {
    for (const double extinction : {1e-6, 0.3, 30.0, 1e5})
        for (ViewScene scene : scenes(extinction, Rgb(1))) {
            scene.lights.clear();
            scene.ambient = Rgb(1);
            const Image image = renderScene(scene).image;
            ASSERT_TRUE(sane(image)) << extinction;
            for (std::size_t i = 0; i < image.rgba.size(); i += 4)
                for (std::size_t c = 0; c < 3; ++c)
                    ASSERT_NEAR(image.rgba[i + c], image.rgba[i + 3], 3e-6 * image.rgba[i + 3])
                        << extinction << " " << i;
        }
}

// Single scattering of irradiance E with phase 1 / 4 pi: at most E / 4 pi where light leaves at once, as the integral
// of sigma e^-tau along the ray is at most alpha. Opaque or not, no pixel is brighter.
TEST_P(Energy, OfOneLightIsNoMoreThanAllOfItScatteredOnce) {
    for (const double extinction : {0.3, 30.0, 1e5})
        for (const ViewScene& scene : scenes(extinction, Rgb(1))) {
            const Image image = renderScene(scene).image;
            ASSERT_TRUE(sane(image)) << extinction;
            // A surface that faces the light reflects (k_d + k_s) E / pi, and nothing more.
            const double most = GetParam().classified ? 1 / kPi : 1 / (4 * kPi);
            for (std::size_t i = 0; i < image.rgba.size(); i += 4)
                for (std::size_t c = 0; c < 3; ++c)
                    ASSERT_LE(image.rgba[i + c], most * image.rgba[i + 3] * (1 + 3e-6))
                        << "extinction " << extinction << " pixel " << i / 4;
        }
}

// Where nothing is, there is nothing, and a black medium is black.
TEST_P(EnergyOfMedia, OfABlackMediumIsNone) {
    for (const ViewScene& scene : scenes(3, Rgb(0))) {
        const Frame frame = renderScene(scene);
        const std::vector<float>& rgba = frame.image.rgba;
        for (std::size_t i = 0; i < rgba.size(); ++i) ASSERT_EQ(i % 4 == 3 ? 0 : rgba[i], 0);
        EXPECT_EQ(pixelOf(frame, 0, 0)[3], 0);
    }
}

// More smoke hides more, pixel by pixel, to the rounding of a sum: sheets are the same ones, all that grows is their
// extinction.
TEST_P(Energy, MoreDensityNeverLetsMoreThrough) {
    for (ViewScene scene : scenes(0.01, Rgb(0.5))) {
        scene.dials.opacityCutoff = 0;
        std::vector<float> before;
        for (const double more : {1.0, 1.1, 3.0, 3.0, 10.0, 100.0}) {
            scene.volumes[0].medium.densityScale *= more;
            if (GetParam().classified) {
                Classified look = *scene.volumes[0].classified;
                look.densityScale *= more;
                scene.volumes[0].classified = std::make_shared<const Classified>(look);
            }
            const Image image = renderScene(scene).image;
            ASSERT_TRUE(sane(image));
            for (std::size_t i = 3; i < before.size(); i += 4)
                ASSERT_GE(image.rgba[i], before[i] - 3e-7f) << "pixel " << i / 4;
            before = image.rgba;
        }
    }
}

// Smoke that scatters nothing, around the origin, and the eye in front of it.
void addBlackSmoke(ViewScene& scene, double extinction) {
    const auto field = smoothField();
    scene.volumes.push_back({"smoke", field, field->wsFromIs, Medium{extinction, Rgb(0), {}}});
    scene.camera.wsPosition.z = 60;
}

// A block behind smoke, one that glows by itself (by ambient light of its own albedo): what arrives from behind, the
// picture less the smoke's own light, falls with every increase of the smoke.
TEST_P(EnergyOfMedia, OfWhatLiesBehindFallsWithTheSmokeBefore) {
    const auto block = boxField({-6, -6, -20}, {5, 5, -15});
    for (const double side : {-1.0, 1.0}) {
        double before = 1e30;
        for (const double extinction : {1e-4, 0.01, 0.1, 0.3, 1.0, 3.0, 10.0}) {
            ViewScene scene = orthographicScene(block, {0.5, Rgb(1), {}}, 10, 16);
            addBlackSmoke(scene, extinction);
            scene.ambient = Rgb(1);
            scene.lights = {distantLight({0.1, 0, side}, 1e-6)};
            take(GetParam(), scene);
            const double through = pixelOf(renderScene(scene), 7, 6)[0];
            EXPECT_GE(through, 0);
            EXPECT_TRUE(through < before || through == 0) << extinction << ": " << through << " after " << before;
            before = through;
        }
    }
}

// Of light: the shadow of more smoke is never lighter.
TEST_P(Energy, OfAShadowedFloorFallsWithTheSmokeAbove) {
    const auto floor = boxField({-8, -20, -8}, {7, -17, 7});
    double before = 1e30;
    for (const double extinction : {1e-4, 0.01, 0.1, 0.3, 1.0, 3.0, 10.0}) {
        ViewScene scene = orthographicScene(floor, {0.01, Rgb(1), {}}, 40, 40);
        addBlackSmoke(scene, extinction);
        scene.lights = {distantLight({0, -1, -0.1}, 1)};
        scene.dials.splat = GetParam().splat;
        scene.dials.shade = GetParam().shade;
        if (GetParam().classified) {
            ViewScene one = scene;
            one.volumes.erase(one.volumes.begin());
            take(GetParam(), one);
            scene.volumes[1] = one.volumes[0];
        }
        const double lit = pixelOf(renderScene(scene), 20, 38)[0];
        EXPECT_GE(lit, 0);
        EXPECT_LT(lit, before) << extinction;
        before = lit;
    }
}

// Surfaces have colours of their own.
INSTANTIATE_TEST_SUITE_P(Ways, EnergyOfMedia, testing::Values(kTexels, kPixels, kPerView), nameOfWay);
INSTANTIATE_TEST_SUITE_P(Ways, Energy, testing::Values(kTexels, kPixels, kPerView, kSurface, kSurfacePerView),
                         nameOfWay);

}  // namespace
}  // namespace scrim::test
