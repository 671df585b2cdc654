// SPDX-License-Identifier: Apache-2.0
// Scenes whose volumes are changed by expressions: the picture is that of the grids they leave, every mistake is
// located in the scene, and nothing that an expression does harms the program.
#include "support/program_test.h"

#include <scrim/image/exr_read.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
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

TEST_F(Ax, AGridThatIsMadeIsNotTheDensityOfAFileWithoutNames) {
    for (const char* gridClass : {"", "fog volume"}) {
        makeVdb(file("smoke.vdb"), {{.name = "", .gridClass = gridClass, .voxels = box({-6, -6, -6}, {6, 6, 6}, 0.2)}});
        EXPECT_EQ(picture("ax = 'f@foo = 0;'"), picture("")) << gridClass;
    }
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
    expectError("ax = 'f@density = $a;'\nparameters = { a = 'x' }",
                "scene.toml:9:20: 'a' is the string \"x\"; expected a number or three numbers, which may be keyed");
    expectError("ax = 'f@density = 1;'\nax_file = 'a.ax'",
                "scene.toml:9:11: [[volume]] has both 'ax' and 'ax_file'; expected one of them");
    expectError("ax_file = 'none.ax'", "scene.toml:8:11: there is no file 'none.ax'");
    write("wrong.ax", "f@density = 1;\n f@density = ;");
    expectError("ax_file = 'wrong.ax'", "scene.toml:8:11: wrong.ax:2:14: unexpected SEMICOLON");
    for (const std::string name : {"addtogroup", "deletepoint", "ingroup", "removefromgroup"})
        expectError("ax = '''f@density = 1; " + name + (name == "deletepoint" ? "()" : "(\"g\")") + ";'''",
                    "scene.toml:8:24: " + name + "() works on points; expected functions of voxels");
    expectError(
        "ax = 'f@density = rand();'",
        "scene.toml:8:19: rand() differs in every run; expected a seed, as in rand(dot(getcoord(), {1, 131, 17161}))");
    scene("");
    expectFailure({"render", "scene.toml", "-o", "out.exr", "--set", "volume.volume1.ax=f@density=;"}, 3,
                  "--set volume.volume1.ax: line 1, column 11: unexpected SEMICOLON");
    expectError("clip = [[0, 0, 0], [1, 0, 1]]",
                "scene.toml:8:8: 'clip' is a list of 2; expected two points, each coordinate of the second above that "
                "of the first");
    expectError("resample = 99", "scene.toml:8:12: 'resample' is 99; expected a number from 0.125 to 16");
}

// Code is changed line by line while one looks at it; what it does not use at the moment is no mistake.
TEST_F(Ax, WarnsOfAParameterThatItDoesNotUse) {
    const auto picture = [&](const std::string& more) {
        scene(more);
        const ProgramResult result = run({"render", "scene.toml", "-o", "out.exr"});
        EXPECT_EQ(result.status, 0) << result.err;
        return std::pair(result.err, pixels(file("out.exr")));
    };
    const auto [nothing, plain] = picture("ax = 'f@density *= $gain;'\nparameters = { gain = 2 }");
    EXPECT_EQ(nothing.find("warning"), std::string::npos) << nothing;
    const auto [said, same] = picture("ax = 'f@density *= $gain;'\nparameters = { gain = 2, spare = 'x' }");
    const std::string warning =
        "scrim: warning: scene.toml:9:34: the expression does not use '$spare', which changes nothing\n";
    EXPECT_NE(said.find(warning), std::string::npos) << said;
    EXPECT_EQ(same, plain);
}

TEST_F(Ax, FilesOfCodeThatCannotBeReadAreNamed) {
    expectError("ax_file = '/proc/self/mem'",
                "scene.toml:8:11: 'ax_file': /proc/self/mem: cannot be read: Input/output error");
    std::filesystem::create_directory(file("folder.ax"));
    expectError("ax_file = 'folder.ax'", "scene.toml:8:11: 'folder.ax' is not a file");
    const auto make = [&](const std::string& code, const std::string& reason) {
        expectFailure({"make", "ax", "file=smoke.vdb", "ax_file=" + code, "-o", "c.vdb"}, 3, reason);
    };
    make("folder.ax", "folder.ax: cannot be read: Is a directory");
    make("none.ax", "none.ax: cannot be read: No such file or directory");
}

TEST_F(Ax, AMarkOfUtf8BeforeTheCodeIsNoPartOfIt) {
    write("marked.ax",
          "\xef\xbb\xbf"
          "f@density *= 3;");
    EXPECT_EQ(picture("ax_file = 'marked.ax'"), picture("density = { scale = 3 }"));
    runWell({"make", "ax", "file=smoke.vdb", "ax_file=marked.ax", "-o", "c.vdb", "-q"});
    write("wrong.ax",
          "\xef\xbb\xbf"
          "f@density = ;");
    expectError("ax_file = 'wrong.ax'", "scene.toml:8:11: wrong.ax:1:13: unexpected SEMICOLON");
}

TEST_F(Ax, ParametersAreFinite) {
    for (const std::string value : {"nan", "inf", "-inf", "1e39", "1,nan,3"})
        expectFailure({"make", "ax", "file=smoke.vdb", "code=f@density *= length(v$k);", "k=" + value, "-o", "c.vdb"},
                      2, "'k=" + value + "': expected finite numbers that fit into floats");
    expectError("ax = 'f@density *= $k;'\nparameters = { k = 1e39 }",
                "scene.toml:9:20: 'k' is 1e+39; expected numbers that fit into floats");
    expectError("ax = 'f@density *= $k;'\nparameters = { k = nan }", "scene.toml:9:20: 'k' is nan; expected a number");
}

TEST_F(Ax, APlanAsJsonSaysWhatAnExpressionCosts) {
    scene("ax = 'f@density *= 2; v@Cd = {1, 2, 3};'");
    const auto plan = nlohmann::json::parse(runWell({"plan", "scene.toml", "--json"}).out);
    ASSERT_EQ(plan[0]["messages"].size(), 1u) << plan[0]["messages"];
    EXPECT_EQ(plan[0]["messages"][0].get<std::string>().find(
                  "scene.toml:8:6: ax on smoke.vdb: reads 'density'; writes 'density', 'Cd'; 4394 voxels in "),
              0u)
        << plan[0]["messages"];
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

TEST_F(Ax, InfoDescribesAndMakeSavesTheGridsThatExpressionsLeave) {
    const ProgramResult info = runWell({"info", "smoke.vdb", "--ax", "f@density *= 2; v@Cd = {1, 2, 3};"});
    EXPECT_NE(info.out.find("reads 'density'; writes 'density', 'Cd'; 4394 voxels in "), std::string::npos) << info.out;
    EXPECT_NE(info.out.find("values         0.4 to 0.4"), std::string::npos) << info.out;
    EXPECT_NE(info.out.find("grid 'Cd'"), std::string::npos) << info.out;
    EXPECT_NE(runWell({"info", "smoke.vdb", "--ax", "f@density *= 2;", "--json"}).out.find("\"max_value\":0.4"),
              std::string::npos);
    expectFailure({"info", "smoke.vdb", "--ax", "f@density *= ;"}, 3, "--ax: line 1, column 14: unexpected SEMICOLON");
    runWell({"make", "ax", "file=smoke.vdb", "code=f@density *= $gain; f@heat = f@density;", "gain=2", "-o", "b.vdb",
             "-q"});
    const std::string saved = runWell({"info", "b.vdb"}).out;
    EXPECT_NE(saved.find("grid 'heat'"), std::string::npos) << saved;
    EXPECT_NE(saved.find("values         0.4 to 0.4"), std::string::npos) << saved;
    expectFailure({"make", "ax", "code=f@density *= 2;", "-o", "c.vdb"}, 2,
                  "make ax: expected file=IN.vdb, and code=CODE or ax_file=FILE or resample=2");
    expectFailure({"make", "ax", "file=smoke.vdb", "code=f@density *= $gain;", "gain=1,2", "-o", "c.vdb"}, 2,
                  "'gain=1,2': expected a number, or three with commas between them");
    expectFailure({"make", "ax", "file=smoke.vdb", "code=f@density *= 2;", "resample=nan", "-o", "c.vdb"}, 2,
                  "'resample=nan': expected a number from 0.125 to 16");
}

/// Expressions that are wrong, or that want too much: none may do more than fail.
std::vector<std::string> hostileCode() {
    const auto times = [](int count, const std::string& text) {
        std::string all;
        for (int i = 0; i < count; ++i) all += text;
        return all;
    };
    const std::string set = "f@density = ";
    return {
        // Text that is no program, or an odd one.
        " ",
        ";",
        "// nothing",
        "/* never ends",
        "\"",
        "string s = \"abc",
        "f@density = 'c';",
        "}{",
        "f@",
        "@",
        "$",
        "v$",
        "f@density",
        "density = 1;",
        "f@density == 1;",
        "1;",
        "float float = 1;",
        "if",
        "return;",
        "break;",
        "continue;",
        "\xc3\xa9 = 1;",
        "f@d\xc3\xa9 = 1;",
        "#include <stdio.h>",
        "import os;",
        "void f() { f(); }",
        // Nesting and length.
        set + times(90, "(") + "1" + times(90, ")") + ";",
        set + times(5000, "(") + "1" + times(5000, ")") + ";",
        times(3000, "{") + times(3000, "}"),
        times(50, "if (f@density > 0) ") + "f@density = 1;",
        set + times(200, "1 + ") + "1;",
        set + times(5000, "!") + "1;",
        times(1000, "f@density += 1;"),
        "// " + times(500000, "x"),
        times(150, "f@a") + " = 1;",
        // Numbers.
        set + "1e400;",
        set + "99999999999999999999999;",
        set + "1 / 0;",
        set + "1 % 0;",
        set + "1.0f / 0.0f;",
        set + "sqrt(-1.0f);",
        set + "log(0.0f) - log(0.0f);",
        set + "3e38f * 10.0f;",
        set + "-1.0f;",
        "i@n = getcoordx(); f@density = 1 / (i@n - i@n);",
        "int n = 0; f@density = 7 % n;",
        set + "1 << 70;",
        set + "pow(0.0f, -1.0f);",
        "double d = f@density; f@density = pow(d, 8);",
        "double d = 0; f@density = pow(d, -1);",
        // Grids that an expression makes for itself, and many of them.
        "f@scrim_together = 1; f@density = 2;",
        "float scrim_together_0 = 1; f@density = scrim_together_0; f@b = 1;",
        "f@a = rand(); f@b = rand(); f@c = rand(); return; f@density = 1;",
        // Wrong types, and grids and variables that are not there.
        set + "f@nothing;",
        set + "v@density;",
        "v@density = {1, 2, 3};",
        "s@density = \"a\";",
        "m4@density = 1;",
        "s@name = \"a\";",
        "m3@m = identity3();",
        "f@density = f@a; v@a = {1, 2, 3};",
        "f@density = $nothing;",
        "$frame = 1;",
        set + "v$frame;",
        "vec3f p = 1; f@density = p;",
        "f@density = {1, 2};",
        // What programs may not do.
        "open(\"/etc/passwd\");",
        "system(\"id\");",
        "f@density = read(\"/etc/passwd\");",
        "print(\"x\");",
        "f@density = external(\"HOME\");",
        "deletepoint();",
        "addtogroup(\"x\");",
        "f@density = lookup(\"x\");",
    };
}

TEST_F(Ax, HostileExpressionsEndWithAPictureOrALocatedError) {
    ProgramOptions limited;
    limited.shell = "ulimit -t 20; exec \"$0\" \"$@\"";
    const std::vector<std::string> all = hostileCode();
    EXPECT_GE(all.size(), 60u);
    scene("ax_file = 'a.ax'");
    int pictures = 0, errors = 0;
    for (const std::string& code : all) {
        write("a.ax", code);
        const ProgramResult result = run({"render", "scene.toml", "-o", "out.exr", "-q"}, limited);
        const std::string what = code.substr(0, 60) + "\n" + result.err;
        ASSERT_EQ(result.signal, 0) << what;
        ASSERT_FALSE(result.timedOut) << what;
        if (result.status == 0) {
            ++pictures;
            for (const float v : pixels(file("out.exr"))) ASSERT_TRUE(std::isfinite(v)) << what;
            continue;
        }
        ++errors;
        EXPECT_EQ(result.status, 3) << what;
        EXPECT_TRUE(result.err.starts_with("scrim: error: scene.toml:8:11: ")) << what;
        EXPECT_EQ(std::count(result.err.begin(), result.err.end(), '\n'), 1) << what;
    }
    EXPECT_GT(pictures, 10);
    EXPECT_GT(errors, 30);
}

TEST_F(Ax, ExpressionsThatNeverEndOrTakeAllMemoryMeetTheirLimits) {
    ProgramOptions limited;
    limited.shell = "ulimit -t 2; exec \"$0\" \"$@\"";
    for (const char* const code :
         {"for (;;) { f@density += 1; }", "do { f@density = 1; } while (true);",
          "int i = 0; while (i < 1000000000) { f@density += sin(i); }",
          "for (int i = 0; i < 100000000; ++i) for (int j = 0; j < 100000000; ++j) f@density += sin(i + j);"}) {
        scene("ax_file = 'a.ax'");
        write("a.ax", code);
        const ProgramResult result = run({"render", "scene.toml", "-o", "out.exr", "-q"}, limited);
        EXPECT_NE(result.status, 0) << code;
        EXPECT_TRUE(result.err.starts_with("scrim: error: scene.toml:8:11: smoke.vdb with its 'ax': ")) << result.err;
    }
    write("a.ax", "string s = \"0123456789abcdef\"; for (int i = 0; i < 40; ++i) { s = s + s; } f@density = atof(s);");
    const ProgramResult result = run({"render", "scene.toml", "-o", "out.exr", "-q", "--memory", "1G"}, limited);
    EXPECT_NE(result.status, 0);
    EXPECT_TRUE(result.err.starts_with("scrim: error: scene.toml:8:11: smoke.vdb with its 'ax': ")) << result.err;
    EXPECT_FALSE(result.timedOut);
}

#else

TEST_F(Ax, NamesThePackageThatExpressionsNeed) {
    scene("ax = 'f@density = 1;'");
    const ProgramResult result = run({"render", "scene.toml", "-o", "out.exr"});
    EXPECT_EQ(result.status, 1);
    EXPECT_TRUE(result.err.starts_with("scrim: error: scene.toml:8:6: this needs OpenVDB AX")) << result.err;
    EXPECT_NE(result.err.find("libopenvdb-ax-dev"), std::string::npos) << result.err;
}

#endif

}  // namespace
}  // namespace scrim::test
