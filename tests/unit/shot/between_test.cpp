// SPDX-License-Identifier: Apache-2.0
// Frames between two files of a sequence: closed forms of mixtures, and moving smoke against the true frames.
#include <scrim/scrim.h>

#include <scrim/scene/scene_files.h>
#include <scrim/shot/field_store.h>
#include <scrim/volume/field_sampler.h>

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

// An orthographic eye along -z over 48 x 48 world units; a pixel is one unit.
const std::string kScene = R"(
[camera]
type = "orthographic"
height = 48
position = [0, 0, 100]
target = [0, 0, 0]
resolution = [48, 48]
[[volume]]
name = "smoke"
file = "smoke.####.vdb"
[volume.density]
grid = "density"
scale = 0.05
[ambient]
color = [1, 1, 1]
[render]
sheet_thickness = 1
texel = 0.5
)";

const std::string kCarried = R"(volume.smoke.velocity={grid="v",unit="frame"})";

/// `frame` of the volume: file 1 at frame 1, and `speed` files a frame.
std::string between(const std::string& how, double speed = 0.5) {
    return "volume.smoke.frame={between=\"" + how + "\",speed=" + std::to_string(speed) +
           ",offset=" + std::to_string(1 - speed) + "}";
}

using Field = std::function<double(const Vec3& x, double t)>;
using Flow = std::function<Vec3(const Vec3& x)>;

class Between : public ::testing::Test {
  protected:
    void SetUp() override { writeBytes(file("shot.toml"), kScene); }

    std::string file(const std::string& name) const { return m_folder.file(name); }
    /// Files 1 to `count` of moving smoke, "smoke.0001.vdb", and what is between them, "true.0001.vdb", with what
    /// glows.
    void writeSmoke(int count, const Field& density, const Flow& velocity) const {
        for (int i = 1; i <= count; ++i) {
            writeFile("smoke", i, i, density, velocity);
            if (i < count) writeFile("true", i, i + 0.5, density, velocity);
        }
    }
    void writeFile(const std::string& name, int number, double t, const Field& density, const Flow& velocity) const {
        MadeGrid d{.name = "density"}, heat{.name = "heat"}, v{.name = "v", .type = "vec3s", .gridClass = ""};
        constexpr int kHalf = 22;
        for (int x = -kHalf; x <= kHalf; ++x)
            for (int y = -kHalf; y <= kHalf; ++y)
                for (int z = -6; z <= 6; ++z) {
                    const double value = density(Vec3(x, y, z), t);
                    v.colours.push_back({{x, y, z}, velocity(Vec3(x, y, z))});
                    if (value < 1e-3) continue;
                    d.voxels.push_back({{x, y, z}, value});
                    heat.voxels.push_back({{x, y, z}, 0.5 * value});
                }
        makeVdb(file(name + ".000" + std::to_string(number) + ".vdb"), {d, heat, v});
    }
    Shot open(const std::vector<std::string>& overrides) const { return Shot::open(file("shot.toml"), overrides); }
    Image picture(int frame, const std::vector<std::string>& overrides) const {
        return open(overrides).render(frame, {}).image();
    }
    /// The difference of both pictures over the largest value of the second, root mean square over the pixels that
    /// either of them covers, in channel `c`.
    static double difference(const Image& a, const Image& b, std::size_t c = 3) {
        double sum = 0, most = 0;
        int count = 0;
        for (std::size_t i = c; i < a.rgba.size(); i += 4) {
            most = std::max(most, double(b.rgba[i]));
            if (a.rgba[i] < 1e-3f && b.rgba[i] < 1e-3f) continue;
            sum += std::pow(double(a.rgba[i]) - double(b.rgba[i]), 2);
            ++count;
        }
        return std::sqrt(sum / std::max(count, 1)) / most;
    }

  private:
    TempFolder m_folder;
};

double alphaAt(const Image& image, int x, int y) {
    return image.rgba[image.indexOf(x, y) + 3];
}

// A ball with a wave in it, 13 units from an axis about which it turns by 0.5 (29 degrees) from file to file.
constexpr double kTurn = 0.5;
double turning(const Vec3& x, double t) {
    const double c = std::cos(kTurn * t), s = std::sin(kTurn * t);
    const Vec3 own(c * x.x + s * x.y - 13, -s * x.x + c * x.y, x.z);
    return std::exp(-dot(own, own) / 12) * (1 + 0.5 * std::sin(own.x + own.y));
}
Vec3 turn(const Vec3& x) {
    return kTurn * Vec3(-x.y, x.x, 0);
}

// Smoke that rises by 6 units a file, spreads sideways as it does, and comes out of the lower border of the grid.
double rising(const Vec3& x, double t) {
    const double wide = 1 + 0.25 * t, y0 = x.y - 6 * t + 14;
    const Vec3 own(x.x / wide, y0, x.z);
    const double front = std::clamp(0.5 * (6 - y0), 0.0, 1.0), source = std::clamp((x.y + 21) / 6, 0.0, 1.0);
    return front * source * std::exp(-(own.x * own.x + own.z * own.z) / 10) * (1 + 0.7 * std::sin(0.9 * y0));
}

TEST_F(Between, FilesThatTurnCarriedIsWhereTheTrueFrameIs) {
    writeSmoke(3, turning, turn);
    for (const int frame : {2, 4}) {
        const Image truth = picture(frame / 2, {"volume.smoke.file=\"true.####.vdb\""});
        const double carried = difference(picture(frame, {between("advect"), kCarried}), truth);
        const double mixed = difference(picture(frame, {between("blend")}), truth);
        const double nearest = difference(picture(frame, {between("nearest")}), truth);
        EXPECT_LT(carried, 0.006) << "frame " << frame;
        EXPECT_GT(mixed, 0.12) << "frame " << frame;
        EXPECT_GT(nearest, 0.18) << "frame " << frame;
    }
}

// The velocity at file t: of a place x it is (x / (wide / 0.25), 6, 0).
TEST_F(Between, FilesThatRiseAndSpreadCarriedIsWhereTheTrueFrameIs) {
    for (int i = 1; i <= 3; ++i) {
        const Flow flow = [i](const Vec3& x) { return Vec3(0.25 * x.x / (1 + 0.25 * i), 6, 0); };
        writeFile("smoke", i, i, rising, flow);
        writeFile("true", i, i + 0.5, rising, flow);
    }
    for (const int frame : {2, 4}) {
        const Image truth = picture(frame / 2, {"volume.smoke.file=\"true.####.vdb\""});
        EXPECT_LT(difference(picture(frame, {between("advect"), kCarried}), truth), 0.04) << "frame " << frame;
        EXPECT_GT(difference(picture(frame, {between("blend")}), truth), 0.15) << "frame " << frame;
    }
}

TEST_F(Between, FilesWhatGlowsIsCarriedToo) {
    writeSmoke(2, turning, turn);
    const std::string glow = "volume.smoke.medium={albedo=[0,0,0],emission={grid=\"heat\"}}";
    const Image truth = picture(1, {"volume.smoke.file=\"true.####.vdb\"", glow});
    EXPECT_LT(difference(picture(2, {between("advect"), kCarried, glow}), truth, 0), 0.006);
    EXPECT_GT(difference(picture(2, {between("blend"), glow}), truth, 0), 0.1);
}

TEST_F(Between, FilesAWholeNumberIsTheFileItself) {
    writeSmoke(2, turning, turn);
    for (const std::string how : {"blend", "advect"}) {
        EXPECT_EQ(picture(3, {between(how), kCarried}).rgba, picture(3, {between("nearest"), kCarried}).rgba) << how;
        // Numbers that rounding keeps from being whole, too.
        const std::string thirds = "volume.smoke.frame={between=\"" + how + "\",speed=0.1,offset=1.7}";
        EXPECT_EQ(picture(3, {thirds, kCarried}).rgba, picture(2, {between("nearest", 1), kCarried}).rgba) << how;
    }
}

// Blocks of 10 units of density 1 and 3 that do not touch, and a third file whose lattice is elsewhere.
class BetweenBlocks : public Between {
  protected:
    void SetUp() override {
        Between::SetUp();
        makeVdb(file("smoke.0001.vdb"), {{.voxels = box({-15, -5, 0}, {-6, 5, 9}, 1)}});
        makeVdb(file("smoke.0002.vdb"), {{.voxels = box({5, -5, 0}, {14, 5, 9}, 3)}});
        makeVdb(file("smoke.0003.vdb"), {{.voxels = box({5, -5, 0}, {14, 5, 9}, 3), .translate = Vec3(-20.5, 0, 0)}});
    }
    double depth(int frame, int x, double speed = 0.25) const {
        return -std::log(1 - alphaAt(picture(frame, {between("blend", speed)}), x, 24)) / 0.05;
    }
};

TEST_F(BetweenBlocks, MixDensitiesInProportion) {
    // Frame 2 is a quarter of the way. Pixel 14 looks at x = -9.5, pixel 34 at 10.5.
    EXPECT_NEAR(depth(2, 14), 10 * 0.75, 0.02);
    EXPECT_NEAR(depth(2, 34), 30 * 0.25, 0.02);
    EXPECT_NEAR(depth(4, 14), 10 * 0.25, 0.02);
    EXPECT_NEAR(depth(4, 34), 30 * 0.75, 0.02);
    EXPECT_NEAR(depth(2, 24), 0, 0.01);
}

// Every third voxel has density 3 and the others 1; all of it moves by a voxel from file to file. A third of the way,
// linear interpolation would leave 2.33 at most. Nothing rings, neither there nor beyond the border of the block.
TEST_F(Between, FilesKeepWhatIsAsFineAsAVoxelAndDoNotRing) {
    const auto stripes = [](const Vec3& x, double t) {
        const double own = x.x - (t - 1);
        return std::abs(own) > 12 || std::abs(x.y) > 12 ? 0 : own - 3 * std::floor(own / 3) < 0.5 ? 3.0 : 1.0;
    };
    for (int i = 1; i <= 2; ++i) writeFile("smoke", i, i, stripes, [](const Vec3&) { return Vec3(1, 0, 0); });
    OpenOptions options;
    options.checkedFrame = 2;
    const Scene scene = Shot::open(file("shot.toml"), {between("advect", 1.0 / 3), kCarried}, options).opened();
    LoadOptions load;
    load.volumes = VolumeLoading::plain;
    FieldStore store(load);
    const auto density = store.fieldsOf(scene, store.filesOf(scene))[0].density;
    const FieldSampler sampler(*density);
    double least = 9, most = 0;
    for (int x = -9; x <= 9; ++x) {
        const double value = sampler.voxel({x, 0, 0});
        least = std::min(least, value);
        most = std::max(most, value);
    }
    EXPECT_GE(least, 1);
    EXPECT_LE(most, 3);
    EXPECT_GT(most, 2.5);
    for (int x = 15; x <= 20; ++x) EXPECT_EQ(sampler.voxel({x, 0, 0}), 0);
}

TEST_F(BetweenBlocks, MixLatticesThatDiffer) {
    EXPECT_NEAR(depth(7, 34), 30 * 0.5, 0.02);  // of files 2 and 3
    EXPECT_NEAR(depth(7, 14), 30 * 0.5, 0.02);
    // Backwards it is the same.
    const std::string back = "volume.smoke.frame={between=\"blend\",speed=-0.25,offset=2.75}";
    EXPECT_EQ(picture(1, {back}).rgba, picture(7, {between("blend", 0.25)}).rgba);
}

TEST_F(BetweenBlocks, KeepToThePolicyOutsideOfTheSequence) {
    const auto with = [&](const std::string& outside, int frame) {
        return open({between("blend"), "volume.smoke.frame.outside=\"" + outside + "\""}).render(frame, {}).image();
    };
    EXPECT_EQ(with("hold", 6).rgba, with("hold", 5).rgba);  // number 3.5 of 3 files
    EXPECT_EQ(with("hold", 0).rgba, with("hold", 1).rgba);
    EXPECT_EQ(alphaAt(with("black", 6), 14, 24), 0);
    EXPECT_EQ(errorOf(ErrorKind::input, [&] { with("error", 6); }),
              file("shot.toml") + ":10:8: volume 'smoke': there is no file '" + file("smoke.0004.vdb") +
                  "' for frame 4; the sequence has frames 1 to 3");
    EXPECT_EQ(open({between("blend")}).frames(), (std::vector<int>{1, 2, 3, 4, 5}));
    EXPECT_EQ(open({between("nearest")}).frames().back(), 5);
    // A number between two files needs both of them.
    EXPECT_EQ(open({"volume.smoke.frame={between=\"blend\",speed=0.4}"}).frames(), (std::vector<int>{3, 4, 5, 6, 7}));
}

TEST_F(BetweenBlocks, NeedAVelocityToBeCarried) {
    EXPECT_EQ(errorOf(ErrorKind::input, [&] { open({between("advect")}); }),
              "--set volume.smoke.frame: 'between' carries grids by their velocity, and [[volume]] 'smoke' has no "
              "'velocity'; expected one beside it");
}

// What moves by 8 a file moves by 2 a frame at a quarter of the speed, and by -2 backwards.
TEST_F(Between, FilesBlurAsFarAsTheyMoveInAFrame) {
    const auto blob = [](const Vec3& x, double) { return std::exp(-dot(x, x) / 12); };
    writeSmoke(2, blob, [](const Vec3&) { return Vec3(8, 0, 0); });
    const std::string shutter = "camera.shutter=[0,1]", samples = "render.shutter_samples=8";
    const auto by = [&](double scale) {
        return picture(1, {kCarried, "volume.smoke.velocity.scale=" + std::to_string(scale), shutter, samples});
    };
    EXPECT_LT(difference(picture(1, {between("advect", 0.25), kCarried, shutter, samples}), by(0.25)), 1e-5);
    const std::string back = "volume.smoke.frame={between=\"advect\",speed=-0.25,offset=1.25}";
    EXPECT_LT(difference(picture(1, {back, kCarried, shutter, samples}), by(-0.25)), 1e-5);
    EXPECT_GT(difference(by(0.25), by(1)), 0.1);
}

// Between files the velocity is carried, too: frame 2 of a blob that moves evenly is blurred as frame 1 is.
TEST_F(Between, FilesBlurTheSameBetweenThem) {
    const auto blob = [](const Vec3& x, double t) {
        const Vec3 own = x - Vec3(8 * (t - 1.5), 0, 0);
        return std::exp(-dot(own, own) / 12);
    };
    writeSmoke(2, blob, [](const Vec3&) { return Vec3(8, 0, 0); });
    const std::string shutter = "camera.shutter=[-0.5,0.5]", samples = "render.shutter_samples=8";
    const Image truth = picture(
        1, {"volume.smoke.file=\"true.####.vdb\"", kCarried, "volume.smoke.velocity.scale=0.5", shutter, samples});
    EXPECT_LT(difference(picture(2, {between("advect"), kCarried, shutter, samples}), truth), 0.02);
}

// Two files, to and fro: file 1, half-way, file 2, half-way, file 1. Backwards it is seen and blurred as a sequence of
// negative speed is.
TEST_F(Between, FilesThatTurnBackGoTheWayTheyCame) {
    const auto blob = [](const Vec3& x, double t) {
        const Vec3 own = x - Vec3(8 * (t - 1.5), 0, 0);
        return std::exp(-dot(own, own) / 12);
    };
    writeSmoke(2, blob, [](const Vec3&) { return Vec3(8, 0, 0); });
    const std::string there = between("advect"), toAndFro = "volume.smoke.frame.outside=\"ping-pong\"";
    EXPECT_EQ(picture(4, {there, toAndFro, kCarried}).rgba, picture(2, {there, kCarried}).rgba);
    EXPECT_EQ(picture(6, {there, toAndFro, kCarried}).rgba, picture(2, {there, kCarried}).rgba);

    const std::string back = "volume.smoke.frame={between=\"advect\",speed=-0.5,offset=3.5}";
    const auto blurred = [&](int frame, const std::string& open, const std::string& how, const std::string& outside,
                             int samples = 8) {
        return picture(frame, {how, outside, kCarried, "camera.shutter=[" + open + "]",
                               "render.shutter_samples=" + std::to_string(samples)});
    };
    for (const int frame : {3, 4})
        EXPECT_LT(difference(blurred(frame, "0,1", there, toAndFro), blurred(frame, "0,1", back, toAndFro)), 1e-5)
            << frame;
    EXPECT_LT(difference(blurred(5, "0,1", there, toAndFro), blurred(1, "0,1", there, toAndFro)), 1e-5);
    // It comes to the turn and leaves it on the same side, so that each place is seen twice.
    EXPECT_LT(difference(blurred(3, "-1,1", there, toAndFro), blurred(3, "0,1", back, toAndFro, 4)), 1e-5);
    // What is held stands still.
    const std::string held = "volume.smoke.frame.outside=\"hold\"";
    EXPECT_LT(difference(blurred(4, "0,1", there, held), picture(3, {there, kCarried})), 1e-5);
}

TEST_F(Between, FilesThatTurnBackMoveBackInTheLayerOfMotion) {
    const auto blob = [](const Vec3& x, double t) {
        const Vec3 own = x - Vec3(8 * (t - 1.5), 0, 0);
        return std::exp(-dot(own, own) / 12);
    };
    writeSmoke(2, blob, [](const Vec3&) { return Vec3(8, 0, 0); });
    const auto motion = [&](const std::string& outside, int frame, int x) {
        const ShotFrame shown = open({between("advect"), "volume.smoke.frame.outside=\"" + outside + "\"", kCarried,
                                      "output.layers=[\"motion\"]"})
                                    .render(frame, {});
        return shown.layer("motion").data[2 * std::size_t(24 * 48 + x)];
    };
    EXPECT_NEAR(motion("ping-pong", 2, 24), 4, 0.01);
    EXPECT_NEAR(motion("ping-pong", 3, 28), -4, 0.01);
    EXPECT_NEAR(motion("ping-pong", 4, 24), -4, 0.01);
    EXPECT_NEAR(motion("ping-pong", 5, 20), 4, 0.01);
    EXPECT_NEAR(motion("hold", 2, 24), 4, 0.01);
    EXPECT_EQ(motion("hold", 3, 28), 0);
    EXPECT_EQ(motion("hold", 4, 28), 0);
}

// Both files stay for the next frame, and count. Where that takes more than half of the limit, they go, and are read
// again.
TEST_F(Between, FilesOfBothSidesStayAsFarAsTheMemoryLimitAllows) {
    writeSmoke(2, turning, turn);
    OpenOptions options;
    options.checkedFrame = 2;
    const Scene scene = Shot::open(file("shot.toml"), {between("advect"), kCarried}, options).opened();
    ASSERT_EQ(scene.volumes[0].beyond, 0.5);
    const auto fieldsBy = [&](std::size_t memory) {
        LoadOptions load;
        load.volumes = VolumeLoading::plain;
        load.memory = memory;
        FieldStore store(load);
        store.fieldsOf(scene, store.filesOf(scene));
        return store.fieldsOf(scene, store.filesOf(scene));
    };
    const Fields kept = fieldsBy(0);
    ASSERT_EQ(kept[0].sources.size(), 14u);  // a density and six parts of a velocity, of two files
    std::size_t bytes = kept[0].density->bytes();
    for (const auto& field : kept[0].sources) bytes += field->bytes();
    EXPECT_EQ(scrim::bytesOf(kept), bytes);
    EXPECT_EQ(fieldsBy(2 * bytes)[0].sources.size(), 14u);
    const Fields dropped = fieldsBy(2 * bytes - 1);
    EXPECT_TRUE(dropped[0].sources.empty());
    // Both of them must be in memory once.
    const std::size_t both = bytes - kept[0].density->bytes();
    EXPECT_TRUE(fieldsBy(both)[0].sources.empty());
    const std::string text = errorOf(ErrorKind::memory, [&] { fieldsBy(both - 1); });
    EXPECT_TRUE(text.starts_with("the files on both sides of frame 2 take ")) << text;
    EXPECT_TRUE(text.ends_with(" (--memory)")) << text;
    EXPECT_EQ(scrim::bytesOf(dropped), kept[0].density->bytes());
    ASSERT_EQ(dropped[0].density->blockOrigins, kept[0].density->blockOrigins);
    EXPECT_TRUE(std::equal(dropped[0].density->block(0),
                           dropped[0].density->block(0) + dropped[0].density->blockCount() * kBlockVoxels,
                           kept[0].density->block(0)));
}

TEST_F(Between, FilesThatAreDroppedAreHeldByNothing) {
    writeSmoke(2, turning, turn);
    OpenOptions options;
    options.checkedFrame = 2;
    const Scene scene = Shot::open(file("shot.toml"), {between("advect"), kCarried}, options).opened();
    LoadOptions load;
    load.volumes = VolumeLoading::plain;
    FieldStore store(load);
    Fields fields = store.fieldsOf(scene, store.filesOf(scene));
    const std::vector<std::weak_ptr<const SparseField>> sources(fields[0].sources.begin(), fields[0].sources.end());
    load.memory = 2 * scrim::bytesOf(fields) - 1;
    fields.clear();
    store.listen(load, {}, {});
    fields = store.fieldsOf(scene, store.filesOf(scene));
    ASSERT_EQ(sources.size(), 14u);
    for (const auto& source : sources) EXPECT_TRUE(source.expired());
}

// What is written at a frame must not be either of the files that are read there.
TEST_F(Between, FilesOfBothSidesAreNotWrittenOver) {
    writeSmoke(2, turning, turn);
    OpenOptions options;
    options.checkedFrame = 2;
    std::vector<std::string> read;
    for (const SceneFile& one : filesReadBy(Shot::open(file("shot.toml"), {between("blend")}, options).opened()))
        read.push_back(one.path);
    EXPECT_EQ(read, (std::vector<std::string>{file("smoke.0001.vdb"), file("smoke.0002.vdb")}));
}

}  // namespace
}  // namespace scrim::test
