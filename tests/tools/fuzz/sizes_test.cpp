// SPDX-License-Identifier: Apache-2.0
// Sizes: legal dials, pictures and crops that ask for rasters beyond what 32 bits count. A render ends with a picture,
// or says why it cannot be made; under the address sanitizer nothing is read or written that is not its own.
// SCRIM_SIZES_RUNS=N asks for N scenes, of which each takes seconds.
#include "support/fields.h"

#include <scrim/base/error.h>
#include <scrim/engine/plan/make_plan.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <random>
#include <string>
#include <vector>

namespace scrim::test {
namespace {

constexpr double kPast32Bits = 2147483648.0;

// A few blocks far apart: rasters are as large as the way between them, and nearly all of their tiles stay untouched.
std::shared_ptr<SparseField> farApart(const Int3& size) {
    auto field = std::make_shared<SparseField>();
    auto values = std::make_shared<std::vector<float>>();
    for (const Int3& corner : {Int3(0), Int3(size.x, 0, 0), Int3(size.x / 2, size.y / 2, size.z), size}) {
        const Int3 origin = corner >> 3 << 3;
        if (!field->blockOrigins.empty() && field->blockOrigins.back() == origin) continue;
        field->blockOrigins.push_back(origin);
        values->insert(values->end(), kBlockVoxels, 0.05f);
    }
    std::sort(field->blockOrigins.begin(), field->blockOrigins.end(),
              [](const Int3& a, const Int3& b) { return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z); });
    field->blockOrigins.erase(std::unique(field->blockOrigins.begin(), field->blockOrigins.end()),
                              field->blockOrigins.end());
    values->resize(field->blockCount() * kBlockVoxels);
    field->blockValues = std::shared_ptr<const float>(values, values->data());
    field->activeVoxels = values->size();
    field->maxValue = 0.05f;
    return field;
}

struct Drawn {
    ViewScene scene;
    std::string text;
};

Drawn drawScene(std::mt19937& random) {
    const auto among = [&](auto... values) {
        const double all[] = {double(values)...};
        return all[random() % std::size(all)];
    };
    const auto upTo = [&](int n) { return static_cast<int>(random() % static_cast<unsigned>(n)); };
    const Int3 size(int(among(8, 64, 1200, 5000, 40000)), int(among(8, 64, 1200, 5000, 40000)),
                    int(among(0, 2, 8, 40)));
    Drawn out;
    ViewScene& scene = out.scene;
    const double height = among(1, 0.01, 3) * std::max(size.x, size.y);
    scene = orthographicScene(farApart(size), {}, height, int(among(16, 64, 300)));
    scene.camera.wsPosition += Vec3(0.5 * size.x, 0.5 * size.y, 0);
    if (upTo(2) == 0) {
        scene.camera.type = CameraType::perspective;
        scene.camera.fov = among(1, 20, 60);
    }
    if (upTo(4) == 0) scene.camera.resolution *= 200;
    Dials& dials = scene.dials;
    dials.texel = among(0.05, 0.07, 0.25, 1);
    dials.sheetThickness = among(0.25, 1, 8);
    dials.shadowTexel = among(0.1, 1, 4);
    dials.shade = upTo(2) == 0 ? ShadeMode::texel : ShadeMode::pixel;
    dials.splat = upTo(5) == 0 ? SplatMode::perView : SplatMode::shared;
    dials.antialias = int(among(1, 1, 2, 16));
    const int lights = int(among(0, 1, 15, 60));
    for (int i = 0; i < lights; ++i) {
        scene.lights.push_back(distantLight(Vec3(0.3 * std::sin(i), 0.3 * std::cos(i), -1)));
        scene.lights.back().name = "light" + std::to_string(i);
    }
    if (upTo(2) == 0) scene.layers = {Layer::light, Layer::depth, Layer::albedo};
    // A crop somewhere, often at the far end.
    const Int2 picture = scene.camera.resolution, crop(std::min(picture.x, 16), std::min(picture.y, 64));
    const Int2 first = upTo(2) == 0 ? picture - crop : Int2(upTo(picture.x), upTo(picture.y));
    scene.picture = {0, 0, picture.x, picture.y};
    scene.region = intersection(scene.picture, {first.x, first.y, first.x + crop.x, first.y + crop.y});
    out.text = "size " + std::to_string(size.x) + " x " + std::to_string(size.y) + " x " + std::to_string(size.z) +
               ", texel " + std::to_string(dials.texel) + ", " + std::to_string(lights) + " lights, picture " +
               std::to_string(picture.x) + " x " + std::to_string(picture.y) + ", antialias " +
               std::to_string(dials.antialias);
    return out;
}

TEST(Sizes, BeyondThirtyTwoBitsAreRenderedOrRefused) {
    const char* const asked = std::getenv("SCRIM_SIZES_RUNS");
    const int runs = asked ? std::atoi(asked) : 4;
    std::mt19937 random(2002);
    int rendered = 0, refused = 0, large = 0;
    for (int i = 0; i < runs; ++i) {
        const Drawn drawn = drawScene(random);
        SCOPED_TRACE(drawn.text);
        try {
            const Plan plan = makePlan(drawn.scene, 2);
            const Frame frame = render(drawn.scene, plan);
            for (const float value : frame.image.rgba) ASSERT_TRUE(std::isfinite(value));
            ++rendered;
            for (const GroupPlan& group : plan.groups) {
                const double floats = double(group.lattice.width) * group.lattice.height *
                                      (plan.shadeAtPixels ? 1 : group.outputs.layout.floats());
                if (floats <= kPast32Bits) continue;
                ++large;
                break;
            }
        } catch (const Error& error) {
            ++refused;
            EXPECT_TRUE(error.kind() == ErrorKind::render || error.kind() == ErrorKind::memory) << error.what();
            EXPECT_NE(std::string(error.what()), "");
        }
    }
    std::printf("%d rendered, %d of them beyond 2^31 floats a sheet; %d refused\n", rendered, large, refused);
    EXPECT_GT(rendered, runs / 4);
    if (runs >= 100) {
        EXPECT_GT(large, runs / 20);
    }
}

}  // namespace
}  // namespace scrim::test
