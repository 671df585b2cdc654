// SPDX-License-Identifier: Apache-2.0
// The mean of a lamp's light over the eye's path through a sheet, beside a sum over many points of the path.
#include <scrim/engine/shade/lamp_on_path.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <random>
#include <string>

#include <glm/geometric.hpp>

namespace scrim::test {
namespace {

constexpr float kTexel = 0.7f, kThickness = 0.9f;
constexpr int kPoints = 3000;

class Draw {
  public:
    explicit Draw(unsigned seed) : m_engine(seed) {}
    double in(double lower, double upper) { return std::uniform_real_distribution<double>(lower, upper)(m_engine); }

  private:
    std::mt19937 m_engine;
};

Vec3 axisOf(const NearOnSheet& lamp) {
    return {double(lamp.axisU), double(lamp.axisV), double(lamp.axisW)};
}

// A lamp 0.5 to 6 thicknesses before the sheet, whose axis points about along w.
NearOnSheet someLamp(Draw& draw) {
    NearOnSheet lamp;
    lamp.texelU = static_cast<Real>(draw.in(-3, 3));
    lamp.texelV = static_cast<Real>(draw.in(-3, 3));
    lamp.distanceW = static_cast<Real>(kThickness * draw.in(0.5, 6));
    const Vec3 axis = glm::normalize(Vec3(draw.in(-0.5, 0.5), draw.in(-0.5, 0.5), 1));
    lamp.axisU = static_cast<Real>(axis.x);
    lamp.axisV = static_cast<Real>(axis.y);
    lamp.axisW = static_cast<Real>(axis.z);
    return lamp;
}

NearOnSheet spot(Draw& draw) {
    NearOnSheet lamp = someLamp(draw);
    const double outer = draw.in(0.1, 0.7), inner = outer * draw.in(0.5, 0.95);
    lamp.cone = {static_cast<Real>(std::cos(outer)), static_cast<Real>(std::cos(inner))};
    return lamp;
}

std::unique_ptr<SampleTile> someSamples(Draw& draw) {
    auto samples = std::make_unique<SampleTile>();
    for (int k = 0; k < kTileSize; ++k) {
        samples->u[k] = static_cast<Real>(draw.in(-6, 6));
        samples->v[k] = static_cast<Real>(draw.in(-6, 6));
        samples->eyeA[k] = static_cast<Real>(draw.in(-2, 2));
        samples->eyeB[k] = static_cast<Real>(draw.in(-2, 2));
    }
    return samples;
}

// The way from the lamp to the path of sample k, where it is `place` world units along w from the sheet's middle.
Vec3 wayTo(const NearOnSheet& lamp, const SampleTile& samples, int k, double place) {
    return Vec3(double(samples.u[k] - lamp.texelU) * kTexel, double(samples.v[k] - lamp.texelV) * kTexel,
                double(lamp.distanceW)) +
           place * Vec3(double(samples.eyeA[k]), double(samples.eyeB[k]), 1);
}

// What a lamp sends to a point, by section 6 of the design and ZC02 eq. 5.
double lightAt(const NearOnSheet& lamp, const Vec3& way) {
    const double r2 = glm::dot(way, way), cosine = glm::dot(way, axisOf(lamp)) / std::sqrt(r2);
    double light = lamp.decay ? 1 / std::max(r2, double(lamp.ownRadius2)) : 1;
    if (lamp.cone) {
        const double outer = double(lamp.cone->cosOuter), inner = double(lamp.cone->cosInner);
        const double t = std::clamp((cosine - outer) / (inner - outer), 0.0, 1.0);
        light *= t * t * (3 - 2 * t);
    }
    if (lamp.face) {
        const double sine = std::sqrt(std::max(1 - cosine * cosine, 0.0));
        light *= std::max(std::max(cosine, 0.0) * double(lamp.face->spreadTangent) - sine, 0.0) *
                 double(lamp.face->spreadScale);
    }
    return light;
}

template <class Visit>
void alongPath(const Visit& visit) {
    for (int i = 0; i < kPoints; ++i) visit((double(i + 0.5) / kPoints - 0.5) * double(kThickness));
}

// What a sheet leaves of light at a place on the path of sample k, that comes along `way`.
double seen(const LampOnPath::Passage& passage, const SampleTile& samples, int k, double place, const Vec3& way) {
    const double a = double(samples.eyeA[k]), b = double(samples.eyeB[k]), in = 0.5 * double(kThickness) + place;
    const double eye = (passage.sameSide ? in : double(kThickness) - in) * std::sqrt(1 + a * a + b * b);
    return std::exp(-passage.extinction * (eye + (passage.attenuated ? in * glm::length(way) / way.z : 0)));
}

// Means over all paths that the lamp sees much of, beside sums, relative to the RMS of these. Three points of Gauss
// for each part of a cone have errors of some thousandths of the light.
void expectMeans(const std::function<NearOnSheet(Draw&)>& make, const LampOnPath::Passage& passage, double most,
                 const std::string& name) {
    const bool dims = name != "point";
    double squares = 0, all = 0;
    int asked = 0, dark = 0;
    for (unsigned seed = 1; seed <= 12; ++seed) {
        Draw draw(seed);
        const NearOnSheet lamp = make(draw);
        const auto samples = someSamples(draw);
        const LampOnPath onPath(lamp, kTexel, kThickness);
        for (int k = 0; k < kTileSize; k += 3) {
            const LampOnPath::Course course = onPath.courseOf(*samples, k);
            if (course == LampOnPath::Course::even) continue;
            const LampOnPath::Mean mean = onPath.over(*samples, k, passage);
            double sum = 0, even = 0;
            alongPath([&](double place) {
                const Vec3 way = wayTo(lamp, *samples, k, place);
                if (way.z > 0) sum += lightAt(lamp, way) * seen(passage, *samples, k, place, way) / kPoints;
                even += seen(passage, *samples, k, place, {mean.a, mean.b, 1}) / kPoints;
            });
            if (course == LampOnPath::Course::dark) {
                EXPECT_EQ(sum, 0) << name << ", seed " << seed << ", sample " << k;
                ++dark;
            }
            if (course != LampOnPath::Course::changing) continue;
            squares += std::pow(mean.irradiance - sum / even, 2);
            all += std::pow(sum / even, 2);
            ++asked;
        }
    }
    EXPECT_GT(asked, 100) << name;
    EXPECT_GT(dark, dims ? 50 : -1) << name;
    EXPECT_LE(std::sqrt(squares / all), most) << name;
}

TEST(LampOnPath, OfASpotIsTheMeanOverThePath) {
    expectMeans(spot, {}, 0.005, "spot");
}

TEST(LampOnPath, OfASpotThatDoesNotDecayIsTheMeanOverThePath) {
    const auto make = [](Draw& draw) {
        NearOnSheet lamp = spot(draw);
        lamp.decay = false;
        return lamp;
    };
    expectMeans(make, {}, 0.005, "no decay");
}

TEST(LampOnPath, OfASpotWithARadiusIsTheMeanOverThePath) {
    const auto make = [](Draw& draw) {
        NearOnSheet lamp = spot(draw);
        lamp.ownRadius2 = static_cast<Real>(std::pow(draw.in(0.1, 1), 2));
        return lamp;
    };
    expectMeans(make, {}, 0.01, "radius");
}

TEST(LampOnPath, OfASpreadIsTheMeanOverThePath) {
    const auto make = [](Draw& draw) {
        NearOnSheet lamp = someLamp(draw);
        const Spread spread(draw.in(5, 60));
        lamp.face = {static_cast<Real>(spread.tangent()), static_cast<Real>(spread.scale())};
        return lamp;
    };
    expectMeans(make, {}, 0.005, "spread");
}

TEST(LampOnPath, OfAPointIsTheMeanOverThePath) {
    expectMeans(someLamp, {}, 0.001, "point");
}

// What the eye or the light reaches later shows less, relative to even light.
TEST(LampOnPath, FadesAlongThePath) {
    for (const bool attenuated : {false, true})
        for (const bool sameSide : {false, true}) {
            expectMeans(spot, {0.4, attenuated, sameSide}, 0.005, "fade");
            expectMeans(someLamp, {0.4, attenuated, sameSide}, 0.005, "point");
        }
}

// Beside a sum over many points of paths close to a point.
TEST(LampOnPath, WeighsThePhaseFunctionByTheLight) {
    double squares = 0, all = 0;
    for (const double g : {0.6, -0.6, 0.9})
        for (unsigned seed = 1; seed <= 6; ++seed) {
            Draw draw(seed);
            const NearOnSheet lamp = someLamp(draw);
            const auto samples = someSamples(draw);
            const LampOnPath onPath(lamp, kTexel, kThickness);
            const Phase phase{g};
            const LampOnPath::Passage passage{0.4, true, seed % 2 == 0};
            for (int k = 0; k < kTileSize; k += 3) {
                if (onPath.courseOf(*samples, k) != LampOnPath::Course::changing) continue;
                const Vec3 eye = glm::normalize(Vec3(double(samples->eyeA[k]), double(samples->eyeB[k]), 1));
                double light = 0, scattered = 0;
                alongPath([&](double place) {
                    const Vec3 way = wayTo(lamp, *samples, k, place);
                    if (way.z <= 0) return;
                    const double cosine = glm::dot(way, eye) / glm::length(way);
                    const double here = lightAt(lamp, way) * seen(passage, *samples, k, place, way);
                    light += here;
                    scattered += here * phaseValue(phase, passage.sameSide ? -cosine : cosine);
                });
                squares += std::pow(onPath.phaseOver(*samples, k, passage, phase) - scattered / light, 2);
                all += std::pow(scattered / light, 2);
            }
        }
    EXPECT_GT(all, 0);
    EXPECT_LE(std::sqrt(squares / all), 0.002);
}

// The fraction of a spot's light beyond a plane across w: of six parts of each path those that cross the plane count by
// how much of them is beyond.
TEST(LampOnPath, WeighsWhatTheLightMeetsByTheLight) {
    constexpr double kPlane = 0.1;  // world units along w from the sheet's middle
    double squares = 0;
    int asked = 0;
    for (unsigned seed = 1; seed <= 40; ++seed) {
        Draw draw(seed);
        const NearOnSheet lamp = spot(draw);
        const auto samples = someSamples(draw);
        const LampOnPath onPath(lamp, kTexel, kThickness);
        const auto meets = [&](const SampleTile& part, Real* values) {
            for (int k = 0; k < kTileSize; ++k) {
                const double middle = double(part.at[k] - part.step) * kThickness,
                             half = std::max(0.5 * double(part.part[k]) * kThickness, 1e-9);
                values[k] = static_cast<Real>(std::clamp(0.5 + 0.5 * (middle - kPlane) / half, 0.0, 1.0));
            }
        };
        bool wanted[kTileSize];
        std::fill_n(wanted, kTileSize, true);
        alignas(64) Real means[kTileSize];
        if (!onPath.average(*samples, wanted, 1, meets, means)) continue;
        for (int k = 0; k < kTileSize; k += 3) {
            if (onPath.courseOf(*samples, k) != LampOnPath::Course::changing) continue;
            double sum = 0, beyond = 0;
            alongPath([&](double place) {
                const Vec3 way = wayTo(lamp, *samples, k, place);
                const double light = way.z > 0 ? lightAt(lamp, way) : 0;
                sum += light;
                beyond += place > kPlane ? light : 0;
            });
            if (sum == 0) continue;
            squares += std::pow(double(means[k]) - beyond / sum, 2);
            ++asked;
        }
    }
    EXPECT_GT(asked, 100);
    EXPECT_LE(std::sqrt(squares / asked), 0.02);
}

// Nothing limits a plain point, and what is far away hardly changes within a sheet.
TEST(LampOnPath, AsksForNoMeanWhereThereIsLittleToSee) {
    Draw draw(3);
    const auto samples = someSamples(draw);
    NearOnSheet lamp = someLamp(draw);
    EXPECT_FALSE(LampOnPath(lamp, kTexel, kThickness).limited());
    lamp.distanceW = 1e4f;
    EXPECT_FALSE(LampOnPath(lamp, kTexel, kThickness).changes(*samples));
    lamp = spot(draw);
    lamp.distanceW = 1e4f;
    const LampOnPath far(lamp, kTexel, kThickness);
    for (int k = 0; k < kTileSize; ++k) EXPECT_EQ(far.courseOf(*samples, k), LampOnPath::Course::even);
}

}  // namespace
}  // namespace scrim::test
