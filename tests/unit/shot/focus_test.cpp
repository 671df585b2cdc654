// SPDX-License-Identifier: Apache-2.0
// Depth of field: closed forms of what a lens makes of edges and points, and the reference, which has places of its own
// on the lens.
#include <scrim/scrim.h>

#include "support/expect_error.h"
#include "support/temp_folder.h"
#include "support/vdb_make.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <string>
#include <vector>

namespace scrim::test {
namespace {

// A block of 20 x 21 x 4 voxels of density 1, which ends at x = -1 to 0, 400 away: a pixel is half a world unit there,
// and its depth hardly matters.
const std::string kScene = R"(
[camera]
fov = 2.29152583
position = [0, 0, 401.5]
target = [0, 0, 1.5]
resolution = [32, 32]
[[volume]]
name = "block"
file = "block.vdb"
[ambient]
color = [1, 1, 1]
[render]
sheet_thickness = 0.5
texel = 0.3
)";

std::string samples(int n) {
    return "render.shutter_samples=" + std::to_string(n);
}

class DepthOfField : public ::testing::Test {
  protected:
    void SetUp() override {
        makeVdb(m_folder.file("block.vdb"), {{.voxels = box({0, -10, 0}, {19, 10, 3}, 1)}});
        writeBytes(file("shot.toml"), kScene);
    }
    std::string file(const std::string& name) const { return m_folder.file(name); }
    ShotFrame render(const std::vector<std::string>& overrides, int verify = 0) const {
        RenderOptions options;
        options.verify = verify;
        return Shot::open(file("shot.toml"), overrides).render(1, options);
    }

  private:
    TempFolder m_folder;
};

double alphaAt(const ShotFrame& frame, int x, int y = 16) {
    return frame.image().rgba[frame.image().indexOf(x, y) + 3];
}

double farthest(const ShotFrame& a, const ShotFrame& b) {
    double most = 0;
    for (std::size_t i = 0; i < a.image().rgba.size(); ++i)
        most = std::max(most, std::abs(double(a.image().rgba[i]) - b.image().rgba[i]));
    return most;
}

// A lens of radius 4 that is sharp at 200 blurs what is 400 away to disks of a radius of 4 (1/200 - 1/400) / (1/800) =
// 8 pixels: alpha is the part of the disk on the block's side of its edge. Optical depth rises from 0 to 4 within a
// voxel of two pixels, from pixel 14 on. As much alpha has a step where 1 - e^-4r has the mean that it has over the
// ramp.
TEST_F(DepthOfField, OfAnEdgeIsThePartOfADisk) {
    const ShotFrame seen = render({"camera.lens_radius=4", "camera.focus_distance=200", samples(200)});
    const double full = 1 - std::exp(-4.0), step = 14 + 2 * (1 - (1 - full / 4) / full);
    for (const int x : {9, 12, 15, 18, 21}) {
        const double t = std::clamp((x + 0.5 - step) / 8, -1.0, 1.0);
        const double part = 1 - (std::acos(t) - t * std::sqrt(1 - t * t)) / std::numbers::pi;
        EXPECT_NEAR(alphaAt(seen, x), full * part, 0.025) << x;
    }
}

// At the focus a point of the lens sees what the middle sees. The block is 4 deep, which moves its ends by 0.02 pixels.
TEST_F(DepthOfField, IsSharpAtTheFocus) {
    const ShotFrame pinhole = render({});
    EXPECT_LT(farthest(render({"camera.lens_radius=4", "camera.focus_distance=400", samples(40)}), pinhole), 0.02);
    EXPECT_GT(farthest(render({"camera.lens_radius=4", "camera.focus_distance=300", samples(40)}), pinhole), 0.2);
    // A lens shift and another aspect of pixels change nothing of that.
    const std::string moved = "camera.shift=[0.1,-0.2]", wide = "camera.pixel_aspect=1.5";
    EXPECT_LT(farthest(render({"camera.lens_radius=4", "camera.focus_distance=400", samples(40), moved, wide}),
                       render({moved, wide})),
              0.02);
}

// By the f-stop: 50 mm at f/2 are a radius of 12.5 mm, which is 4 world units of 3.125 mm.
TEST_F(DepthOfField, OfAnFStopIsThatOfItsRadius) {
    const std::string film = "camera.aperture=2", focus = "camera.focus_distance=200";
    const auto of = [&](const std::string& lens, const std::string& unit = "camera.near=0") {
        return render({"camera.focal_length=50", film, focus, lens, unit, samples(8)});
    };
    EXPECT_EQ(farthest(of("camera.lens_radius=4"), of("camera.fstop=2", "camera.world_unit=3.125")), 0);
    EXPECT_GT(farthest(of("camera.lens_radius=4"), of("camera.fstop=4", "camera.world_unit=3.125")), 0.05);
    EXPECT_EQ(farthest(render({"camera.lens_radius=0", focus}), render({})), 0);
}

// As many renders as pilots ask for, also with a shutter.
TEST_F(DepthOfField, KeepsThePromise) {
    const std::vector<std::string> lens{"camera.lens_radius=1.5", "camera.focus_distance=200"};
    const ShotFrame still = render(lens, 40);
    EXPECT_LT(still.report().verification->error, 0.012);
    std::vector<std::string> moves = lens;
    moves.insert(moves.end(),
                 {"camera.shutter=[-0.5,0.5]", "volume.block.transform={translate={keys=[[0,[-2,0,0]],[2,[2,0,0]]]}}"});
    EXPECT_LT(render(moves, 40).report().verification->error, 0.012);
}

// The area that two disks share.
double overlap(double a, double b, double distance) {
    if (distance >= a + b) return 0;
    const double pi = std::numbers::pi, least = std::min(a, b);
    if (distance <= std::abs(a - b)) return pi * least * least;
    const auto part = [&](double own, double other) {
        const double x = (distance * distance + own * own - other * other) / (2 * distance), t = x / own;
        return own * own * (std::acos(t) - t * std::sqrt(1 - t * t));
    };
    return part(a, b) + part(b, a);
}

// A small bright lamp beside the block, a disk of 2 pixels, is blurred by a disk of 3: where a pixel looks, the part of
// the lens that sees it. Pilots must see it, though it is no part of a volume. It lights nothing, which takes less
// time.
TEST_F(DepthOfField, KeepsThePromiseOfALampThatIsSeen) {
    writeBytes(file("shot.toml"), kScene + R"(
[[light]]
name = "lamp"
type = "area"
shape = "sphere"
radius = 1
position = [-5, 0, 1.5]
intensity = 20
visible = true
samples = 4
)");
    const ShotFrame seen = render({"camera.lens_radius=1.5", "camera.focus_distance=200", "volume.block.lights=[]"});
    double squares = 0, all = 0;
    for (int y = 0; y < 32; ++y)
        for (int x = 0; x < 11; ++x) {
            const double truth = 20 * overlap(2, 3, std::hypot(x + 0.5 - 6, y + 0.5 - 16)) / (9 * std::numbers::pi);
            squares += std::pow(seen.image().rgba[seen.image().indexOf(x, y)] - truth, 2);
            all += truth * truth;
        }
    // Hard edges converge more slowly than the pilots suppose.
    EXPECT_LT(std::sqrt(squares / all), 0.03);
}

// A crop has the pixels of the whole.
TEST_F(DepthOfField, OfACropIsThatOfTheWhole) {
    const std::vector<std::string> lens{"camera.lens_radius=4", "camera.focus_distance=200", samples(9)};
    const ShotFrame whole = render(lens);
    RenderOptions options;
    options.crop = PixelWindow{9, 11, 20, 17};
    const ShotFrame part = Shot::open(file("shot.toml"), lens).render(1, options);
    for (int y = 11; y < 17; ++y)
        for (int x = 9; x < 20; ++x) EXPECT_EQ(alphaAt(part, x, y), alphaAt(whole, x, y)) << x << ", " << y;
}

TEST_F(DepthOfField, SaysWhatItNeeds) {
    const auto says = [&](const std::string& text, const std::vector<std::string>& overrides) {
        const std::string said = errorOf(ErrorKind::input, [&] { render(overrides); });
        EXPECT_NE(said.find(text), std::string::npos) << said;
    };
    says("lacks 'focus_distance'; expected a number", {"camera.fstop=3"});
    says("'fstop' is 0; expected a number greater than 0", {"camera.focus_distance=3", "camera.fstop=0"});
    says("a.exr'; expected none, since the camera has a lens",
         {"camera.focus_distance=3", "camera.fstop=2", "output.deep=\"a.exr\""});
}

}  // namespace
}  // namespace scrim::test
