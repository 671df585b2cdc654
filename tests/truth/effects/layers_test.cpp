// SPDX-License-Identifier: Apache-2.0
// Pictures beside the beauty: they are parts of it, and cost it nothing.
#include "scenes.h"

#include <scrim/verify/reference.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

const std::vector<Layer> kAll{Layer::light,  Layer::ambient, Layer::emission,
                              Layer::albedo, Layer::depth,   Layer::transmittance};

const FrameLayer& layerOf(const Frame& frame, Layer layer, int light = -1) {
    return *std::find_if(frame.layers.begin(), frame.layers.end(),
                         [&](const FrameLayer& l) { return l.layer == layer && l.light == light; });
}

double largest(const Image& image) {
    return *std::max_element(image.rgba.begin(), image.rgba.end());
}

void expectSame(const Image& a, const Image& b, double tolerance) {
    ASSERT_EQ(a.rgba.size(), b.rgba.size());
    const double scale = largest(b);
    for (std::size_t i = 0; i < a.rgba.size(); ++i) ASSERT_NEAR(a.rgba[i], b.rgba[i], tolerance * scale) << i;
}

class Layers : public testing::TestWithParam<std::tuple<std::string, bool>> {
  protected:
    ViewScene scene() const {
        ViewScene s = sceneWith(std::get<0>(GetParam()));
        s.dials.shade = std::get<1>(GetParam()) ? ShadeMode::pixel : ShadeMode::texel;
        return s;
    }
};

TEST_P(Layers, AddUpToTheBeauty) {
    ViewScene s = scene();
    s.ambient = {0.05, 0.1, 0.1};
    s.layers = kAll;
    const Frame frame = renderScene(s);
    Image sum = frame.image;
    for (std::size_t i = 0; i < sum.rgba.size(); ++i) {
        if (i % 4 == 3) continue;
        sum.rgba[i] = 0;
        for (const FrameLayer& layer : frame.layers)
            if (layer.layer == Layer::light || layer.layer == Layer::ambient || layer.layer == Layer::emission)
                sum.rgba[i] += layer.data[i / 4 * 3 + i % 4];
    }
    expectSame(sum, frame.image, 2e-6);
}

TEST_P(Layers, LeaveTheBeautyAsItIs) {
    ViewScene s = scene();
    const Frame without = renderScene(s);
    s.layers = kAll;
    expectSame(renderScene(s).image, without.image, 2e-6);
}

TEST_P(Layers, OfALightAreThePictureOfThatLightAlone) {
    ViewScene s = scene();
    s.ambient = Rgb(0);
    for (ViewVolume& volume : s.volumes) volume.emission.clear();
    s.layers = {Layer::light};
    const Frame frame = renderScene(s);
    for (int light : {0, 1}) {
        ViewScene alone = s;
        alone.layers.clear();
        // The light stays where it is in the sweep, but is dark.
        alone.lights[static_cast<std::size_t>(1 - light)].intensity = Rgb(0);
        const Frame expected = renderScene(alone);
        const FrameLayer& layer = layerOf(frame, Layer::light, light);
        // Without the other light sheets may lie otherwise.
        for (std::size_t i = 0; i < layer.data.size(); ++i)
            ASSERT_NEAR(layer.data[i], expected.image.rgba[i / 3 * 4 + i % 3], 0.02 * largest(frame.image));
    }
}

INSTANTIATE_TEST_SUITE_P(Each, Layers,
                         testing::Combine(testing::Values("ambient", "coloured extinction", "all at once"),
                                          testing::Bool()));

const FrameLayer& layerOfVolume(const Frame& frame, int volume) {
    return *std::find_if(frame.layers.begin(), frame.layers.end(),
                         [&](const FrameLayer& l) { return l.layer == Layer::volume && l.volume == volume; });
}

class VolumeLayers : public testing::TestWithParam<std::tuple<std::string, bool, bool>> {
  protected:
    ViewScene scene() const {
        ViewScene s = sceneWith(std::get<0>(GetParam()));
        s.ambient = {0.05, 0.1, 0.1};
        s.dials.shade = std::get<1>(GetParam()) ? ShadeMode::pixel : ShadeMode::texel;
        s.layers = {Layer::volume};
        if (std::get<2>(GetParam())) s.layers = {Layer::light, Layer::ambient, Layer::emission, Layer::volume};
        return s;
    }
};

TEST_P(VolumeLayers, AddUpToTheBeautyAndLeaveIt) {
    ViewScene s = scene();
    const Frame frame = renderScene(s);
    Image sum = frame.image;
    for (std::size_t i = 0; i < sum.rgba.size(); ++i) {
        if (i % 4 == 3) continue;
        sum.rgba[i] = 0;
        for (std::size_t v = 0; v < s.volumes.size(); ++v)
            sum.rgba[i] += layerOfVolume(frame, static_cast<int>(v)).data[i / 4 * 3 + i % 4];
    }
    expectSame(sum, frame.image, 4e-6);
    s.layers.clear();
    expectSame(renderScene(s).image, frame.image, 4e-6);
}

// Of brute force: what the picture shows when the other volumes only take light away.
TEST_P(VolumeLayers, AreWhatTheVolumeMakesOfLight) {
    ViewScene s = scene();
    s.dials.texel = s.dials.sheetThickness = 0.7;
    const Frame frame = renderScene(s);
    for (std::size_t v = 0; v < s.volumes.size(); ++v) {
        ViewScene alone = s;
        for (std::size_t w = 0; w < s.volumes.size(); ++w) {
            if (w == v) continue;
            alone.volumes[w].medium.albedo = Rgb(0);
            alone.volumes[w].scatter.clear();
            alone.volumes[w].emission.clear();
        }
        const Reference reference(alone);
        const FrameLayer& layer = layerOfVolume(frame, static_cast<int>(v));
        double square = 0, mean = 0;
        for (int y = 10; y < 40; y += 4)
            for (int x = 9; x < 40; x += 4) {
                const std::array<double, 4> truth = reference.pixel(x, y);
                for (std::size_t c = 0; c < 3; ++c) {
                    const double error = layer.data[frame.image.indexOf(x, y) / 4 * 3 + c] - truth[c];
                    square += error * error / 192;
                    mean += truth[c] / 192;
                }
            }
        EXPECT_LT(std::sqrt(square), 0.02 * mean) << "volume " << v;
    }
}

INSTANTIATE_TEST_SUITE_P(Each, VolumeLayers,
                         testing::Combine(testing::Values("light linking", "two tints", "all at once"), testing::Bool(),
                                          testing::Bool()));

const FrameLayer& opacityOf(const Frame& frame, int volume) {
    return *std::find_if(frame.layers.begin(), frame.layers.end(),
                         [&](const FrameLayer& l) { return l.layer == Layer::cryptomatte && l.volume == volume; });
}

TEST_P(VolumeLayers, OpacitiesAddUpToAlphaAndLeaveThePicture) {
    ViewScene s = scene();
    const Frame without = renderScene(s);
    s.layers.push_back(Layer::cryptomatte);
    const Frame frame = renderScene(s);
    expectSame(without.image, frame.image, 4e-6);
    for (std::size_t p = 0; p < frame.image.rgba.size() / 4; ++p) {
        double sum = 0;
        for (std::size_t v = 0; v < s.volumes.size(); ++v) sum += opacityOf(frame, static_cast<int>(v)).data[p];
        ASSERT_NEAR(sum, frame.image.rgba[4 * p + 3], 4e-6);
    }
}

TEST(VolumeOpacity, OfSlabsIsWhatTheLightMeetsFirst) {
    Medium front, behind;
    front.densityScale = 0.05;
    front.extinctionTint = {1, 0.5, 0.25};
    behind.densityScale = 0.2;
    ViewScene scene = orthographicScene(boxField({-40, -40, 6}, {39, 39, 9}), front, 20, 9);
    scene.volumes.push_back(scene.volumes.front());
    scene.volumes.back().field = boxField({-40, -40, -10}, {39, 39, 1});
    scene.volumes.back().medium = behind;
    scene.layers = {Layer::cryptomatte};
    scene.dials.sheetThickness = 0.5;
    const auto check = [&](bool held) {
        scene.volumes.front().holdout = held;
        const Frame frame = renderScene(scene);
        double first = 0, second = 0;
        for (const double tint : {1.0, 0.5, 0.25}) {
            first += (1 - std::exp(-0.05 * 4 * tint)) / 3;
            second += std::exp(-0.05 * 4 * tint) * (1 - std::exp(-0.2 * 12)) / 3;
        }
        const std::size_t middle = 4 * 9 + 4;
        EXPECT_NEAR(opacityOf(frame, 0).data[middle], held ? 0 : first, 1e-4);
        EXPECT_NEAR(opacityOf(frame, 1).data[middle], second, 1e-4);
        EXPECT_NEAR(frame.image.rgba[4 * middle + 3], held ? second : first + second, 1e-4);
    };
    check(false);
    check(true);  // what is held out hides without being there
}

TEST(VolumeOpacity, OfASurfaceIsThatOfItsTransferFunction) {
    ViewScene scene = sceneWith("light linking");
    auto look = std::make_shared<Classified>();
    look->transfer = {{0.0, Rgb(1, 0.8, 0.6), 0.0}, {1.0, Rgb(1, 0.8, 0.6), 0.5}};
    scene.volumes[1].classified = look;
    scene.layers = {Layer::cryptomatte};
    const Frame frame = renderScene(scene);
    for (std::size_t p = 0; p < frame.image.rgba.size() / 4; ++p)
        ASSERT_NEAR(opacityOf(frame, 0).data[p] + opacityOf(frame, 1).data[p], frame.image.rgba[4 * p + 3], 4e-6);
    EXPECT_GT(*std::max_element(opacityOf(frame, 1).data.begin(), opacityOf(frame, 1).data.end()), 0.1);
}

TEST(LightGroup, ShowsTheSumOfItsLights) {
    for (const bool soft : {false, true}) {
        ViewScene scene = plainScene();
        scene.lights.push_back(lamp({10, 5, 12}, 300));
        if (soft) scene.lights[1].kind = Light::Distant(20);
        if (soft) scene.volumes.front().medium.scattering = Scattering::full;
        scene.layers = {Layer::light};
        const Frame apart = renderScene(scene);
        scene.lights[0].group = scene.lights[2].group = "practicals";
        const Frame grouped = renderScene(scene);
        ASSERT_EQ(grouped.layers.size(), 2u);
        const double tolerance = soft ? 2e-3 : 4e-6;  // multiply scattered light is solved to an accuracy
        expectSame(grouped.image, apart.image, tolerance);
        const FrameLayer &group = layerOf(grouped, Layer::light, 0), &other = layerOf(grouped, Layer::light, 1);
        double most = 0;
        for (std::size_t i = 0; i < group.data.size(); ++i) {
            ASSERT_NEAR(group.data[i],
                        layerOf(apart, Layer::light, 0).data[i] + layerOf(apart, Layer::light, 2).data[i], tolerance);
            ASSERT_NEAR(other.data[i], layerOf(apart, Layer::light, 1).data[i], tolerance);
            most = std::max<double>(most, layerOf(apart, Layer::light, 2).data[i]);
        }
        EXPECT_GT(most, 0.01);
    }
}

TEST(VolumeLayer, OfInstancesIsOneEach) {
    ViewScene scene = plainScene();
    scene.volumes.push_back(scene.volumes.front());  // looks alike, and shares planes but for the layer
    scene.volumes.back().wsFromIs[3] = {22, 0, 0, 1};
    scene.layers = {Layer::volume};
    const Frame frame = renderScene(scene);
    const FrameLayer &left = layerOfVolume(frame, 0), &right = layerOfVolume(frame, 1);
    const std::size_t atLeft = 3 * (24 * 48 + 12), atRight = 3 * (24 * 48 + 46);
    EXPECT_GT(left.data[atLeft], 0.01);
    EXPECT_NEAR(right.data[atLeft], 0, 1e-6);
    EXPECT_GT(right.data[atRight], 0.01);
    EXPECT_NEAR(left.data[atRight], 0, 1e-6);
}

// Of volumes that are culled the layers are there, and black.
TEST(VolumeLayer, IsThatOfItsPlaceInTheScene) {
    ViewScene scene = plainScene();
    scene.layers = {Layer::volume};
    scene.volumes[0].place = 1;
    scene.volumeCount = 3;
    const Frame frame = renderScene(scene);
    ASSERT_EQ(frame.layers.size(), 3u);
    for (int v : {0, 2})
        for (const float value : layerOfVolume(frame, v).data) ASSERT_EQ(value, 0);
    for (std::size_t i = 0; i < layerOfVolume(frame, 1).data.size(); ++i)
        ASSERT_NEAR(layerOfVolume(frame, 1).data[i], frame.image.rgba[i / 3 * 4 + i % 3], 1e-6);
}

TEST(VolumeLayer, OfAClassifiedVolumeIsItsSurface) {
    ViewScene scene = sceneWith("light linking");
    auto look = std::make_shared<Classified>();
    look->transfer = {{0.0, Rgb(1, 0.8, 0.6), 0.0}, {1.0, Rgb(1, 0.8, 0.6), 0.5}};
    scene.volumes[1].classified = look;
    scene.layers = {Layer::volume};
    const Frame frame = renderScene(scene);
    Image sum = frame.image;
    for (std::size_t i = 0; i < sum.rgba.size(); ++i)
        if (i % 4 != 3)
            sum.rgba[i] =
                layerOfVolume(frame, 0).data[i / 4 * 3 + i % 4] + layerOfVolume(frame, 1).data[i / 4 * 3 + i % 4];
    expectSame(sum, frame.image, 4e-6);
    EXPECT_GT(*std::max_element(layerOfVolume(frame, 1).data.begin(), layerOfVolume(frame, 1).data.end()), 0.01);
}

TEST(TransmittanceLayer, IsWhatAlphaLeaves) {
    ViewScene scene = sceneWith("coloured extinction");
    scene.layers = {Layer::transmittance};
    const Frame frame = renderScene(scene);
    const FrameLayer& layer = layerOf(frame, Layer::transmittance);
    for (std::size_t i = 0; i < layer.data.size(); i += 3)
        ASSERT_NEAR(1 - (layer.data[i] + layer.data[i + 1] + layer.data[i + 2]) / 3, frame.image.rgba[i / 3 * 4 + 3],
                    2e-6);
}

TEST(AlbedoLayer, IsTheAlbedoTimesWhatItHides) {
    ViewScene scene = plainScene();
    scene.layers = {Layer::albedo};
    const Frame frame = renderScene(scene);
    const FrameLayer& layer = layerOf(frame, Layer::albedo);
    for (std::size_t i = 0; i < layer.data.size(); ++i)
        ASSERT_NEAR(layer.data[i],
                    scene.volumes[0].medium.albedo[static_cast<int>(i % 3)] * frame.image.rgba[i / 3 * 4 + 3], 1e-5);
}

// A slab between z = -10.5 and 9.5 (voxels from -10 to 9), seen from z = 49.5.
class DepthLayer : public testing::TestWithParam<std::tuple<bool, bool, bool>> {};

TEST_P(DepthLayer, IsThatOfTheFrontAndOfTheMean) {
    const auto [perspective, pixels, behind] = GetParam();
    Medium medium;
    medium.densityScale = 0.1;
    ViewScene scene = orthographicScene(boxField({-60, -60, -10}, {59, 59, 9}), medium, 20, 9);
    if (perspective) {
        scene.camera.type = CameraType::perspective;
        scene.camera.fov = 30;
    }
    scene.dials.shade = pixels ? ShadeMode::pixel : ShadeMode::texel;
    scene.lights = {distantLight({0.1, 0.2, behind ? 1 : -1}, 1)};
    scene.layers = {Layer::depth};
    const Frame frame = renderScene(scene);
    const double front = scene.camera.wsPosition.z - 9.5, tau = 2, length = 20;
    const FrameLayer& layer = layerOf(frame, Layer::depth);
    const float* depth = layer.data.data() + 2 * (4 * 9 + 4);
    EXPECT_NEAR(depth[0], front, 1);  // to within a sheet
    // Mean of x sigma e^(-sigma x) over the slab.
    const double mean = length / tau * (1 - std::exp(-tau) * (1 + tau)) / (1 - std::exp(-tau));
    EXPECT_NEAR(depth[1], front + mean, 0.1);
    // Depth lies along the viewing axis, not along the ray.
    const float* corner = layer.data.data();
    EXPECT_NEAR(corner[0], front, 1);
}
INSTANTIATE_TEST_SUITE_P(Ways, DepthLayer, testing::Combine(testing::Bool(), testing::Bool(), testing::Bool()));

// A plane that leans away, and moves by a tenth of a sheet from one picture to the next: Z follows it, and is no saw of
// sheets. Truth: where the plane, whose linear kernel spreads it by half a voxel, lets half of its density begin.
class DepthOfPlane : public testing::TestWithParam<std::tuple<bool, bool, double>> {};

TEST_P(DepthOfPlane, FollowsItThroughTheSheets) {
    const auto [pixels, behind, scale] = GetParam();
    constexpr double kLean = 0.3, kSheet = 1.5;
    Medium medium;
    medium.densityScale = scale;
    double worst = 0, sum = 0, squares = 0;
    int count = 0;
    for (int offset = 0; offset < 10; ++offset) {
        auto field = boxField({-40, -40, -30}, {39, 39, 9});
        // Turned about y by kLean, its upper face once at z = 9.5, and moved along z.
        const double c = std::cos(kLean), s = std::sin(kLean), move = 0.1 * offset * kSheet;
        field->wsFromIs =
            Mat4(glm::dvec4(c, 0, -s, 0), glm::dvec4(0, 1, 0, 0), glm::dvec4(s, 0, c, 0), glm::dvec4(0, 0, move, 1));
        ViewScene scene = orthographicScene(field, medium, 20, 16);
        scene.dials.sheetThickness = kSheet;
        scene.dials.texel = 0.5;
        scene.dials.shade = pixels ? ShadeMode::pixel : ShadeMode::texel;
        scene.lights = {distantLight({0.1, 0.2, behind ? 1 : -1}, 1)};
        scene.layers = {Layer::depth};
        const Frame frame = renderScene(scene);
        const FrameLayer& layer = layerOf(frame, Layer::depth);
        const RayFamily rays = wsRays(scene.camera);
        for (int y = 4; y < 12; ++y)
            for (int x = 4; x < 12; ++x) {
                // On the face: (p - move) . n = 9.5 with n = (s, 0, c).
                const Vec3 o = rays.origin(x + 0.5, y + 0.5) - Vec3(0, 0, move);
                const double truth = (9.5 - (s * o.x + c * o.z)) / (s * 0 - c);
                const double error = layer.data[2 * std::size_t(16 * y + x)] - truth;
                worst = std::max(worst, std::abs(error));
                sum += error;
                squares += error * error;
                ++count;
            }
    }
    const double mean = sum / count, deviation = std::sqrt(squares / count - mean * mean);
    // A saw of sheets has a deviation of 0.29 sheets, and is wrong by up to one.
    EXPECT_LT(deviation, 0.02 * kSheet);
    EXPECT_LT(std::abs(mean), 0.02 * kSheet);
    EXPECT_LT(worst, 0.05 * kSheet);
}
INSTANTIATE_TEST_SUITE_P(Ways, DepthOfPlane,
                         testing::Combine(testing::Bool(), testing::Bool(), testing::Values(0.05, 0.5, 4)));

TEST(DepthLayerOfNothing, IsZero) {
    ViewScene scene = plainScene();
    scene.layers = {Layer::depth, Layer::transmittance};
    const Frame frame = renderScene(scene);
    EXPECT_EQ(layerOf(frame, Layer::depth).data[0], 0);
    EXPECT_EQ(layerOf(frame, Layer::depth).data[1], 0);
    EXPECT_EQ(layerOf(frame, Layer::transmittance).data[0], 1);
    scene.volumes.clear();
    EXPECT_EQ(layerOf(renderScene(scene), Layer::transmittance).data[0], 1);
}

}  // namespace
}  // namespace scrim::test
