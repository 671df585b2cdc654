// SPDX-License-Identifier: Apache-2.0
// Light that scatters more than once: the path tracer against closed forms, the solver against closed forms and the
// path tracer, which share no code.
#include "scenes.h"
#include "support/meshes.h"
#include "support/slides.h"
#include "support/verified.h"

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/engine/plan/transport_plan.h>
#include <scrim/engine/solve/last_sweep.h>
#include <scrim/engine/solve/first_light.h>
#include <scrim/engine/cells/ordinates.h>
#include <scrim/engine/solve/scattered_light.h>
#include <scrim/verify/path_tracer.h>
#include <scrim/verify/pilot_picture.h>
#include <scrim/verify/reference.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <string>
#include <vector>

#include <glm/geometric.hpp>
#include <malloc.h>

namespace scrim::test {
namespace {

constexpr double kPi = std::numbers::pi;

Medium scatteringMedium(double sigma, double albedo, double g = 0) {
    Medium medium;
    medium.densityScale = sigma;
    medium.albedo = Rgb(albedo);
    medium.phase.g = g;
    medium.scattering = Scattering::full;
    return medium;
}

ViewScene smoke(double sigma, double albedo, double g, const Vec3& direction) {
    ViewScene scene = orthographicScene(smokeField(20), scatteringMedium(sigma, albedo, g), 44, 48);
    scene.lights = {distantLight(glm::normalize(direction))};
    scene.dials.texel = 0.5;
    scene.dials.sheetThickness = 0.5;
    return scene;
}

ViewScene smoke(double sigma, double albedo, const Phase& phase, const Vec3& direction) {
    ViewScene scene = smoke(sigma, albedo, 0, direction);
    scene.volumes[0].medium.phase = phase;
    return scene;
}

// Chandrasekhar's H-function of isotropic scattering, by iteration of his integral equation (Radiative Transfer, 1950,
// chapter V), in the form that converges also near albedo 1.
double chandrasekharH(double albedo, double mu) {
    constexpr int kNodes = 400;
    std::vector<double> h(kNodes, 1.0);
    const auto at = [](int i) { return (i + 0.5) / kNodes; };
    const auto next = [&](double m) {
        double sum = 0;
        for (int j = 0; j < kNodes; ++j) sum += 0.5 * albedo * at(j) * h[std::size_t(j)] / (m + at(j)) / kNodes;
        return 1 / (std::sqrt(1 - albedo) + sum);
    };
    for (int step = 0; step < 200; ++step) {
        std::vector<double> better(kNodes);
        for (int i = 0; i < kNodes; ++i) better[std::size_t(i)] = next(at(i));
        h = better;
    }
    return next(mu);
}

// What a slab of isotropic scatterers sends out along mu, from its lit side and from the other, for irradiance 1 across
// a beam along mu0: from its source function, by Schwarzschild and Milne's integral equation in layers of constant
// source.
struct SlabLight {
    double back = 0, through = 0;
};
SlabLight slabLight(double tau, double albedo, double mu0, double mu) {
    constexpr int kLayers = 300;
    const double h = tau / kLayers;
    const auto e1 = [](double x) { return -std::expint(-x); };
    const auto e2 = [&](double x) { return x > 0 ? std::exp(-x) - x * e1(x) : 1; };
    const auto e3 = [&](double x) { return 0.5 * (std::exp(-x) - x * e2(x)); };
    // Between layers j apart, the mean over one of the mean radiance that the other causes.
    std::vector<double> between(kLayers);
    between[0] = 1 - (0.5 - e3(h)) / h;
    for (int j = 1; j < kLayers; ++j)
        between[std::size_t(j)] = 0.5 * (e3((j - 1) * h) - 2 * e3(j * h) + e3((j + 1) * h)) / h;
    const auto beam = [&](int i) {
        return mu0 / h * (std::exp(-i * h / mu0) - std::exp(-(i + 1) * h / mu0)) / (4 * kPi);
    };
    std::vector<double> source(kLayers, 0.0);
    for (int step = 0; step < 300; ++step) {
        std::vector<double> next(kLayers);
        for (int i = 0; i < kLayers; ++i) {
            double mean = beam(i);
            for (int j = 0; j < kLayers; ++j) mean += between[std::size_t(std::abs(i - j))] * source[std::size_t(j)];
            next[std::size_t(i)] = albedo * mean;
        }
        source = next;
    }
    SlabLight out;
    for (int i = 0; i < kLayers; ++i) {
        const double s = source[std::size_t(i)], e = std::exp(-h / mu);
        out.back += s * std::exp(-i * h / mu) * (1 - e);
        out.through += s * std::exp(-(kLayers - 1 - i) * h / mu) * (1 - e);
    }
    return out;
}

// Where the same light comes from everywhere and nothing is absorbed, the same light is everywhere.
TEST(MultipleScattering, OfAnEvenGlowIsAlphaTimesTheGlow) {
    for (const double g : {0.0, 0.75}) {
        ViewScene scene = smoke(0.4, 1, g, {0, 0, -1});
        scene.lights.clear();
        scene.ambient = {1, 0.5, 0.25};
        scene.dials.scatterError = 1e-5;
        const Frame frame = renderScene(scene);
        EXPECT_TRUE(frame.scatterConverged);
        const PathTracer tracer(scene);
        double worst = 0;
        for (int y = 4; y < 48; y += 8)
            for (int x = 4; x < 48; x += 8) {
                const auto pixel = pixelOf(frame, x, y);
                for (std::size_t c = 0; c < 3; ++c)
                    worst = std::max(worst, std::abs(pixel[c] - scene.ambient[int(c)] * pixel[3]));
                // Every path ends in the glow, if it began in the smoke at all: so its light is alpha.
                const Estimate truth = tracer.pixel(x, y, 4000);
                EXPECT_NEAR(truth.mean.x, pixel[3], 5 * std::sqrt(truth.variance.x) + 0.004);
            }
        EXPECT_LT(worst, 1e-3) << g;
    }
}

// A thick slab, wide enough for its middle to know of no border.
TEST(MultipleScattering, OfAHalfSpaceIsChandrasekhars) {
    const double albedo = 0.9, sigma = 0.25;
    ViewScene scene = orthographicScene(boxField({-60, -60, -40}, {59, 59, -1}), scatteringMedium(sigma, albedo), 4, 4);
    scene.camera.wsPosition = {0, 0, 100};
    scene.dials.texel = 0.5;
    scene.dials.sheetThickness = 0.5;
    for (const double mu0 : {1.0, 0.5}) {
        scene.lights = {distantLight({std::sqrt(1 - mu0 * mu0), 0, -mu0})};
        // Radiance for irradiance 1 across the beam, towards mu = 1; that of single scattering is that with H = 1.
        const double once = albedo / (4 * kPi) * mu0 / (1 + mu0);
        const double exact = once * chandrasekharH(albedo, 1) * chandrasekharH(albedo, mu0);
        const Estimate truth = PathTracer(scene).pixel(2, 2, 60000);
        // Kernels make a soft edge of a voxel, which is a quarter of a mean free path here.
        EXPECT_NEAR(truth.mean.y + once, exact, 0.01 * exact + 3 * std::sqrt(truth.variance.y)) << mu0;
        scene.dials.scatterCell = 1;
        // Of first order in the cells: 2.2 % where they are a quarter of a mean free path thick, 4 % where a half.
        EXPECT_NEAR(pixelOf(renderScene(scene), 2, 2)[1], exact, 0.025 * exact) << mu0;
    }
}

// The same optical depths all across, so the soft edges of the slab do not matter.
TEST(MultipleScattering, OfASlabIsMilnes) {
    const double albedo = 0.95, sigma = 0.25, tau = 8 * sigma;
    ViewScene scene = orthographicScene(boxField({-60, -60, -8}, {59, 59, -1}), scatteringMedium(sigma, albedo), 4, 4);
    scene.dials.texel = 0.5;
    scene.dials.sheetThickness = 0.5;
    scene.dials.scatterCell = 1;
    for (const bool behind : {false, true})
        for (const double mu0 : {1.0, 0.6}) {
            scene.lights = {distantLight({std::sqrt(1 - mu0 * mu0), 0, behind ? mu0 : -mu0})};
            const SlabLight exact = slabLight(tau, albedo, mu0, 1);
            const double all = behind ? exact.through : exact.back;
            const double rendered = pixelOf(renderScene(scene), 2, 2)[1];
            // Of first order in the cells, a quarter of a mean free path: worst 2.4 %.
            EXPECT_NEAR(rendered, all, 0.03 * all) << mu0 << (behind ? " through" : " back");
            ViewScene once = scene;
            once.volumes[0].medium.scattering = Scattering::single;
            const double single = pixelOf(renderScene(once), 2, 2)[1];
            EXPECT_LT(single, 0.6 * all);
            const Estimate truth = PathTracer(scene).pixel(2, 2, 40000);
            EXPECT_NEAR(truth.mean.y + single, all, 0.01 * all + 3 * std::sqrt(truth.variance.y)) << mu0 << behind;
        }
}

// Helmholtz: light takes the same paths back. Sums over the picture, since every point of a beam counts.
TEST(MultipleScattering, IsTheSameWhereEyeAndLightChangePlaces) {
    for (const double g : {0.0, 0.7}) {
        ViewScene scene = smoke(0.4, 0.98, g, {1, 0, 0});
        scene.camera.height = 60;  // all of it
        const auto sum = [](const ViewScene& of) {
            const Frame frame = renderScene(of);
            double all = 0;
            for (int y = 0; y < 48; ++y)
                for (int x = 0; x < 48; ++x) all += pixelOf(frame, x, y)[1];
            return all;
        };
        // The light travels along x and, into the eye, along z; and back: along -z and into the eye along -x.
        const double there = sum(scene);
        scene.camera.wsPosition = {-100, 0, 0};
        scene.camera.wsFromCamera = lookAt(scene.camera.wsPosition, Vec3(0), {0, 1, 0});
        scene.lights = {distantLight({0, 0, -1})};
        EXPECT_NEAR(sum(scene) / there, 1, 0.02) << g;
    }
}

TEST(MultipleScattering, AgreesWithThePathTracer) {
    const Phase rayleigh{0, PhaseType::rayleigh}, two{0.7, PhaseType::twoLobe, -0.2, 0.3}, draine = drainePhase(0.5, 8);
    struct Case {
        double sigma, albedo;
        Phase phase;
        Vec3 light;
        int paths;
        double most;
    };
    for (const Case& c :
         {Case{0.3, 0.9, {}, {0.3, -0.2, -1}, 128, 0.02}, Case{0.3, 0.99, {}, {1, -1, 0}, 128, 0.02},
          Case{0.1, 0.99, {}, {-0.3, -0.2, 1}, 128, 0.02}, Case{1.2, 0.999, {}, {1, -1, 0.2}, 256, 0.03},
          Case{0.3, 0.99, rayleigh, {1, -1, 0}, 128, 0.02}, Case{0.3, 0.99, two, {0.2, 0.2, 1}, 256, 0.04},
          Case{0.3, 0.99, {0.75}, {0.2, 0.2, 1}, 256, 0.05}, Case{0.3, 0.99, {0.75}, {0.2, 0.2, -1}, 256, 0.04},
          Case{0.1, 0.95, {0.9}, {0.2, 0.2, 1}, 256, 0.05}, Case{0.3, 0.99, draine, {0.2, 0.2, 1}, 256, 0.04},
          Case{0.3, 0.99, dropletPhase(2), {1, -1, 0.2}, 256, 0.05}}) {
        ViewScene scene = smoke(c.sigma, c.albedo, c.phase, c.light);
        if (c.sigma > 1) scene.dials.scatterCell = 1;  // a cell of two voxels is 2.4 mean free paths thick
        const BlockError e = blockError(scene, c.paths);
        EXPECT_LT(e.error, c.most + e.noise) << "sigma " << c.sigma << " albedo " << c.albedo << " g " << c.phase.g
                                             << " light " << c.light.x << ", noise " << e.noise;
        EXPECT_GT(e.share, 0.1);  // without it the picture would be wrong by more than is allowed
    }
}

TEST(MultipleScattering, ConvergesWithTheCells) {
    std::vector<double> errors;
    for (const double cell : {8.0, 2.0}) {
        ViewScene scene = smoke(0.5, 0.99, 0, {1, -1, 0});
        scene.dials.scatterCell = cell;
        errors.push_back(blockError(scene, 256).error);
    }
    EXPECT_LT(errors[1], 0.5 * errors[0]) << errors[0] << " " << errors[1];
}

// A sun that grazes an opaque block: a bundle of rays to it starts beside the block and in it. Cells of 1, 2 and 4
// voxels are within 3 % of those of a half voxel (they were up to 1e5 times too bright).
TEST(MultipleScattering, BesideAnOpaqueBlockIsNoBrighterWithLargerCells) {
    const auto sum = [](double cell, double sigma) {
        ViewScene scene = orthographicScene(boxField({-2, -8, -8}, {5, -1, -1}), scatteringMedium(0.1, 0.7), 24, 24);
        scene.volumes.push_back(scene.volumes[0]);
        scene.volumes[1].field = boxField({-8, -8, -8}, {-1, -1, -1});
        scene.volumes[1].medium = scatteringMedium(sigma, 0.5);
        scene.volumes[1].medium.scattering = Scattering::single;
        scene.lights = {distantLight(glm::normalize(Vec3(-1, 0, -0.5)))};
        scene.dials.scatterCell = cell;
        const Frame frame = renderScene(scene);
        double all = 0;
        for (std::size_t i = 0; i < frame.image.rgba.size(); i += 4) all += double(frame.image.rgba[i]);
        return all;
    };
    for (const double sigma : {100.0, 1e5, 1e13}) {
        const double fine = sum(0.5, sigma);
        for (const double cell : {1.0, 2.0, 4.0})
            EXPECT_NEAR(sum(cell, sigma), fine, 0.04 * fine) << cell << " " << sigma;
    }
}

void fillSource(const ViewScene& scene, const CellMedia& media, const std::vector<ScatterClass>& classes,
                const Ordinates& set, TransportSolver& solver) {
    const FirstLight first(scene, planTransport(scene).targets.front(), 0, {media, media, classes, false}, solver);
    first.addTo(set, classes, media, {}, solver.clearedSource());
}

// What scatters unlike by colour is solved for each; the light's way to the cells is followed once, if it is the same.
TEST(MultipleScattering, TakesFirstLightOfOneColourForAnother) {
    for (const bool near : {false, true}) {
        ViewScene scene = smoke(1, 0.9, 0.5, {1, -1, 0.3});
        if (near) scene.lights = {lamp({0, 0, 0}, 1)};
        scene.lights.front().intensity = Rgb(1, 3, 0.5);
        const std::vector<ScatterClass> classes = scatterClasses(scene, 64);
        const CellMedia media = cellMedia(scene, classes, 2, Simd());
        const Ordinates set = ordinates(64);
        TransportSolver solver(media, classes, {set, 1e-3, 60, {}, {}});
        const auto light = [&](int colour) {
            return FirstLight(scene, planTransport(scene).targets.front(), colour, {media, media, classes, false},
                              solver);
        };
        const auto source = [&](const FirstLight& first) {
            first.addTo(set, classes, media, {}, solver.clearedSource());
            return solver.source();
        };
        FirstLight turned = light(0);
        ASSERT_TRUE(turned.turnTo(1, media, media));
        const std::vector<Real> ofTurned = source(turned), ofOwn = source(light(1));
        double most = 0;
        for (const Real own : ofOwn) most = std::max(most, double(own));
        for (std::size_t i = 0; i < ofOwn.size(); ++i) ASSERT_NEAR(ofTurned[i], ofOwn[i], 1e-6 * most) << i;
        EXPECT_GT(most, 0);

        CellMedia tinted = media;
        tinted.extinction.assign(3, media.extinction.front());
        EXPECT_FALSE(turned.turnTo(2, tinted, tinted));
        scene.lights.front().intensity = Rgb(0, 1, 1);
        EXPECT_FALSE(light(0).turnTo(1, media, media));
    }
}

// Cells twice as large do most of the work.
TEST(MultipleScattering, TakesFewSweepsHoweverOftenLightScatters) {
    const ViewScene scene = smoke(1, 0.999, 0, {1, -1, 0});
    const std::vector<ScatterClass> classes = scatterClasses(scene, 64);
    const CellMedia media = cellMedia(scene, classes, 2, Simd());
    const auto solve = [&](int most) {
        const Ordinates set = ordinates(64);
        TransportSolver solver(media, classes, {set, 1e-3, most, {}, {}});
        fillSource(scene, media, classes, set, solver);
        return solver.solve(0, {});
    };
    const Solved fast = solve(60), stopped = solve(2);
    EXPECT_TRUE(fast.converged);
    EXPECT_LE(fast.sweeps, 12);
    EXPECT_FALSE(stopped.converged);
    EXPECT_GT(stopped.error, 1e-3);
}

// In thick smoke each scattering changes little, and hundreds of them much: the last sweep's change is no measure.
TEST(MultipleScattering, EndsItsSweepsWhereLittleIsLeftNotWhereOneChangesLittle) {
    for (const double g : {0.0, 0.6}) {
        const ViewScene scene = smoke(4, 0.999, g, {1, -1, 0});
        const std::vector<ScatterClass> classes = scatterClasses(scene, 64);
        const CellMedia media = cellMedia(scene, classes, 2, Simd());
        const auto solve = [&](double tolerance, Solved& solved) {
            const Ordinates set = ordinates(64);
            TransportSolver solver(media, classes, {set, tolerance, 200, {}, {}});
            fillSource(scene, media, classes, set, solver);
            solved = solver.solve(0, {});
            return solver.radiance();
        };
        Solved some, exact;
        const std::vector<Real> ended = solve(0.01, some), truth = solve(1e-4, exact);
        double off = 0, all = 0;
        for (std::size_t i = 0; i < truth.size(); ++i) {
            off += std::abs(double(ended[i] - truth[i]));
            all += double(truth[i]);
        }
        EXPECT_TRUE(some.converged && exact.converged)
            << some.error << " " << exact.error << " " << some.sweeps << " " << exact.sweeps;
        EXPECT_LE(some.error, 0.01);
        EXPECT_LT(off / all, 2 * some.error) << "g = " << g;  // an estimate
    }
}

// The mean radiance in each cell of light that has scattered, by a last sweep along `count` ordinates.
std::vector<double> meansByLastSweep(const ViewScene& scene, int count) {
    const std::vector<ScatterClass> classes = scatterClasses(scene, solvedOrdinates(count));
    const CellMedia media = cellMedia(scene, classes, 2, Simd());
    const Ordinates set = ordinates(solvedOrdinates(count));
    TransportSolver solver(media, classes, {set, 1e-3, 60, {}, {}});
    LastSweep last(scene, media, classes, count, {}, solver, {});
    const FirstLight first(scene, planTransport(scene).targets.front(), 0, {media, last.media(), last.classes(), true},
                           solver);
    first.addTo(set, classes, media, {}, solver.clearedSource());
    EXPECT_TRUE(solver.solve(0, {}).converged);
    const auto kept = last.pass(0, {}, true, [&](const Ordinates& along, std::vector<Real>& source) {
        first.addTo(along, last.classes(), last.media(), {}, source);
    });
    std::vector<double> means(kept[0].begin(), kept[0].end());
    for (std::size_t row = 0; row < means.size() && !first.straight().empty(); ++row)
        means[row] += double(first.straight()[0][row]);
    return means;
}

// The last sweep splits phase functions differently, and has other directions: light as a whole remains. A solve with
// 64 directions shows their rays: with 128 in the last sweep what is off, beside 256, is less than 0.65 of that. (A
// last sweep that shows only what scatters of the solve, and not what scatters for the first time, would lose a half of
// it.)
TEST(MultipleScattering, ShowsAsMuchLightWithFewerRaysAlongMoreDirections) {
    for (const double g : {0.0, 0.75}) {
        const ViewScene scene = smoke(1, 0.99, g, {1, -1, 0.3});
        const std::vector<double> few = meansByLastSweep(scene, 64), more = meansByLastSweep(scene, 128),
                                  truth = meansByLastSweep(scene, 256);
        double all = 0, off[2] = {0, 0}, sum[2] = {0, 0};
        for (std::size_t row = 0; row < truth.size(); ++row) {
            all += truth[row];
            for (int i = 0; i < 2; ++i) {
                const double difference = (i == 0 ? few : more)[row] - truth[row];
                sum[i] += difference;
                off[i] += std::abs(difference);
            }
        }
        EXPECT_LT(std::abs(sum[0]), 0.01 * all) << g;
        EXPECT_LT(std::abs(sum[1]), 0.01 * all) << g;
        EXPECT_LT(off[1], 0.65 * off[0]) << g << ": " << off[0] / all << " " << off[1] / all;
    }
}

TEST(MultipleScattering, IsNowhereBelowZero) {
    ViewScene scene = smoke(3, 0.9, 0.6, {1, 0, 0});
    Solved solved;
    std::size_t bytes = 0;
    const std::vector<CellLight> light = scatteredLight(scene, planTransport(scene), {}, {}, solved, bytes);
    SampleTile samples{};
    std::array<Real, kTileSize> rows[3];
    Real* const rgb[3] = {rows[0].data(), rows[1].data(), rows[2].data()};
    const std::vector<Real> everywhere(kTileSize, Real(1));
    for (int i = 0; i < kTileSize; ++i) {
        samples.u[i] = static_cast<Real>(i % 16 * 3 - 24);
        samples.v[i] = static_cast<Real>(i / 16 * 3 - 24);
    }
    double most = 0;
    for (double z = -22; z < 22; z += 0.7) {
        light.front().ofVolume.front()->lookUp({{0, 0, z}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, samples, everywhere.data(),
                                               rgb);
        for (const Real value : rows[0]) {
            EXPECT_GE(value, 0);
            most = std::max(most, double(value));
        }
    }
    EXPECT_GT(most, 0.01);
}

// Cells stand still in the world, so a lamp lies anywhere in its cell, where 1/r^2 has no bound. As everything moves by
// parts of a cell, sums of the picture differ by 0.3 and 0.6 % (with 1/r^2 at the centres of cells 3.5 and 2.4 %), and
// squares of 4 x 4 pixels by 0.8 and 1.2 % of the brightest (2.3 and 3.5 %).
TEST(MultipleScattering, ALampMayLieAnywhereInItsCell) {
    constexpr int kSize = 44, kSquare = 4, kAlong = kSize / kSquare;
    for (const double g : {0.0, 0.6}) {
        std::vector<std::array<double, kAlong * kAlong>> all;
        for (const double shift : {0.0, 0.31, 0.62, 0.93}) {
            ViewScene scene = orthographicScene(smokeField(20), scatteringMedium(0.1, 0.95, g), kSize, kSize);
            scene.lights = {lamp(Vec3(2.3, 1.1, 4.2) + shift, 100)};
            scene.volumes[0].wsFromIs[3] += glm::dvec4(Vec3(shift), 0);
            scene.camera.wsPosition += shift;
            scene.dials.scatterCell = 1;
            scene.dials.scatterDirections = 64;
            const Frame frame = renderScene(scene);
            auto& squares = all.emplace_back();
            for (int i = 0; i < kSize * kSize; ++i)
                squares[std::size_t(i / kSize / kSquare * kAlong + i % kSize / kSquare)] +=
                    double(frame.image.rgba[std::size_t(4 * i)]);
        }
        double most = 0;
        std::array<double, 4> sums{};
        for (std::size_t s = 0; s < all.size(); ++s)
            for (std::size_t i = 0; i < all[s].size(); ++i) {
                sums[s] += all[s][i];
                most = std::max(most, std::abs(all[s][i] - all[0][i]));
            }
        const auto [least, largest] = std::ranges::minmax(sums);
        EXPECT_LT(largest / least, 1.01) << g;
        EXPECT_LT(most, 0.016 * *std::ranges::max_element(all[0])) << g;
    }
}

TEST(MultipleScattering, LayersAddUpToTheBeauty) {
    ViewScene scene = smoke(0.3, 0.95, 0.3, {1, -1, 0});
    scene.lights.push_back(lamp({0, 30, 10}, 500));
    scene.lights.back().intensity = {500, 200, 100};
    scene.ambient = {0.02, 0.03, 0.05};
    scene.volumes[0].emission = {{flameField(), {0.2, 0.1, 0.05}}};
    const Frame plain = renderScene(scene);
    scene.layers = {Layer::light, Layer::ambient, Layer::emission};
    const Frame layered = renderScene(scene);
    ASSERT_EQ(layered.layers.size(), 4u);
    double most = 0, worst = 0, apart = 0;
    for (std::size_t i = 0; i < plain.image.rgba.size() / 4; ++i)
        for (std::size_t c = 0; c < 3; ++c) {
            double sum = 0;
            for (const FrameLayer& layer : layered.layers) sum += double(layer.data[3 * i + c]);
            most = std::max(most, double(plain.image.rgba[4 * i + c]));
            worst = std::max(worst, std::abs(sum - double(layered.image.rgba[4 * i + c])));
            apart = std::max(apart, std::abs(sum - double(plain.image.rgba[4 * i + c])));
        }
    EXPECT_LT(worst, 1e-5 * most);
    EXPECT_LT(apart, 0.005 * most);  // solved one by one each stops at its own scatter_error
}

// In a grey medium a solve serves all light of one colour, whatever the colour. Red, green and blue light alone have
// one colour each.
TEST(MultipleScattering, TakesOneSolveForEachColourOfLight) {
    ViewScene scene = smoke(0.3, 0.95, 0.3, {1, -1, 0});
    scene.lights[0].intensity = {3, 2, 1};
    scene.lights.push_back(lamp({0, 30, 10}, 500));
    scene.lights.back().intensity = {600, 400, 200};
    scene.ambient = {0.1, 0.3, 0.5};
    EXPECT_EQ(solvesOf(scene, planTransport(scene)), 2);
    const Frame all = renderScene(scene);
    for (int c = 0; c < 3; ++c) {
        ViewScene one = scene;
        Rgb only(0);
        only[c] = 1;
        for (Light& light : one.lights) light.intensity *= only;
        one.ambient *= only;
        EXPECT_EQ(solvesOf(one, planTransport(one)), 1);
        const Frame alone = renderScene(one);
        double most = 0, off = 0;
        for (std::size_t i = std::size_t(c); i < all.image.rgba.size(); i += 4) {
            most = std::max(most, double(all.image.rgba[i]));
            off = std::max(off, std::abs(double(all.image.rgba[i] - alone.image.rgba[i])));
        }
        EXPECT_GT(most, 0.1);
        EXPECT_LT(off, 0.005 * most) << c;  // each solve ends at its own scatter_error
    }
}

Frame renderApart(ViewScene scene) {
    scene.layers = {Layer::indirect};
    return renderScene(scene);
}

// What is left without the layer of light that has scattered more than once is the picture in which light scatters
// once: exactly for lights with shadow buffers, whose first scattering is another computation than all others. An
// octave is one more scattering.
TEST(MultipleScattering, IsALayerOfItsOwnBesideSingleScattering) {
    ViewScene full = smoke(0.3, 0.95, 0.3, {1, -1, 0});
    full.lights.push_back(lamp({0, 30, 10}, 500));
    full.dials.shade = ShadeMode::pixel;
    for (Light& light : full.lights) light.shadow = ShadowMethod::buffers;
    ViewScene octaves = full, single = full;
    single.volumes[0].medium.scattering = Scattering::single;
    octaves.volumes[0].medium.scattering = Scattering::octaves;
    octaves.volumes[0].medium.octaves = {4, 0.5, 0.5, 0.5};
    const Frame once = renderScene(single), none = renderApart(single);
    EXPECT_EQ(none.layers[0].data, std::vector<float>(none.layers[0].data.size()));
    for (const ViewScene& scene : {full, octaves}) {
        const Frame plain = renderScene(scene), apart = renderApart(scene);
        double most = 0, indirect = 0;
        for (const float value : plain.image.rgba) most = std::max(most, double(value));
        for (std::size_t i = 0; i < plain.image.rgba.size() / 4; ++i)
            for (std::size_t c = 0; c < 3; ++c) {
                const std::size_t at = 4 * i + c;
                const double again = double(apart.layers[0].data[3 * i + c]);
                indirect = std::max(indirect, again);
                ASSERT_NEAR(apart.image.rgba[at], plain.image.rgba[at], 1e-6 * most) << i;
                // Sums of a few hundred floats.
                ASSERT_NEAR(apart.image.rgba[at] - again, once.image.rgba[at], 3e-5 * most) << i;
            }
        EXPECT_GT(indirect, 0.05 * most);
    }
}

// Skies and ambient light come in through the border of the cells: of that light, too, the first scattering is apart.
// As cells get smaller, it becomes the picture in which the sky's light scatters once, which has cells of its own.
TEST(MultipleScattering, OfASkyIsALayerOfItsOwn) {
    ViewScene scene = smoke(0.3, 0.9, 0, {0, -1, 0});
    Light dome;
    dome.kind = Light::Dome{};
    dome.intensity = Rgb(1);
    scene.lights = {dome};
    scene.dials.scatterCell = 1;
    scene.dials.lightCell = 1;
    scene.dials.lightError = 0.002;
    ViewScene single = scene;
    single.volumes[0].medium.scattering = Scattering::single;
    const Frame plain = renderScene(scene), apart = renderApart(scene), once = renderScene(single);
    double squares = 0, sum = 0, all = 0, changed = 0;
    for (std::size_t i = 0; i < plain.image.rgba.size() / 4; ++i) {
        const double direct = double(apart.image.rgba[4 * i]) - double(apart.layers[0].data[3 * i]);
        squares += std::pow(direct - double(once.image.rgba[4 * i]), 2);
        sum += std::pow(double(once.image.rgba[4 * i]), 2);
        all += double(plain.image.rgba[4 * i]);
        changed = std::max(changed, std::abs(double(plain.image.rgba[4 * i]) - double(apart.image.rgba[4 * i])));
    }
    EXPECT_LT(std::sqrt(squares / sum), 0.03);
    EXPECT_GT(all, 1.5 * std::sqrt(sum));
    EXPECT_LT(changed, 1e-5);
    // Ambient light is a sky of one colour.
    scene.lights.clear();
    scene.ambient = Rgb(1);
    const Frame ambient = renderApart(scene);
    for (std::size_t i = 0; i < plain.image.rgba.size() / 4; ++i)
        ASSERT_NEAR(ambient.layers[0].data[3 * i], apart.layers[0].data[3 * i], 1e-4) << i;
}

// A cloud beside smoke in which light scatters once and which no light lights: all of its light comes from the cloud,
// and part of it goes back. The path tracer lets such smoke scatter one time of a path.
TEST(MultipleScattering, LightsSmokeThatScattersOnceAndIsLitByIt) {
    for (const double g : {0.0, 0.5})
        for (const bool linked : {false, true}) {
            ViewScene scene = smoke(0.4, 0.99, g, {1, -0.5, -0.3});
            scene.volumes.push_back(scene.volumes[0]);
            ViewVolume& once = scene.volumes.back();
            once.medium.scattering = Scattering::single;
            once.medium.densityScale = 0.1;
            once.wsFromIs[3] = {26, 3, 0, 1};
            if (!linked) once.lights = {false};
            scene.camera.height = 90;
            const BlockError e = blockError(scene, 256);
            EXPECT_LT(e.error, 0.03 + e.noise) << g << " " << linked;
            // Without light between them: the smoke that no light lights is black.
            const Frame frame = renderScene(scene);
            EXPECT_GT(pixelOf(frame, 39, 24)[1], linked ? 0.0 : 1e-4) << g;
        }
}

// What glows lights the smoke around it, and the sky is shadowed by it.
TEST(MultipleScattering, OfFireAndSkyAgreesWithThePathTracer) {
    for (const bool sky : {false, true}) {
        ViewScene scene = smoke(0.3, 0.9, 0, {0, -1, 0});
        scene.lights.clear();
        if (sky)
            scene.ambient = Rgb(1);
        else
            scene.volumes[0].emission = {{flameField(), {1, 0.5, 0.2}}};
        const BlockError e = blockError(scene, 128);
        EXPECT_LT(e.error, 0.02 + e.noise) << sky;
        EXPECT_GT(e.share, sky ? 0.9 : 0.1) << sky;
    }
}

// A dome through the border of the cells is the dome of the reference, where nothing scatters twice.
TEST(MultipleScattering, OfADomeIsTheDomeWhereLightScattersOnce) {
    ViewScene scene = smoke(0.3, 1e-3, 0, {0, -1, 0});
    Light dome;
    dome.kind = Light::Dome{};
    dome.intensity = Rgb(1);
    scene.lights = {dome};
    scene.dials.lightError = 0.002;
    scene.dials.scatterCell = 1;
    const Frame frame = renderScene(scene);
    EXPECT_EQ(frame.work.lightSamples, 0u);
    std::vector<VerifiedPixel> pixels;
    for (int i = 0; i < 32; ++i) pixels.push_back({6 + i % 8 * 5, 6 + i / 8 * 10, {}, {}, {}});
    EXPECT_LT(std::abs(greenBias(scene, frame, pixels)), 0.005);
}

// Light that nothing holds back arrives everywhere alike, so that smoke shines as fire of its density does. What
// comes in at the border, held back, is 85 % off.
TEST(MultipleScattering, OfADomeWithoutShadowsIsThatOfEvenFire) {
    ViewScene scene = smoke(0.3, 0.9, 0, {0, -1, 0});
    Light dome;
    dome.kind = Light::Dome{};
    dome.intensity = Rgb(1);
    dome.shadows = false;
    scene.lights = {dome};
    scene.dials.scatterCell = 1;
    const Image lit = renderScene(scene).image;
    scene.lights.clear();
    scene.volumes[0].emission = {{{scene.volumes[0].field, scene.volumes[0].wsFromIs}, Rgb(0.3 * 0.9)}};
    const Image glows = renderScene(scene).image;
    EXPECT_LT(differenceOf(lit, glows).error, 0.03);
}

// None of the directions goes without where the picture has fewer pixels than there are directions.
TEST(MultipleScattering, OfASkyOfOnePixelIsThatOfTheColour) {
    ViewScene scene = smoke(0.3, 0.9, 0, {0, -1, 0});
    Light dome;
    dome.kind = Light::Dome{};
    dome.intensity = {1, 0.5, 0.25};
    scene.lights = {dome};
    const Frame colour = renderScene(scene);
    scene.lights[0].intensity = Rgb(1);
    scene.lights[0].slide.emplace();
    scene.lights[0].slide->image = makeTexture(1, 1, [](int, int) { return Rgb(1, 0.5, 0.25); });
    const Frame picture = renderScene(scene);
    for (std::size_t i = 0; i < colour.image.rgba.size(); ++i)
        ASSERT_NEAR(picture.image.rgba[i], colour.image.rgba[i], 2e-3 * colour.image.rgba[i] + 1e-7) << i;
}

// Lobes that no float holds: light still goes somewhere, and no pixel is NaN, infinite or below zero.
TEST(MultipleScattering, OfLobesNextToALineIsFinite) {
    for (const Scattering scattering : {Scattering::single, Scattering::full})
        for (const double g : {0.99, 0.99999999, 1 - 1e-15})
            for (const double sign : {1.0, -1.0})
                for (const bool two : {false, true}) {
                    // Straight at the eye and away from it, where the lobe's middle is.
                    for (const Vec3& way : {Vec3(0, 0, 1), Vec3(0, 0, -1)}) {
                        ViewScene scene = smoke(0.3, 0.95, sign * g, way);
                        scene.volumes[0].medium.scattering = scattering;
                        if (two) scene.volumes[0].medium.phase = {0.3, PhaseType::twoLobe, sign * g, 0.7};
                        scene.camera.resolution = Int2(12);
                        scene.region = {0, 0, 12, 12};
                        const Frame frame = renderScene(scene);
                        for (const float v : frame.image.rgba) ASSERT_TRUE(std::isfinite(v) && v >= 0) << g << " " << v;
                    }
                }
}

TEST(MultipleScattering, CostsNothingWhereNobodyAsksForIt) {
    const Frame frame = renderScene(plainScene());
    EXPECT_EQ(frame.work.scatterSweeps, 0u);
    EXPECT_EQ(frame.work.scatterDirections, 0u);
    EXPECT_EQ(frame.work.shade.scattered, 0u);
    EXPECT_EQ(frame.work.bytes.scattered, 0u);
}

TEST(MultipleScattering, CountsItsMemoryBesideThatOfTheSweeps) {
    const ViewScene scene = smoke(0.3, 0.95, 0.3, {1, -1, 0});
    ViewScene once = scene;
    once.volumes[0].medium.scattering = Scattering::single;
    const RenderWork::Bytes all = renderScene(scene).work.bytes, sweeps = renderScene(once).work.bytes;
    EXPECT_GT(all.scattered, 0u);
    EXPECT_EQ(all.shadows, sweeps.shadows);
    EXPECT_EQ(all.picture, sweeps.picture);
    EXPECT_GT(all.total(), std::max(all.scattered, sweeps.total()));
}

#ifndef SCRIM_SANITIZED  // sanitizers have an allocator of their own

// Bytes of this process that are allocated.
std::size_t allocated() {
    const struct mallinfo2 all = ::mallinfo2();
    return all.uordblks + all.hblkhd;
}

// Lights of many points, layers with a solve each, narrow phase functions with more directions, media that scatter
// once, and walls that send light back: all that takes memory.
std::map<std::string, ViewScene> hungryScenes() {
    std::map<std::string, ViewScene> all;
    const ViewScene even = smoke(0.3, 0.95, 0, {1, -1, 0});
    all["even"] = even;
    ViewScene& points = all["even, many points"] = even;
    for (int i = 0; i < 4; ++i) {
        Light disk = distantLight({1, -1, 0.2 * i}, 1);
        disk.kind = Light::Distant(30);
        disk.samples = 40;
        points.lights.push_back(disk);
    }
    ViewScene& layers = all["even, layers"] = points;
    layers.layers = {Layer::light, Layer::indirect, Layer::ambient};
    layers.ambient = Rgb(0.1);
    ViewScene& directions = all["even, 256 directions"] = even;
    directions.dials.scatterDirections = 256;
    for (const double g : {0.5, 0.75, 0.9}) all["g = " + std::to_string(g)] = smoke(0.3, 0.95, g, {1, -1, 0});
    ViewScene& narrow = all["g = 0.5, many points"] = points;
    for (ViewVolume& volume : narrow.volumes) volume.medium.phase.g = 0.5;
    ViewScene& box = all["a box, g = 0.5, many points"] = narrow;
    box.volumes = orthographicScene(boxField({-20, -20, -20}, {19, 19, 19}), narrow.volumes[0].medium, 44, 48).volumes;
    ViewScene& evenBox = all["a box, many points"] = box;
    evenBox.volumes[0].medium.phase.g = 0;
    const Solid wall{"wall", squareMesh({0, 0, 3}, {0, 0, 1}, 15), Mat4(1.0), false, true, false, Rgb(0.8)};
    for (const std::string name : {"even, many points", "g = 0.5, many points"}) {
        ViewScene& walled = all[name + ", a wall"] = all.at(name);
        walled.solids = std::make_shared<const Solids>(std::vector<Solid>{wall});
    }
    ViewScene& mixed = all["g = 0.5, another scatters once"] = narrow;
    mixed.volumes.push_back(mixed.volumes.front());
    mixed.volumes.back().medium.scattering = Scattering::single;
    return all;
}

TEST(MultipleScattering, TakesNoMoreMemoryThanThePlanSays) {
    for (const auto& [name, scene] : hungryScenes()) {
        const TransportPlan plan = planTransport(scene);
        const std::size_t before = allocated();
        std::size_t most = 0, told = 0;
        Solved solved;
        const auto look = [&] { most = std::max(most, allocated() - before); };
        const auto light = scatteredLight(scene, plan, {}, look, solved, told);
        EXPECT_LE(most, plan.bytes) << name;
        // What is not told are a sweep's small vectors. The plan only estimates how many cells there are.
        EXPECT_GT(double(told), 0.9 * double(most)) << name;
        EXPECT_LT(double(told), 1.1 * double(plan.bytes)) << name;
    }
}

#endif

TEST(MultipleScattering, OfACropIsThatOfTheWhole) {
    ViewScene scene = smoke(0.3, 0.95, 0.3, {1, -1, 0});
    const Frame whole = renderScene(scene);
    scene.region = {10, 12, 30, 26};
    const Frame crop = renderScene(scene);
    for (int y = 12; y < 26; ++y)
        for (int x = 10; x < 30; ++x) {
            const float* p = crop.image.rgba.data() + crop.image.indexOf(x, y);
            for (std::size_t c = 0; c < 3; ++c) EXPECT_NEAR(p[c], pixelOf(whole, x, y)[c], 2e-4);
        }
}

TEST(MultipleScattering, OfTooManyCellsIsRefused) {
    ViewScene scene = smoke(0.3, 0.95, 0, {1, -1, 0});
    scene.memoryLimit = 1 << 20;
    try {
        planTransport(scene);
        FAIL();
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("raise scatter_cell"), std::string::npos) << error.what();
    }
}

// Under a white sky all that scatters without loss is as white, also where only the rims of kernels are.
TEST(MultipleScattering, IsWhiteUnderAWhiteSkyToTheRimOfKernels) {
    for (const Kernel kernel : {Kernel::linear, Kernel::bspline, Kernel::gaussian})
        for (const double cell : {0.5, 1.0, 2.0}) {
            ViewScene scene = orthographicScene(boxField(Int3(-6), Int3(5)), Medium(), 20, 40);
            Medium& medium = scene.volumes[0].medium;
            medium.densityScale = 0.5;
            medium.albedo = Rgb(1);
            medium.scattering = Scattering::full;
            scene.dials.kernel = kernel;
            scene.dials.scatterCell = cell;
            scene.ambient = Rgb(1);
            const Frame frame = renderScene(scene);
            double seen = 0;
            for (int y = 0; y < 40; ++y)
                for (int x = 0; x < 40; ++x) {
                    const auto pixel = pixelOf(frame, x, y);
                    if (pixel[3] < 0.005) continue;
                    ++seen;
                    // With cells of half a voxel, light ends half a cell before linear kernels do.
                    const double most = kernel == Kernel::linear && cell < 1 ? 0.2 : 0.05;
                    EXPECT_NEAR(pixel[0] / pixel[3], 1, most) << nameOf(kernel) << " " << cell << " " << x << " " << y;
                }
            EXPECT_GT(seen, 500);
        }
}

}  // namespace
}  // namespace scrim::test
