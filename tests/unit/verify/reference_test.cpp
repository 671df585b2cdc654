// SPDX-License-Identifier: Apache-2.0
// The truth, against what is truer: closed forms.
#include "support/fields.h"

#include <scrim/geometry/camera.h>
#include <scrim/scene/medium.h>
#include <scrim/verify/reference.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>
#include <vector>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

const double kPi = std::acos(-1.0);
constexpr double kAlbedo = 0.8, kIrradiance = 2.0;
constexpr int kThickness = 10;  // voxels

ViewScene slab(double opticalDepth, const Vec3& lightDirection, double voxel = 1) {
    Medium medium;
    medium.densityScale = opticalDepth / kThickness / voxel;
    medium.albedo = Rgb(kAlbedo);
    ViewScene scene = orthographicScene(boxField({-48, -48, -5}, {47, 47, 4}, voxel), medium, 20 * voxel, 32);
    scene.lights.push_back(distantLight(lightDirection, kIrradiance));
    return scene;
}

// The slab's faces are ramps of one voxel, with two kinks each. Where a kink falls into a step h, two-point Gauss
// quadrature misses at most 0.0223 h^2 voxels (see footprint_table_test): 4 of them in 10 voxels at h = 1/2 are
// 0.22 % of tau, at h = 1/10 they are 9e-5. All else is far below.
struct Setting {
    ReferenceOptions options;
    double tauError;
};
const Setting kSettings[] = {{{}, 2.3e-3}, {{0.1, 0.02, 1e-9}, 1e-4}};

class ReferenceSlab : public testing::TestWithParam<double> {};

// L = E rho / (8 pi) (1 - e^-2 tau), alpha = 1 - e^-tau: both change by less, relatively, than tau does.
TEST_P(ReferenceSlab, LitFromTheFrontIsTheClosedForm) {
    for (const double voxel : {1.0, 1e-4})
        for (const Setting& setting : kSettings) {
            const ViewScene scene = slab(GetParam(), {0, 0, -1}, voxel);
            const auto pixel = Reference(scene, setting.options).pixel(16, 16);
            const double expected = kIrradiance * kAlbedo / (8 * kPi) * -std::expm1(-2 * GetParam());
            EXPECT_NEAR(pixel[0], expected, setting.tauError * expected);
            EXPECT_NEAR(pixel[2], expected, setting.tauError * expected);
            EXPECT_NEAR(pixel[3], -std::expm1(-GetParam()), setting.tauError * -std::expm1(-GetParam()));
        }
}

// L = E rho / (4 pi) tau e^-tau, which changes by |1 - tau| times what tau does.
TEST_P(ReferenceSlab, LitFromBehindIsTheClosedForm) {
    for (const Setting& setting : kSettings) {
        const ViewScene scene = slab(GetParam(), {0, 0, 1});
        // Nothing is left of light through tau = 50, and the ray ends before it would find out.
        const double expected = kIrradiance * kAlbedo / (4 * kPi) * GetParam() * std::exp(-GetParam());
        EXPECT_NEAR(Reference(scene, setting.options).pixel(16, 16)[0], expected,
                    (1 + GetParam()) * setting.tauError * expected + 1e-12);
    }
}

INSTANTIATE_TEST_SUITE_P(OpticalDepths, ReferenceSlab, testing::Values(1e-6, 0.1, 1.0, 3.0, 10.0, 50.0));

TEST(ReferenceAmbient, IsAlbedoTimesOpacityTimesItsRadiance) {
    ViewScene scene = slab(2, {0, 0, 1});
    scene.lights.clear();
    scene.ambient = {0.5, 1, 2};
    const auto pixel = Reference(scene).pixel(16, 16);
    for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(pixel[static_cast<std::size_t>(c)], scene.ambient[c] * kAlbedo * (1 - std::exp(-2.0)),
                    kSettings[0].tauError * scene.ambient[c]);
}

// A Gaussian ball under the B-spline, which widens a Gaussian of s = 4 voxels by a variance of 1/3.
class Ball {
  public:
    explicit Ball(double scale)
        : m_field(makeField(Int3(-22), Int3(22), 1, [](const Vec3& is) { return std::exp(-glm::dot(is, is) / 32); })) {
        Medium medium;
        medium.densityScale = scale;
        medium.albedo = Rgb(1);
        scene = orthographicScene(m_field, medium, 30, 30);
        scene.dials.kernel = Kernel::bspline;
        m_width = std::sqrt(16 + 1.0 / 3);
        m_peak = scale * std::pow(4 / m_width, 3);
    }
    double sigma(const Vec3& p) const { return m_peak * std::exp(-glm::dot(p, p) / (2 * m_width * m_width)); }
    double depth(const Vec3& a, const Vec3& b) const {
        const Vec3 d = glm::normalize(b - a);
        const double from = glm::dot(a, d), to = glm::dot(b, d), aside2 = glm::dot(a, a) - from * from;
        const auto erf = [&](double t) { return std::erf(t / (m_width * std::sqrt(2.0))); };
        return m_peak * std::exp(-aside2 / (2 * m_width * m_width)) * m_width * std::sqrt(kPi / 2) *
               (erf(to) - erf(from));
    }
    ViewScene scene;

  private:
    std::shared_ptr<SparseField> m_field;
    double m_width, m_peak;
};

// A B-spline is not quite a Gaussian: its fourth cumulant of -1/30 makes the sum of both flatter by
// 3 / (24 * 30 s^4) = 1.6e-5 for each of two axes across the ray. Floats of the voxels and the box's end at 22 of them
// (e^(-22^2 / 32) = 3e-7) are less.
TEST(OpticalDepth, ThroughAGaussianBallIsTheErrorFunction) {
    const Ball ball(0.4);
    const Reference reference(ball.scene);
    const Vec3 points[] = {{-60, 1, 2}, {0, 0, 0}, {3, -2, 5}, {7, 40, -3}, {0, 0, 60}, {2, 3, 4}};
    for (const Vec3& a : points)
        for (const Vec3& b : points) {
            if (a == b) {
                EXPECT_EQ(reference.opticalDepth(a, b), Rgb(0));
                continue;
            }
            const double expected = ball.depth(a, b);
            EXPECT_NEAR(reference.opticalDepth(a, b).x, expected, 5e-5 * expected + 1e-6);
            EXPECT_NEAR(reference.opticalDepth(a, b).x, reference.opticalDepth(b, a).x, 1e-5 * expected + 1e-9);
        }
}

// Where no light is lost a sample is E rho p sigma; with a phase function that knows which way is which.
TEST(Sample, IsLightTimesPhaseTimesExtinction) {
    Ball ball(0.4);
    ball.scene.volumes[0].medium.phase.g = 0.6;
    ball.scene.lights.push_back(distantLight({1, 0, 0}, 3));
    const Reference reference(ball.scene);
    const Vec3 at(1, 2, -1);
    for (const Vec3& eye : {Vec3(1, 0, 0), Vec3(-1, 0, 0), Vec3(0, 0.6, 0.8)}) {
        const Reference::Sample sample = reference.sample(at, eye);
        EXPECT_NEAR(sample.extinction.x, ball.sigma(at), 1e-5);
        // Light that goes on to the eye travels against the eye's ray: looking along the light, it is turned back.
        const double lit = 3 * std::exp(-ball.depth(at - Vec3(80, 0, 0), at));
        const double expected = lit * phaseValue({0.6}, -eye.x) * ball.sigma(at);
        EXPECT_NEAR(sample.source.x, expected, 1e-4 * expected);
    }
}

TEST(Ray, ThroughAGaussianBallIsTheIntegralOfItsClosedForm) {
    Ball ball(0.4);
    ball.scene.lights.push_back(distantLight({1, -0.5, -1}));
    const Vec3 light = ball.scene.lights[0].wsDirection;
    const Reference reference(ball.scene);
    for (const auto& [x, y] : {std::pair{15, 15}, {12, 18}, {20, 8}}) {
        const Vec3 p(x + 0.5 - 15, 15 - y - 0.5, 0);
        double expected = 0;
        for (double z = 40; z > -40; z -= 0.01) {
            const Vec3 q(p.x, p.y, z);
            expected += 0.01 * ball.sigma(q) / (4 * kPi) *
                        std::exp(-ball.depth(q - 80.0 * light, q) - ball.depth({p.x, p.y, 80}, q));
        }
        // The B-spline's 5e-5 once for each of light, eye and source, and steps of half a voxel (below).
        EXPECT_NEAR(reference.pixel(x, y)[0], expected, 4e-4 * expected) << x << "," << y;
    }
}

// Two-point Gauss with dimming within the step: at least second order, where the field is smooth.
TEST(Steps, ConvergeWithTheSquareOfTheirLength) {
    Ball ball(0.4);
    ball.scene.lights.push_back(distantLight({1, -0.5, -1}));
    const auto value = [&](double step) { return Reference(ball.scene, {step, 1e9, 1e-9}).pixel(12, 18)[0]; };
    const double limit = value(0.25);
    const double coarse = std::abs(value(4) - limit), fine = std::abs(value(2) - limit);
    EXPECT_GT(coarse, 0);
    EXPECT_GT(coarse / fine, 3.5) << coarse << " " << fine;
    EXPECT_LT(std::abs(value(0.5) - limit), 2e-4 * limit);
}

// Dense media take smaller steps, so that the step's length is no excuse.
TEST(Steps, AreShortWhereTheMediumIsDense) {
    const ViewScene scene = slab(300, {0, 0, -1});  // tau 15 in half a voxel
    const double expected = kIrradiance * kAlbedo / (8 * kPi);
    EXPECT_NEAR(Reference(scene).pixel(16, 16)[0], expected, 1e-3 * expected);
}

// A ray that passes a lamp at a small fraction of a voxel, where its light changes within a step: a point's adds up to
// I sigma / (4 pi) times the angle that the ray is seen under, divided by its distance; that of a sphere of radiance L
// begins at the surface, with half of all directions. The medium is so thin that it attenuates nothing. Steps of a
// quarter of the distance miss 0.1 %.
TEST(Lamps, LightARayThatPassesThemByTheirClosedForm) {
    constexpr double kDepth = 1e-4, kBeside = 0.05;
    ViewScene scene = slab(kDepth, {0, 0, -1});
    const double sigma = kAlbedo * kDepth / kThickness, half = 0.5 * kThickness;
    const Vec3 ray = wsRays(scene.camera).origin(16.5, 16.5);
    Light& light = scene.lights.front();
    light.kind = Light::Point();
    light.wsPosition = Vec3(ray.x + kBeside, ray.y, -0.5);  // the slab is from -5.5 to 4.5
    light.intensity = Rgb(1);
    const double point = sigma / (4 * kPi) * 2 * std::atan(half / kBeside) / kBeside;
    EXPECT_NEAR(Reference(scene).ray(16.5, 16.5)[1], point, 3e-3 * point);

    for (const double radius : {0.04, 0.2, 0.7}) {
        Light::Area area;
        area.shape = AreaShape::sphere;
        area.radius = radius;
        light.kind = area;
        // The integral of 2 pi (1 - sqrt(1 - R^2 / r^2)) over the ray outside of the sphere, by r dr = t dt.
        const double from = std::sqrt(std::max(0.0, radius * radius - kBeside * kBeside));
        double sum = 0;
        constexpr int kSteps = 200000;
        for (int i = 0; i < kSteps; ++i) {
            const double u = (i + 0.5) / kSteps, t = from + (half - from) * u * u * u;  // finer at the surface
            const double r2 = t * t + kBeside * kBeside;
            sum += (1 - std::sqrt(std::max(0.0, 1 - radius * radius / r2))) * 3 * u * u * (half - from) / kSteps;
        }
        const double sphere = sigma / (4 * kPi) * 2 * 2 * kPi * sum;
        EXPECT_NEAR(Reference(scene).ray(16.5, 16.5)[1], sphere, 1e-2 * sphere) << radius;
    }
}

// sigma L / (4 pi) times the integral of the solid angle, 2 pi (1 - h / sqrt(h^2 + R^2)) over a disk's middle, which
// begins at its surface. Outside of a long cylinder it is 4 asin(R / r). With steps of half a voxel, up to 12 and 18 %
// were off.
TEST(Surfaces, LightARayThatMeetsThemByTheirClosedForm) {
    constexpr double kDepth = 1e-4;
    ViewScene scene = slab(kDepth, {0, 0, -1});
    const double sigma = kAlbedo * kDepth / kThickness, half = 0.5 * kThickness;
    const Vec3 ray = wsRays(scene.camera).origin(16.5, 16.5);
    Light& light = scene.lights.front();
    light.wsPosition = Vec3(ray.x, ray.y, -0.5);  // the slab is from -5.5 to 4.5
    light.wsDirection = {0, 0, 1};
    light.intensity = Rgb(1);
    for (const double radius : {0.3, 0.8, 3.0}) {
        Light::Area area;
        area.shape = AreaShape::disk;
        area.radius = radius;
        light.kind = area;
        const double disk = sigma / 2 * (half + radius - std::hypot(half, radius));
        EXPECT_NEAR(Reference(scene).ray(16.5, 16.5)[1], disk, 1e-2 * disk) << radius;

        area.shape = AreaShape::cylinder;
        area.width = 2000;
        light.kind = area;
        double sum = 0;
        constexpr int kSteps = 20000;
        for (int i = 0; i < kSteps; ++i) {
            const double u = (i + 0.5) / kSteps, r = radius + (half - radius) * u * u;  // finer at the surface
            sum += 4 * std::asin(radius / r) * 2 * u * (half - radius) / kSteps;
        }
        const double cylinder = sigma / (4 * kPi) * 2 * sum;
        EXPECT_NEAR(Reference(scene).ray(16.5, 16.5)[1], cylinder, 1e-2 * cylinder) << radius;
    }
}

// Two islands, and the same with the space between them filled with blocks of zeros, which are not skipped.
TEST(EmptySpace, SkippedDoesNotChangeAValue) {
    const auto islands = [](bool filled) {
        auto field = makeField({-60, -8, -8}, {60, 8, 8}, 1, [](const Vec3& is) {
            return std::max({0.0, 1 - glm::distance(is, {-50, 0, 0}) / 6, 1 - glm::distance(is, {45, 1, 0}) / 7});
        });
        if (filled) {
            std::vector<Int3> origins;
            auto values = std::make_shared<std::vector<float>>();
            for (int x = -80; x < 80; x += 8)
                for (int y = -24; y < 24; y += 8)
                    for (int z = -24; z < 24; z += 8) {
                        const Int3 origin(x, y, z);
                        const auto it = std::find(field->blockOrigins.begin(), field->blockOrigins.end(), origin);
                        origins.push_back(origin);
                        if (it == field->blockOrigins.end())
                            values->insert(values->end(), kBlockVoxels, 0.0f);
                        else {
                            const auto i = static_cast<std::size_t>(it - field->blockOrigins.begin());
                            const float* block = field->block(i);
                            values->insert(values->end(), block, block + kBlockVoxels);
                        }
                    }
            field->blockOrigins = origins;
            field->blockValues = std::shared_ptr<const float>(values, values->data());
        }
        ViewScene scene = orthographicScene(field, {0.5, Rgb(0.9), {}}, 30, 30);
        scene.camera.wsPosition = {200, 0, 0};
        scene.camera.wsFromCamera = lookAt(scene.camera.wsPosition, Vec3(0), {0, 1, 0});
        scene.lights.push_back(distantLight({1, 0.05, 0.02}));
        return scene;
    };
    const ViewScene sparse = islands(false), filled = islands(true);
    ASSERT_GT(filled.volumes[0].field->blockCount(), 5 * sparse.volumes[0].field->blockCount());
    // Steps begin elsewhere: their own error is what they may differ by.
    const ReferenceOptions fine{0.2, 0.1, 1e-9};
    const Reference a(sparse, fine), b(filled, fine);
    for (int y = 10; y < 20; y += 4)
        for (int x = 10; x < 20; x += 5) {
            const auto p = a.pixel(x, y), q = b.pixel(x, y);
            EXPECT_NEAR(p[0], q[0], 1e-3 * q[0] + 1e-9) << x << "," << y;
            EXPECT_NEAR(p[3], q[3], 1e-3 * q[3] + 1e-9) << x << "," << y;
        }
}

TEST(Pixel, IsTheMeanOfItsRays) {
    ViewScene scene = slab(0.5, {1, -1, -1});
    scene.dials.antialias = 2;
    const Reference reference(scene);
    const auto pixel = reference.pixel(3, 5);
    double mean = 0;
    for (const double dy : {0.25, 0.75})
        for (const double dx : {0.25, 0.75}) mean += reference.ray(3 + dx, 5 + dy)[0] / 4;
    EXPECT_NEAR(pixel[0], mean, 1e-15);
}

TEST(EmptyScene, IsBlackAndTransparent) {
    ViewScene scene = slab(1, {0, 0, -1});
    scene.volumes[0].field = std::make_shared<SparseField>();
    EXPECT_EQ(Reference(scene).pixel(16, 16), (std::array<double, 4>{0, 0, 0, 0}));
    EXPECT_EQ(Reference(scene).opticalDepth(Vec3(0), Vec3(1)), Rgb(0));
}

}  // namespace
}  // namespace scrim::test
