// SPDX-License-Identifier: Apache-2.0
// Motion blur: closed forms of what moves while the shutter is open, and the reference, which integrates time by a rule
// of its own and moves no voxels.
#include <scrim/scrim.h>

#include <scrim/volume/grid_request.h>

#include "support/expect_error.h"
#include "support/temp_folder.h"
#include "support/vdb_make.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>
#include <vector>

namespace scrim::test {
namespace {

// A block of 20 x 21 x 4 voxels of density 1, whose left end is at x = -1 to 0 (its kernels'), seen along -z by an
// orthographic eye: pixels of half a world unit, that of column 16 is in the middle plus a quarter.
const std::string kScene = R"(
[camera]
type = "orthographic"
height = 16
position = [0, 0, 40]
target = [0, 0, 0]
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

const std::string kShutter = "camera.shutter=[-0.5,0.5]";
const std::string kMoves = "volume.block.transform={translate={keys=[[0,[-8,0,0]],[2,[8,0,0]]]}}";
const std::string kVelocity = "volume.block.velocity={grid=\"v\",unit=\"frame\"}";

std::string samples(int n) {
    return "render.shutter_samples=" + std::to_string(n);
}

class MotionBlur : public ::testing::Test {
  protected:
    void SetUp() override {
        write("block.vdb", [](const Vec3&) { return Vec3(8, 0, 0); });
        writeBytes(file("shot.toml"), kScene);
    }
    // The block with a velocity around it; of a staggered grid `velocity` is asked at the faces.
    void write(const std::string& name, const std::function<Vec3(const Vec3&)>& velocity, bool staggered = false) {
        MadeGrid v{.name = "v", .type = "vec3s", .gridClass = staggered ? "staggered" : ""};
        std::vector<MadeGrid> parts{{.name = "vx"}, {.name = "vy"}, {.name = "vz"}};
        const double half = staggered ? 0.5 : 0;
        for (const MadeVoxel& voxel : box({-12, -14, -4}, {31, 14, 7}, 1)) {
            const Vec3 at(voxel.at);
            const Vec3 value(velocity(at - Vec3(half, 0, 0)).x, velocity(at - Vec3(0, half, 0)).y,
                             velocity(at - Vec3(0, 0, half)).z);
            v.colours.push_back({voxel.at, value});
            for (int c = 0; c < 3; ++c) parts[std::size_t(c)].voxels.push_back({voxel.at, value[c]});
        }
        makeVdb(file(name), {{.voxels = box({0, -10, 0}, {19, 10, 3}, 1)}, v, parts[0], parts[1], parts[2]});
    }
    std::string file(const std::string& name) const { return m_folder.file(name); }
    ShotFrame render(const std::vector<std::string>& overrides, int verify = 0) const {
        RenderOptions options;
        options.verify = verify;
        return Shot::open(file("shot.toml"), overrides).render(1, options);
    }
    double error(const std::vector<std::string>& overrides) const {
        return render(overrides, 60).report().verification->error;
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

double mean(const ShotFrame& frame) {
    double sum = 0;
    for (const float v : frame.image().rgba) sum += v;
    return sum / double(frame.image().rgba.size());
}

// tau is 4 behind the edge. At p = 1/4 the edge has passed while the translation s goes from -4 to p, and its ramp of a
// voxel passes for s from p to p + 1. Alpha is the mean of 1 - e^-tau over s from -4 to 4, far from 1 - e^-(mean tau).
// 64 samples are off by at most half a step of s, 1/16, of 8, and by the ramp that texels of 0.3 voxels cut.
TEST_F(MotionBlur, OfAThickSlabIsTheMeanOfAlphaAndNotTheAlphaOfTheMean) {
    const double p = 0.25, full = 1 - std::exp(-4.0);
    const double exact = ((p + 4) * full + 1 - full / 4) / 8;
    const double smeared = 1 - std::exp(-4 * (p + 4 + 0.5) / 8);
    const double seen = alphaAt(render({kShutter, kMoves, samples(64)}), 16);
    EXPECT_NEAR(seen, exact, 0.01);
    EXPECT_GT(smeared - exact, 0.25);
}

// An edge that passes the picture and a camera that passes the edge see the same.
TEST_F(MotionBlur, OfACameraThatPassesIsThatOfWhatPassesIt) {
    const ShotFrame moved = render({kShutter, kMoves, samples(8)});
    const ShotFrame passed = render({kShutter, samples(8), "camera.position={keys=[[0,[8,0,40]],[2,[-8,0,40]]]}",
                                     "camera.target={keys=[[0,[8,0,0]],[2,[-8,0,0]]]}"});
    EXPECT_LT(farthest(moved, passed), 1e-4);
    EXPECT_GT(farthest(moved, render({})), 0.3);
}

// 8 world units a frame: by the grid, by seconds and fps, by a scale, by three grids, and by faces of the same values.
TEST_F(MotionBlur, OfAConstantVelocityIsThatOfKeys) {
    const ShotFrame keyed = render({kShutter, kMoves, samples(8)});
    // A field is shifted as a whole by its mean velocity, so that only rounding to floats differs.
    for (const std::string& velocity :
         {kVelocity, std::string("volume.block.velocity={grid=\"v\",scale=24}"),
          std::string("volume.block.velocity={grid=[\"vx\",\"vy\",\"vz\"],unit=\"frame\"}")})
        EXPECT_LT(farthest(keyed, render({kShutter, velocity, samples(8)})), 1e-3) << velocity;
    EXPECT_LT(
        farthest(keyed, render({kShutter, "output.fps=48", samples(8), "volume.block.velocity={grid=\"v\",scale=48}"})),
        1e-3);
    EXPECT_GT(farthest(keyed, render({kShutter, samples(8), "volume.block.velocity={grid=\"v\",scale=12}"})), 0.1);
    write("block.vdb", [](const Vec3&) { return Vec3(-8, 0, 0); });
    EXPECT_LT(farthest(keyed, render({kShutter, kVelocity, samples(8), "volume.block.velocity.scale=-1"})), 1e-3);
    write(
        "block.vdb", [](const Vec3&) { return Vec3(8, 0, 0); }, true);
    EXPECT_LT(farthest(keyed, render({kShutter, kVelocity, samples(8)})), 1e-3);
}

// A volume with detail is two fields, coarse and fine voxels, and both move.
TEST_F(MotionBlur, OfAConstantVelocityMovesTheDetailToo) {
    const std::string detail = "volume.block.detail=2",
                      noise = "volume.block.density={noise={amount=0.8,frequency=0.2,octaves=2}}";
    const ShotFrame keyed = render({kShutter, kMoves, samples(8), detail, noise});
    EXPECT_LT(farthest(keyed, render({kShutter, kVelocity, samples(8), detail, noise})), 1e-3);
    EXPECT_GT(farthest(keyed, render({kShutter, samples(8), detail, noise})), 0.1);
}

// v = (x, y/2 - x/4, 0): linear, so that values at centres and at faces are of the same field.
TEST_F(MotionBlur, KnowsWhereTheComponentsOfAStaggeredGridStand) {
    const auto shear = [](const Vec3& x) { return Vec3(0.5 * x.x + 2, 0.25 * x.y - 0.25 * x.x, 0); };
    write("block.vdb", shear);
    const ShotFrame centres = render({kShutter, kVelocity, samples(4)});
    write("block.vdb", shear, true);
    const ShotFrame faces = render({kShutter, kVelocity, samples(4)});
    EXPECT_LT(farthest(centres, faces), 1e-4);
    // The same numbers at the voxels' centres mean something else.
    write("block.vdb",
          [&](const Vec3& x) { return Vec3(shear(x - Vec3(0.5, 0, 0)).x, shear(x - Vec3(0, 0.5, 0)).y, 0); });
    EXPECT_GT(farthest(centres, render({kShutter, kVelocity, samples(4)})), 0.01);
}

// Intensity 4 (1 - |t|) has the mean 3 over |t| < 1/2; the midpoints of an even number of parts find just that.
TEST_F(MotionBlur, AveragesLights) {
    const std::vector<std::string> light{"ambient.color=[0,0,0]",
                                         "light=[{type=\"distant\",name=\"key\",direction=[0,0,-1]}]"};
    const auto with = [&](std::vector<std::string> more) {
        more.insert(more.begin(), light.begin(), light.end());
        return render(more);
    };
    const ShotFrame still = with({"light.key.intensity=3"});
    const ShotFrame blurred = with({"light.key.intensity={keys=[[0,0],[1,4],[2,0]]}", kShutter, samples(6)});
    EXPECT_GT(mean(still), 0.05);
    EXPECT_LT(farthest(still, blurred), 1e-5);
}

// A square of 4 x 40 in front of the block passes by 8 within the shutter, and hides column 20 for half of it.
// A pulse lies between the moments of few renders: ambient light and emission rise to 8 and fall within a quarter of
// the time, at the frame itself both are out. Their mean over the shutter is 8 / 8 = 1.
TEST_F(MotionBlur, OfAPulseOfLightIsThatOfItsMean) {
    const std::string pulse = "{keys=[[0.75,0],[0.875,8],[1,0]]}";
    for (const auto& [keyed, steady] : std::vector<std::pair<std::string, std::string>>{
             {"ambient.color={keys=[[0.75,[0,0,0]],[0.875,[8,8,8]],[1,[0,0,0]]]}", "ambient.color=[1,1,1]"},
             {"volume.block.medium.emission={grid=\"density\",scale=" + pulse + "}",
              "volume.block.medium.emission={grid=\"density\",scale=1}"}}) {
        const ShotFrame blurred = render({kShutter, keyed}), still = render({steady});
        // A sixteenth of the rise lies between two values of the table, whose midpoints miss the peak by half of that.
        EXPECT_LT(farthest(blurred, still), 0.01 * mean(still)) << keyed;
        EXPECT_LT(farthest(render({kShutter, keyed, samples(3)}), still), 0.01 * mean(still)) << keyed;
    }
}

TEST_F(MotionBlur, OfAHoldoutIsThePartOfTheTimeThatItDoesNotHide) {
    writeBytes(file("square.obj"), "v -2 -20 20\nv 2 -20 20\nv 2 20 20\nv -2 20 20\nf 1 2 3 4\n");
    const std::string mesh =
        "mesh=[{name=\"square\",file=\"square.obj\",transform={translate={keys=[[0,[-5.75,0,0]],"
        "[2,[10.25,0,0]]]}}}]";
    const double whole = alphaAt(render({}), 20);
    const double seen = alphaAt(render({kShutter, samples(32), mesh}), 20);
    // Of 32 samples one may be on the other side of an edge at either end.
    EXPECT_NEAR(seen, 0.5 * whole, 2.0 / 32 * whole);
    EXPECT_GT(whole, 0.9);
}

// At its frame the block is out of the picture.
TEST_F(MotionBlur, SeesWhatIsInThePictureForAPartOfTheTimeOnly) {
    const std::string away = "volume.block.transform={translate={keys=[[0.6,[0,0,0]],[0.7,[900,0,0]],[2,[900,0,0]]]}}";
    EXPECT_EQ(alphaAt(render({away}), 20), 0);
    EXPECT_GT(alphaAt(render({away, kShutter, samples(64)}), 20), 1.0 / 64 * 0.9);
}

TEST_F(MotionBlur, HasTheNearestDepthAndTheMeanOfTheLayers) {
    const std::string nearer = "volume.block.transform={translate={keys=[[0,[0,0,-8]],[2,[0,0,8]]]}}";
    const std::string layers = "output.layers=[\"depth\",\"ambient\",\"transmittance\"]";
    const ShotFrame frame = render({nearer, layers, kShutter, samples(2)});  // at z + 2 and z - 2
    const ShotFrame still = render({layers});
    const std::size_t pixel = 16 * 32 + 24;
    EXPECT_NEAR(frame.layer("depth").data[2 * pixel], still.layer("depth").data[2 * pixel] - 2, 0.1);
    EXPECT_NEAR(frame.layer("depth").data[2 * pixel + 1], still.layer("depth").data[2 * pixel + 1], 0.05);
    EXPECT_NEAR(frame.layer("ambient").data[3 * pixel], still.layer("ambient").data[3 * pixel], 0.01);
    EXPECT_NEAR(frame.layer("transmittance").data[3 * pixel], 1 - alphaAt(still, 24), 0.01);
}

// Pixels until the next frame, of half a unit each: by keys, by a velocity, by both, and by the camera.
TEST_F(MotionBlur, HasALayerOfTheWayUntilTheNextFrame) {
    const std::string layer = "output.layers=[\"motion\"]";
    const std::string slow = "volume.block.transform={translate={keys=[[0,[-1.5,0,0]],[2,[1.5,0,0]]]}}";
    const auto motion = [&](std::vector<std::string> more) {
        more.push_back(layer);
        const ShotFrame frame = render(more);
        const ShotLayer& out = frame.layer("motion");
        EXPECT_EQ(out.channels, (std::vector<std::string>{"motion.u", "motion.v"}));
        EXPECT_EQ(out.data[2 * (16 * 32 + 1)], 0) << "nothing is there";
        const float* at = out.data.data() + 2 * (16 * 32 + 22);
        return std::pair(std::round(at[0] * 1000) / 1000, std::round(at[1] * 1000) / 1000);
    };
    using Pixels = std::pair<float, float>;
    EXPECT_EQ(Pixels(motion({})), Pixels(0, 0));
    EXPECT_EQ(Pixels(motion({slow})), Pixels(3, 0));
    EXPECT_EQ(Pixels(motion({kMoves})), Pixels(16, 0));
    EXPECT_EQ(Pixels(motion({kVelocity})), Pixels(16, 0));
    EXPECT_EQ(Pixels(motion({"volume.block.velocity={grid=[\"vx\",\"vy\",\"vz\"],scale=-3}"})), Pixels(-2, 0));
    EXPECT_EQ(Pixels(motion({kVelocity, slow})), Pixels(19, 0));
    EXPECT_EQ(Pixels(motion({"camera.position={keys=[[0,[0,0,40]],[2,[0,2,40]]]}",
                             "camera.target={keys=[[0,[0,0,0]],[2,[0,2,0]]]}"})),
              Pixels(0, -2));
    // The mean over the shutter, of what moves evenly, is the same; of what stops meanwhile it is less.
    const std::string on = "volume.block.transform={translate={keys=[[0,[-1.5,0,0]],[3,[3,0,0]]]}}";
    EXPECT_EQ(Pixels(motion({on, kShutter, samples(4)})), Pixels(3, 0));
    EXPECT_EQ(Pixels(motion({slow, kShutter, samples(4)})), Pixels(3 * (1 + 1 + 0.875f + 0.625f) / 4, 0));
}

// Points that are seen by themselves go their own ways.
TEST_F(MotionBlur, HasALayerOfTheWayOfEachPoint) {
    std::string ply = "ply\nformat ascii 1.0\nelement vertex 2\n";
    for (const std::string name : {"x", "y", "z", "radius", "vx", "vy", "vz"}) ply += "property float " + name + "\n";
    writeBytes(file("sparks.ply"), ply + "end_header\n-4 0 0 1 2 0 0\n4 0 0 1 -1 0.5 0\n");
    const std::vector<std::string> sparks{"volume.block.file=\"sparks.ply\"", "volume.block.points={sharp=true}",
                                          "volume.block.density={grid=\"points\",scale=2}", kVelocity,
                                          "output.layers=[\"motion\"]"};
    for (const bool blurred : {false, true}) {
        std::vector<std::string> overrides = sparks;
        if (blurred) overrides.insert(overrides.end(), {kShutter, samples(2)});
        const ShotFrame frame = render(overrides);
        const auto motion = [&](int x) { return frame.layer("motion").data.data() + 2 * (16 * 32 + x); };
        EXPECT_NEAR(motion(8)[0], 4, 1e-3) << blurred;
        EXPECT_NEAR(motion(8)[1], 0, 1e-3) << blurred;
        EXPECT_NEAR(motion(24)[0], -2, 1e-3) << blurred;
        EXPECT_NEAR(motion(24)[1], 1, 1e-3) << blurred;
        EXPECT_EQ(motion(16)[0], 0) << blurred;
    }
}

// A render of one moment is not the mean over the shutter, and the reference, which is, tells. From 4 to 8 to 16
// samples errors of a smooth integrand are of second order; edges of a voxel's width take some of it off.
TEST_F(MotionBlur, IsJudgedByAReferenceThatSeesAllOfTheShutter) {
    EXPECT_GT(error({kShutter, kMoves, samples(1)}), 0.3);
    const double coarse = error({kShutter, kMoves, samples(4)}), fine = error({kShutter, kMoves, samples(16)});
    EXPECT_LT(fine, coarse / 6);
    EXPECT_LT(error({kShutter, kMoves}), 0.01);
    EXPECT_GT(error({kShutter, kVelocity, samples(1)}), 0.3);
    EXPECT_LT(error({kShutter, kVelocity}), 0.01);
}

// The reference of a picture that moves knows the density's scale. If it took the grid's
// own values, alpha would be 0.98 in place of 0.33.
TEST_F(MotionBlur, IsJudgedWithTheDensityThatTheSceneStates) {
    const std::string thin = "volume.block.density.scale=0.1";
    EXPECT_LT(error({kShutter, kMoves, thin}), 0.02);
    EXPECT_LT(error({kShutter, kVelocity, thin}), 0.02);
}

// What turns is not moved as a whole: voxels are sampled anew, while the reference follows each point. Trilinear
// samples between voxels miss h^2 / 8 of the second derivative: of a bump exp(-r^2 / 32), whose is at most 1 / 16 along
// each axis, 2 % in places where two axes are between voxels, and less where they are not.
TEST_F(MotionBlur, OfAVelocityThatTurnsIsNearTheReference) {
    const auto bump = [](const Vec3& x) {
        const Vec3 d = x - Vec3(0, 0, 2);
        return std::exp(-(d.x * d.x + d.y * d.y + 4 * d.z * d.z) / 32);
    };
    MadeGrid density, v{.name = "v", .type = "vec3s", .gridClass = ""};
    for (const MadeVoxel& voxel : box({-20, -20, -8}, {20, 20, 12}, 1)) {
        const Vec3 x(voxel.at);
        if (bump(x) > 1e-3) density.voxels.push_back({voxel.at, 0.3 * bump(x)});
        v.colours.push_back({voxel.at, Vec3(3 - 0.5 * x.y, 0.5 * x.x, 0)});
    }
    makeVdb(file("block.vdb"), {density, v});
    EXPECT_LT(error({kShutter, kVelocity}), 0.01);
    EXPECT_GT(error({kShutter, kVelocity, samples(1)}), 0.02);
}

TEST_F(MotionBlur, CostsNothingWhereNothingMoves) {
    const ShotFrame still = render({});
    for (const std::vector<std::string>& mention :
         std::vector<std::vector<std::string>>{{kShutter},
                                               {kVelocity},
                                               {kVelocity, "volume.block.velocity.scale=3"},
                                               {kShutter, samples(7)},
                                               {kShutter, "camera.near={keys=[[5,0],[9,1]]}"}}) {
        const ShotFrame frame = render(mention);
        EXPECT_EQ(frame.image().rgba, still.image().rgba) << mention.front();
        EXPECT_EQ(frame.report().workJson, still.report().workJson) << mention.front();
    }
}

TEST_F(MotionBlur, ChoosesMoreRendersForMoreMotionAndTellsThem) {
    const auto plan = [&](const std::string& key) {
        return Shot::open(file("shot.toml"), {kShutter, kMoves, key}).plan(1).table;
    };
    // 8 world units in pixels of a half.
    EXPECT_NE(plan("render.simd=\"auto\"").find("the longest motion is 16 pixels"), std::string::npos);
    EXPECT_NE(plan(samples(5)).find("5 renders"), std::string::npos);
    const auto count = [&](const std::string& quality) {
        const std::string table = plan("render={quality=\"" + quality + "\"}");
        return std::stoi(table.substr(table.find("motion blur") + 28));
    };
    EXPECT_LT(count("draft"), count("standard"));
    EXPECT_LT(count("standard"), count("ultra"));
}

// A Gaussian around (0, 0, 2), in those of the voxels where it is not negligible: `flat` narrows it along z.
MadeGrid bump(const std::vector<MadeVoxel>& voxels, double most, double width2, double flat) {
    MadeGrid grid;
    for (const MadeVoxel& voxel : voxels) {
        const Vec3 d = Vec3(voxel.at) - Vec3(0, 0, 2);
        const double value = std::exp(-(d.x * d.x + d.y * d.y + flat * d.z * d.z) / width2);
        if (value > 1e-3) grid.voxels.push_back({voxel.at, most * value});
    }
    return grid;
}

// The path is 16 pixels for both; a bump of 8 voxels' width changes slowly along it, a block's edge of one voxel at
// once. Both keep the promise of 2 %, of which sheets and texels have their share.
TEST_F(MotionBlur, TakesFewerRendersWhereThePictureIsSmooth) {
    const auto count = [&] {
        const std::string table = Shot::open(file("shot.toml"), {kShutter, kMoves}).plan(1).table;
        return std::stoi(table.substr(table.find("motion blur") + 28));
    };
    const int sharp = count();
    EXPECT_LT(error({kShutter, kMoves}), 0.02);
    makeVdb(file("block.vdb"), {bump(box({-20, -20, -8}, {20, 20, 12}, 1), 0.3, 64, 4)});
    EXPECT_LT(2 * count(), sharp);
    EXPECT_LT(error({kShutter, kMoves}), 0.02);
}

// A part of the picture where nothing moves must not choose otherwise, or tiles would differ at their borders.
TEST_F(MotionBlur, TakesAsManyRendersForACropAsForTheWhole) {
    const auto table = [&](std::optional<PixelWindow> crop) {
        RenderOptions options;
        options.crop = crop;
        const std::string text = Shot::open(file("shot.toml"), {kShutter, kVelocity}).plan(1, options).table;
        return text.substr(text.find("motion blur"), 80);
    };
    EXPECT_EQ(table(std::nullopt), table(PixelWindow{0, 0, 4, 4}));
}

// One voxel, of 27,588, that a simulation has left with any speed: it is told, all others go on as they did, and the
// number of renders is theirs.
TEST_F(MotionBlur, OfOneVoxelOfAnySpeedIsThatOfAllOthers) {
    std::vector<std::string> messages;
    const auto rendered = [&](double speed) {
        write("block.vdb", [&](const Vec3& is) {
            return is == Vec3(-8, -10, 5) ? Vec3(speed, -speed, 0.5 * speed) : Vec3(8, 0, 0);
        });
        messages.clear();
        RenderOptions options;
        options.messages = [&](Severity, const std::string& text) { messages.push_back(text); };
        return Shot::open(file("shot.toml"), {kShutter, kVelocity}).render(1, options);
    };
    const ShotFrame plain = rendered(8);
    EXPECT_TRUE(messages.empty());
    for (const double speed : {1e3, 1e5, 1e10, 3e38}) {
        const ShotFrame frame = rendered(speed);
        ASSERT_EQ(messages.size(), 1u);
        EXPECT_NE(messages[0].find("fewer than one in 5,000 voxels of a velocity move up to"), std::string::npos)
            << messages[0];
        // One voxel goes another way, and no faster than four times what is usual: a trace of one in 27,588.
        EXPECT_LT(farthest(frame, plain), 5e-3) << speed;
        EXPECT_GT(mean(frame), 0.1);
    }
}

// The scene with the dials of its preset, the block in place of which is a bump.
class MomentDials : public MotionBlur {
  protected:
    void SetUp() override {
        MotionBlur::SetUp();
        makeVdb(file("block.vdb"), {bump(box({-14, -14, -6}, {14, 14, 10}, 1), 0.5, 24, 2)});
        const std::string dials = "[render]";
        writeBytes(file("shot.toml"), kScene.substr(0, kScene.find(dials)) + kLight);
    }
    static constexpr const char* kLight =
        "[[light]]\nname = \"key\"\ntype = \"distant\"\ndirection = [1, -1, -1]\n"
        "intensity = 4\n";
    std::string table(const std::vector<std::string>& overrides, std::optional<PixelWindow> crop = {}) const {
        RenderOptions options;
        options.crop = crop;
        return Shot::open(file("shot.toml"), overrides).plan(1, options).table;
    }
    static double dial(const std::string& table, const std::string& name) {
        return std::stod(table.substr(table.find("\n" + name + " = ") + name.size() + 4));
    }
};

// A still of the bump has half of the error that its preset promises. 16 moments may have what the blur leaves of it.
TEST_F(MomentDials, AreAsCoarseAsThePromiseAllows) {
    const std::string still = table({}), moments = table({kShutter, kMoves});
    EXPECT_NE(still.find("for every frame of the shot"), std::string::npos);
    EXPECT_NE(moments.find("for every render of this frame's motion blur"), std::string::npos) << moments;
    const auto work = [](const std::string& t) { return std::pow(dial(t, "texel"), 2) * dial(t, "sheet_thickness"); };
    EXPECT_GT(work(moments), 1.3 * work(still));
    EXPECT_GE(dial(moments, "texel"), dial(still, "texel"));
    EXPECT_GE(dial(moments, "sheet_thickness"), dial(still, "sheet_thickness"));
    EXPECT_LT(error({kShutter, kMoves}), 0.01);
}

TEST_F(MomentDials, AreThoseThatThePlanTellsToPaste) {
    const std::string told = table({kShutter, kMoves});
    const std::string pasted = "render={texel=" + std::to_string(dial(told, "texel")) +
                               ",sheet_thickness=" + std::to_string(dial(told, "sheet_thickness")) + "}";
    EXPECT_EQ(farthest(render({kShutter, kMoves}), render({kShutter, kMoves, pasted})), 0);
}

TEST_F(MomentDials, AreThoseOfAStillWithFewMomentsAndWhereTheSceneStatesThem) {
    const std::string still = table({});
    const std::string few = table({kShutter, kMoves, samples(3)});
    EXPECT_EQ(dial(few, "sheet_thickness"), dial(still, "sheet_thickness"));
    EXPECT_EQ(dial(few, "texel"), dial(still, "texel"));
    const std::string stated = table({kShutter, kMoves, "render.texel=0.37"});
    EXPECT_EQ(stated.find("promises"), std::string::npos);
}

// Of a crop where the bump passes and of one that it never enters.
TEST_F(MomentDials, AreTheSameForACropAsForTheWhole) {
    const std::string whole = table({kShutter, kMoves});
    for (const PixelWindow& crop : {PixelWindow{12, 12, 20, 20}, PixelWindow{0, 0, 4, 4}}) {
        const std::string part = table({kShutter, kMoves}, crop);
        EXPECT_EQ(dial(part, "texel"), dial(whole, "texel"));
        EXPECT_EQ(dial(part, "sheet_thickness"), dial(whole, "sheet_thickness"));
    }
    RenderOptions options;
    options.crop = PixelWindow{12, 10, 20, 22};
    const ShotFrame part = Shot::open(file("shot.toml"), {kShutter, kMoves}).render(1, options);
    const ShotFrame all = render({kShutter, kMoves});
    for (int y = 10; y < 22; ++y)
        for (int x = 12; x < 20; ++x) EXPECT_EQ(alphaAt(part, x, y), alphaAt(all, x, y)) << x << ' ' << y;
}

TEST_F(MotionBlur, TellsWhatIsWrongAndWhere) {
    EXPECT_NE(errorOf(ErrorKind::input,
                      [&] {
                          render({kShutter, "volume.block.velocity={grid=\"w\"}"});
                      })
                  .find("--set volume.block.velocity"),
              std::string::npos);
    EXPECT_NE(errorOf(ErrorKind::input,
                      [&] {
                          render({kShutter, "volume.block.velocity={grid=\"density\"}"});
                      })
                  .find("where a velocity is expected"),
              std::string::npos);
    EXPECT_NE(errorOf(ErrorKind::input, [&] { render({"camera.shutter=[0.25,-0.25]"}); }).find("with open < close"),
              std::string::npos);
    EXPECT_NE(errorOf(ErrorKind::input,
                      [&] {
                          render({kShutter, "render.shutter_samples=1.5"});
                      })
                  .find("1 to 1024"),
              std::string::npos);
}

TEST(VelocityRequests, AreWordsBetweenProcesses) {
    for (const GridPart part : {GridPart::whole, GridPart::positive, GridPart::negative})
        for (const int component : {GridRequest::kScalar, 0, 2}) {
            const GridRequest request{"v:+0", component, part};
            EXPECT_EQ(gridRequestFrom(toText(request)), request) << toText(request);
        }
}

}  // namespace
}  // namespace scrim::test
