// SPDX-License-Identifier: Apache-2.0
// Scenes whose volumes are changed by expressions: the picture is that of the grids they leave, every mistake is
// located in the scene, and nothing that an expression does harms the program.
#include "support/program_test.h"

#include <scrim/image/exr_read.h>

#include <string>
#include <vector>

namespace scrim::test {
namespace {

/// A sequence chooses its dials once, for its first frame. These pictures have dials of their own.
const std::vector<std::string> kDials{"--set", "render.texel=0.2", "--set", "render.sheet_thickness=0.4"};

class Ax : public ProgramTest {
  protected:
    /// Writes a scene with these keys in [[volume]], from line 8 on.
    void scene(const std::string& keys) const { write("scene.toml", kCamera + kVolume + keys + "\n" + kLight); }
    /// The pixels of that scene.
    std::vector<float> picture(const std::string& keys, const std::vector<std::string>& more = {}) const {
        scene(keys);
        std::vector<std::string> arguments{"render", "scene.toml", "-o", "out.exr", "-q"};
        arguments.insert(arguments.end(), kDials.begin(), kDials.end());
        arguments.insert(arguments.end(), more.begin(), more.end());
        runWell(arguments);
        return pixels(file("out.exr"));
    }
    void expectError(const std::string& keys, const std::string& reason, int status = 3) const {
        scene(keys);
        expectFailure({"render", "scene.toml", "-o", "out.exr"}, status, reason);
    }
    static std::vector<float> pixels(const std::string& path) { return readExr(path).rgba; }
};

#ifdef SCRIM_WITH_AX

TEST_F(Ax, PictureIsThatOfTheGridsThatExpressionsLeave) {
    const std::vector<float> plain = picture("density = { scale = 3 }"), none = picture("");
    EXPECT_NE(plain, none);
    EXPECT_EQ(picture("ax = 'f@density *= 3;'"), plain);
    EXPECT_EQ(picture("ax = '''\nf@density *= $gain;\n'''\nparameters = { gain = 3 }"), plain);
    EXPECT_EQ(picture("ax = 'f@smoke = f@density * 3; f@density = 0;'\ndensity = { grid = 'smoke' }"), plain);
    const std::string keys = "parameters = { gain = { keys = [[1, 1], [5, 5]] } }\nax = 'f@density *= $gain;'";
    EXPECT_EQ(picture(keys, {"--frames", "3"}), plain);
    EXPECT_EQ(picture("ax = 'f@density *= $frame;'", {"--frames", "3"}), plain);
    EXPECT_EQ(picture("ax = 'f@density *= $time * 2;'", {"--frames", "36", "--set", "output.fps=24"}), plain);
    write("gain.ax", "// gain\nf@density *= 3;");
    EXPECT_EQ(picture("ax_file = 'gain.ax'"), plain);
}

TEST_F(Ax, ChangedParametersChangeTheNextFrame) {
    scene("parameters = { gain = { keys = [[1, 1], [2, 3]] } }\nax = 'f@density *= $gain;'");
    runWell({"render", "scene.toml", "-o", "out.##.exr", "--frames", "1-2", "-q", kDials[0], kDials[1], kDials[2],
             kDials[3]});
    EXPECT_EQ(pixels(file("out.01.exr")), picture(""));
    EXPECT_EQ(pixels(file("out.02.exr")), picture("density = { scale = 3 }"));
}

TEST_F(Ax, WorksOnSources) {
    const std::string source = "[[volume]]\nsource = 'noise'\n";
    write("a.toml",
          kCamera + source + "parameters = { resolution = 32, size = 20 }\ndensity = { scale = 2 }\n" + kLight);
    write("b.toml", kCamera + source +
                        "parameters = { resolution = 32, size = 20, gain = 2 }\nax = 'f@density *= $gain;'\n" + kLight);
    runWell({"render", "a.toml", "b.toml", "-q"});
    EXPECT_EQ(pixels(file("a.exr")), pixels(file("b.exr")));
}

TEST_F(Ax, MistakesHaveAPlaceInTheScene) {
    expectError("ax = 'f@density = f@density *;'", "scene.toml:8:30: unexpected SEMICOLON");
    expectError("ax = '''\n  f@density = 1;\n  f@density = bar(1);\n'''",
                "scene.toml:10:15: unable to locate function \"bar\"");
    expectError("ax = '''f@density = 1;\n  f@density = bar(1);\n'''",
                "scene.toml:9:15: unable to locate function \"bar\"");
    expectError("ax = '''f@density = bar(1);'''", "scene.toml:8:21: unable to locate function \"bar\"");
    expectError("ax = 'f@density = f@heat;'",
                "scene.toml:8:19: the expression reads grid 'heat', which smoke.vdb does not have; there is 'density'");
    expectError("ax = 'f@density = $gain;'",
                "scene.toml:8:19: there is no parameter 'gain'; expected it in [volume.parameters]");
    expectError("ax = 'f@density = 1;'\nparameters = { gain = 1 }",
                "scene.toml:9:23: the expression does not use '$gain'; expected it there, or no 'gain'");
    expectError("ax = 'f@density = $a;'\nparameters = { a = 'x' }",
                "scene.toml:9:20: 'a' is the string \"x\"; expected a number or three numbers, which may be keyed");
    expectError("ax = 'f@density = 1;'\nax_file = 'a.ax'",
                "scene.toml:9:11: [[volume]] has both 'ax' and 'ax_file'; expected one of them");
    expectError("ax_file = 'none.ax'", "scene.toml:8:11: there is no file 'none.ax'");
    write("wrong.ax", "f@density = 1;\n f@density = ;");
    expectError("ax_file = 'wrong.ax'", "scene.toml:8:11: wrong.ax:2:14: unexpected SEMICOLON");
    scene("");
    expectFailure({"render", "scene.toml", "-o", "out.exr", "--set", "volume.volume1.ax=f@density=;"}, 3,
                  "--set volume.volume1.ax: line 1, column 11: unexpected SEMICOLON");
    expectError("clip = [[0, 0, 0], [1, 0, 1]]",
                "scene.toml:8:8: 'clip' is a list of 2; expected two points, each coordinate of the second above that "
                "of the first");
    expectError("resample = 99", "scene.toml:8:12: 'resample' is 99; expected a number from 0.125 to 16");
}

TEST_F(Ax, EndlessLoopsEndByTheLimitOfTime) {
    scene("ax = 'while (true) { f@density = 1; }'");
    ProgramOptions limited;
    limited.shell = "ulimit -t 3; exec \"$0\" \"$@\"";
    expectFailure({"render", "scene.toml", "-o", "out.exr"}, 1,
                  "scene.toml:8:6: smoke.vdb with its 'ax': reading it exceeded the limit on CPU time; raise it "
                  "(ulimit -t)",
                  limited);
}

#endif

}  // namespace
}  // namespace scrim::test
