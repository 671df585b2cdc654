// SPDX-License-Identifier: Apache-2.0
// Cameras from the headers of pictures: those of Scrim, and of renderers with other conventions.
#include <scrim/scene/plate_camera.h>

#include "read_scene.h"
#include "support/expect_error.h"

#include <scrim/geometry/camera.h>

#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <string>
#include <vector>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim::test {
namespace {

/// As OpenEXR stores a matrix: floats that act on row vectors.
std::vector<float> stored(const Mat4& m) {
    std::vector<float> numbers;
    for (int i = 0; i < 16; ++i) numbers.push_back(static_cast<float>(m[i / 4][i % 4]));
    return numbers;
}

PictureHeader headerOf(const Camera& camera) {
    PictureHeader header;
    header.width = camera.resolution.x;
    header.height = camera.resolution.y;
    header.pixelAspect = camera.pixelAspect;
    header.worldToCamera = stored(worldToCamera(camera));
    header.worldToNdc = stored(worldToNdc(camera));
    return header;
}

/// How far a point lies apart in two pictures, in pixels.
double pixelsApart(const Camera& a, const Camera& b, const Vec3& ws) {
    const auto pixel = [&](const Camera& camera) {
        const glm::dvec4 h = worldToNdc(camera) * glm::dvec4(ws, 1);
        return Vec2(0.5 * h.x / h.w * camera.resolution.x, 0.5 * h.y / h.w * camera.resolution.y);
    };
    return glm::distance(pixel(a), pixel(b));
}

std::vector<Camera> someCameras() {
    std::vector<Camera> cameras;
    for (int i = 0; i < 12; ++i) {
        Camera camera;
        camera.wsPosition = {3.0 + i, -2.0 + 0.3 * i, 9};
        camera.wsFromCamera = lookAt(camera.wsPosition, {0.1 * i, 0.5, 0}, {0.1, 1, 0.02 * i});
        camera.fov = 20 + 4 * i;
        camera.resolution = {640 + 8 * i, 360};
        camera.pixelAspect = i % 3 == 0 ? 2 : 1;
        if (i % 2 == 1) camera.shift = {0.02 * i / 12, -0.02};
        if (i % 4 == 3) {
            camera.type = CameraType::orthographic;
            camera.height = 5;
        }
        cameras.push_back(camera);
    }
    return cameras;
}

/// Largest distance over points in front of the camera.
double worst(const Camera& a, const Camera& b) {
    std::mt19937 random(7);
    std::uniform_real_distribution<double> in(-2, 2);
    double most = 0;
    for (int i = 0; i < 200; ++i) most = std::max(most, pixelsApart(a, b, {in(random), in(random), in(random)}));
    return most;
}

Camera from(const PictureHeader& header, NdcRange ndc = NdcRange::automatic) {
    return cameraOf(header, ndc, ownColours());
}

std::string refused(const PictureHeader& header, NdcRange ndc = NdcRange::automatic) {
    return test::errorOf(ErrorKind::input, [&] { from(header, ndc); });
}

TEST(PlateCamera, OfScrimsOwnWordsIsExact) {
    for (const Camera& camera : someCameras()) {
        PictureHeader header = headerOf(camera);
        header.camera = cameraText(camera);
        EXPECT_LT(worst(from(header), camera), 1e-6);
        EXPECT_EQ(from(header).resolution, camera.resolution);
    }
}

TEST(PlateCamera, OfMatricesIsAsGoodAsFloatsAre) {
    for (const Camera& camera : someCameras()) {
        // 24 bits of a thousand pixels, and what the subtraction of the eye's place loses.
        EXPECT_LT(worst(from(headerOf(camera)), camera), 1e-2);
        EXPECT_EQ(from(headerOf(camera)).type, camera.type);
    }
}

/// What `make` makes of the matrices, as column vectors have them.
template <typename Make>
PictureHeader changed(const Camera& camera, const Make& make) {
    Mat4 view = worldToCamera(camera), ndc = worldToNdc(camera);
    make(view, ndc);
    PictureHeader header = headerOf(camera);
    header.worldToCamera = stored(view);
    header.worldToNdc = stored(ndc);
    return header;
}

const Mat4 kFlipZ(glm::dvec4(1, 0, 0, 0), glm::dvec4(0, 1, 0, 0), glm::dvec4(0, 0, -1, 0), glm::dvec4(0, 0, 0, 1));
/// -1..1 with y up to 0..1 with y down, before the division.
const Mat4 kUnitDown(glm::dvec4(0.5, 0, 0, 0), glm::dvec4(0, -0.5, 0, 0), glm::dvec4(0, 0, 1, 0),
                     glm::dvec4(0.5, 0.5, 0, 1));
const Mat4 kUnitUp(glm::dvec4(0.5, 0, 0, 0), glm::dvec4(0, 0.5, 0, 0), glm::dvec4(0, 0, 1, 0),
                   glm::dvec4(0.5, 0.5, 0, 1));

TEST(PlateCamera, ReadsEveryConvention) {
    for (const Camera& camera : someCameras()) {
        // OpenEXR's documents and RenderMan: left-handed, 0..1, y down.
        const PictureHeader documents = changed(camera, [](Mat4& view, Mat4& ndc) {
            view = kFlipZ * view;
            ndc = kUnitDown * ndc;
        });
        EXPECT_LT(worst(from(documents), camera), 1e-2);
        EXPECT_LT(worst(from(documents, NdcRange::unit), camera), 1e-2);
        const PictureHeader unit = changed(camera, [](Mat4&, Mat4& ndc) { ndc = kUnitUp * ndc; });
        EXPECT_LT(worst(from(unit), camera), 1e-2);
        const PictureHeader leftHanded = changed(camera, [](Mat4& view, Mat4&) { view = kFlipZ * view; });
        EXPECT_LT(worst(from(leftHanded), camera), 1e-2);
    }
}

TEST(PlateCamera, ReadsMantras) {
    // As a picture of Houdini's Mantra has them: left-handed, and negative in front of the camera.
    PictureHeader header;
    header.width = 1280;
    header.height = 720;
    header.worldToCamera = {-0.243232f, -0.429738f, -0.869577f, 0, -4.55991e-08f, 0.8965f,    -0.443043f, 0,
                            -0.969968f, 0.107762f,  0.218058f,  0, -0.49336f,     -0.356619f, 6.48486f,   1};
    header.worldToNdc = {-0.587216f,    -1.84441f, -8.69577e-05f, 0.869577f, -1.10086e-07f, 3.84773f,
                         -4.43043e-05f, 0.443043f, -2.34172f,     0.462509f, 2.18058e-05f,  -0.218058f,
                         -1.19108f,     -1.53059f, 0.000648386f,  -6.48486f};
    const Camera camera = from(header);
    // 45 degrees across; the eye looks at the origin, down on it, and the world's up is up.
    EXPECT_NEAR(camera.fov, 45, 1e-3);
    EXPECT_LT(glm::distance(camera.wsPosition, Vec3(5.3662, 3.1928, -1.8544)), 1e-3);
    EXPECT_LT(glm::dot(viewingAxis(camera), camera.wsPosition), 0);
    EXPECT_GT(camera.wsFromCamera[1].y, 0.8);
    EXPECT_NEAR(glm::determinant(camera.wsFromCamera), 1, 1e-12);
}

TEST(PlateCamera, RefusesWhatItCannotTell) {
    const Camera camera = someCameras()[2];
    EXPECT_EQ(refused(PictureHeader{64, 64, 1, "", {}, {}, ""}), "its header has no worldToCamera");
    PictureHeader half = headerOf(camera);
    half.worldToNdc.clear();
    EXPECT_EQ(refused(half), "its header has no worldToNDC");
    PictureHeader cropped = headerOf(camera);
    cropped.height = 200;
    EXPECT_NE(refused(cropped).find("was it cropped or reformatted?"), std::string::npos);
    cropped.camera = cameraText(camera);
    EXPECT_NE(refused(cropped).find("was it cropped or reformatted?"), std::string::npos);
    PictureHeader strange = headerOf(camera);
    strange.worldToNdc = headerOf(someCameras()[5]).worldToNdc;
    EXPECT_EQ(refused(strange), "worldToNDC does not match its worldToCamera");
    PictureHeader nan = headerOf(camera);
    nan.worldToCamera[3] = std::nanf("");
    EXPECT_EQ(refused(nan), "worldToCamera of its header is not finite");
    PictureHeader zero = headerOf(camera);
    zero.worldToCamera.assign(16, 0);
    EXPECT_EQ(refused(zero), "its worldToCamera is sheared or scaled unevenly");
    PictureHeader words = headerOf(camera);
    words.camera = "fov = ";
    EXPECT_NE(refused(words).find("scrim:camera:1:"), std::string::npos) << refused(words);

    // A lens shifted by a quarter of the picture: -1..1 and 0..1 look alike, and 'ndc' says which.
    Camera shifted = camera;
    shifted.shift = {-0.15, 0.1};
    EXPECT_NE(refused(headerOf(shifted)).find("set 'ndc' in the scene"), std::string::npos);
    EXPECT_LT(worst(from(headerOf(shifted), NdcRange::symmetric), shifted), 1e-2);
    const PictureHeader behind = changed(shifted, [](Mat4&, Mat4& ndc) { ndc = Mat4(-1.0) * ndc; });
    EXPECT_NE(refused(behind).find("the lens shift is ambiguous"), std::string::npos) << refused(behind);
}

}  // namespace
}  // namespace scrim::test
