// SPDX-License-Identifier: Apache-2.0
// Files that are written: never over one that is read or over one another, in folders that need not be there, and made
// up for where an earlier run was killed.
#include "support/program_test.h"

#include <scrim/image/exr_read.h>
#include <scrim/image/picture_module.h>
#include <scrim/image/whole_picture.h>

#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <filesystem>
#include <map>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace scrim::test {
namespace {

constexpr int kUsage = 2, kInput = 3;

std::string overwrites(const std::string& what, const std::string& file, const std::string& role) {
    return what + " '" + file + "' would overwrite " + role + ", which is read; write to another file";
}

class Outputs : public ProgramTest {
  protected:
    /// As expectFailure, with what the folder holds unchanged.
    void expectRefusal(const std::vector<std::string>& arguments, const std::string& reason) const {
        const std::string volume = readBytes(file("smoke.vdb")), scene = readBytes(file("scene.toml"));
        expectFailure(arguments, kUsage, reason);
        EXPECT_TRUE(readBytes(file("smoke.vdb")) == volume);
        EXPECT_EQ(readBytes(file("scene.toml")), scene);
    }
};

TEST_F(Outputs, AreNeverTheVolume) {
    const std::string role = "the volume 'volume1'";
    std::filesystem::create_symlink("smoke.vdb", file("soft.json"));
    std::filesystem::create_hard_link(file("smoke.vdb"), file("hard.json"));
    std::filesystem::create_directory(file("sub"));
    for (const std::string path : {"smoke.vdb", "soft.json", "hard.json", "sub/../smoke.vdb"}) {
        expectRefusal({"render", "scene.toml", "--stats", path}, overwrites("--stats", path, role));
        expectRefusal({"render", "scene.toml", "--preview", path}, overwrites("the preview of scene.toml", path, role));
    }
    expectRefusal({"render", "smoke.vdb", "--stats", "smoke.vdb"},
                  overwrites("--stats", "smoke.vdb", "the volume 'smoke'"));
}

TEST_F(Outputs, AreNeverAFileOfASequence) {
    for (const char* name : {"s.1.vdb", "s.2.vdb"}) std::filesystem::copy_file(file("smoke.vdb"), file(name));
    for (const std::string path : {"s.1.vdb", "s.2.vdb"})
        expectRefusal({"render", "s.#.vdb", "--frames", "1", "--stats", path},
                      overwrites("--stats", path, "the volume 's'"));
}

TEST_F(Outputs, AreNeverTheScene) {
    expectRefusal({"render", "scene.toml", "--stats", "scene.toml"}, overwrites("--stats", "scene.toml", "the scene"));
    expectRefusal({"render", "smoke.vdb", "scene.toml", "-o", "o.exr", "--stats", "./scene.toml"},
                  "'o.exr' would be written twice, for the picture of smoke.vdb and for the picture of scene.toml");
}

TEST_F(Outputs, AreNeverASlide) {
    runWell({"render", "scene.toml", "-o", "slide.exr", "-q"});
    write("slide.toml", kCamera + kVolume +
                            "[[light]]\nname = \"beam\"\ntype = \"projector\"\nposition = [0, 0, 40]\n"
                            "target = [0, 0, 0]\nslide = { file = \"slide.exr\", fov = 30 }\n");
    expectRefusal({"render", "slide.toml", "-o", "slide.exr"},
                  overwrites("the picture of slide.toml", "slide.exr", "the slide of light 'beam'"));
}

TEST_F(Outputs, AreNeverTheBackplate) {
    runWell({"render", "scene.toml", "-o", "plate.exr", "-q"});
    write("over.toml", kCamera + kVolume + "[output]\npreview = { file = \"p.png\", backplate = \"plate.exr\" }\n");
    expectRefusal({"render", "over.toml", "-o", "plate.exr"},
                  overwrites("the picture of over.toml", "plate.exr", "the preview's backplate"));
}

TEST_F(Outputs, AreNeverThePictureOfTheCamera) {
    runWell({"render", "scene.toml", "-o", "plate.exr", "-q"});
    write("plate.toml", "[camera]\nexr = \"plate.exr\"\n" + kVolume + kLight);
    expectRefusal({"render", "plate.toml", "-o", "./plate.exr"},
                  overwrites("the picture of plate.toml", "./plate.exr", "the picture that the camera is that of"));
    runWell({"render", "plate.toml", "-o", "other.exr"});
}

TEST_F(Outputs, AreNeverTheColourConfig) {
    write("c.ocio", readBytes(file("scene.toml")));
    const ProgramResult result = run({"render", "scene.toml", "--ocio", "c.ocio", "--stats", "c.ocio"});
    EXPECT_NE(result.status, 0);
    EXPECT_EQ(readBytes(file("c.ocio")), readBytes(file("scene.toml")));
}

TEST_F(Outputs, AreNeverOneAnother) {
    expectRefusal({"render", "scene.toml", "-o", "x.exr", "--preview", "./x.exr"},
                  "'./x.exr' would be written twice, for the picture of scene.toml and for the preview of scene.toml");
    expectRefusal({"render", "scene.toml", "-o", "x.exr", "--stats", "sub/../x.exr"},
                  "'sub/../x.exr' would be written twice, for the picture of scene.toml and for --stats");
    write("old.exr", "old");
    std::filesystem::create_symlink("old.exr", file("p.png"));
    expectRefusal({"render", "scene.toml", "-o", "old.exr", "--preview", "p.png"},
                  "'p.png' would be written twice, for the picture of scene.toml and for the preview of scene.toml");
    EXPECT_EQ(readBytes(file("old.exr")), "old");
}

TEST_F(Outputs, GoWhereLinksLead) {
    std::filesystem::create_directory(file("real"));
    std::filesystem::create_symlink("real/v2.exr", file("latest.exr"));
    std::filesystem::create_symlink("real/v2.exr", file("twin.png"));
    write("real/.scrim-host-1-0.exr", "left by a writer that was killed");
    std::filesystem::last_write_time(file("real/.scrim-host-1-0.exr"),
                                     std::filesystem::file_time_type::clock::now() - std::chrono::hours(25));
    expectRefusal({"render", "scene.toml", "-o", "latest.exr", "--preview", "twin.png"},
                  "'twin.png' would be written twice, for the picture of scene.toml and for the preview of scene.toml");
    runWell({"render", "scene.toml", "-o", "latest.exr"});
    EXPECT_TRUE(std::filesystem::is_symlink(file("latest.exr")));
    EXPECT_TRUE(std::filesystem::is_regular_file(file("real/v2.exr")));
    EXPECT_FALSE(exists("real/.scrim-host-1-0.exr"));
}

TEST_F(Outputs, OfMakeAreVolumesAndNotItsInput) {
    expectRefusal({"make", "noise", "-o", "scene.toml"}, "the output 'scene.toml' does not end in '.vdb'");
    expectRefusal({"make", "mesh", "file=./smoke.vdb", "-o", "smoke.vdb"},
                  overwrites("--output", "smoke.vdb", "the source's 'file'"));
    // No other parameter is a path.
    expectFailure({"make", "noise", "shape=b.vdb", "-o", "b.vdb"}, kInput,
                  "source 'noise': parameter 'shape' is 'b.vdb', expected 'plume', 'ball', 'slab', 'box' or "
                  "'hypertexture'");
    expectRefusal({"make", "noise", "-o", ""}, "make: expected -o OUT.vdb, the file to write");
}

TEST_F(Outputs, OfAStudyAreNoInputs) {
    std::filesystem::create_directory(file("d"));
    std::filesystem::create_symlink("../smoke.vdb", file("d/study.csv"));
    expectRefusal({"study", "scene.toml", "-o", "d"},
                  overwrites("a result of the study", "d/study.csv", "the volume 'volume1'"));
}

TEST_F(Outputs, HaveNames) {
    expectRefusal({"render", "scene.toml", "-o", ""}, "--output: the name is empty");
    expectRefusal({"render", "scene.toml", "--stats", ""}, "--stats: the name is empty");
    expectRefusal({"render", "scene.toml", "--preview", ""}, "--preview: the name is empty");
    expectRefusal({"study", "scene.toml", "-o", ""}, "--output: the name is empty");
}

TEST_F(Outputs, HaveTheirFoldersMade) {
    runWell({"render", "scene.toml", "-o", "a/b/x.exr", "--preview", "c/d/x.png", "--stats", "e/s.json"});
    runWell({"make", "noise", "resolution=8", "-o", "f/g/n.vdb"});
    for (const char* name : {"a/b/x.exr", "c/d/x.png", "e/s.json", "f/g/n.vdb"}) EXPECT_TRUE(exists(name)) << name;
}

TEST_F(Outputs, ThatFailLeaveNoFolders) {
    std::filesystem::resize_file(file("smoke.vdb"), std::filesystem::file_size(file("smoke.vdb")) / 2);
    const std::set<std::string> before = listing();
    EXPECT_EQ(run({"render", "scene.toml", "-o", "a/b/x.exr"}).status, 3);
    EXPECT_EQ(listing(), before);
}

TEST_F(Outputs, OfKilledRunsAreSwept) {
    const pid_t gone = ::fork();
    if (gone == 0) ::_exit(0);
    ::waitpid(gone, nullptr, 0);
    std::string host(65, '\0');
    ::gethostname(host.data(), host.size() - 1);
    const std::string left = std::string(".scrim-") + host.c_str() + "-" + std::to_string(gone) + "-0.exr";
    for (const std::string folder : {"o/", "p/", ""}) {
        std::filesystem::create_directories(file(folder));
        write(folder + left, "half");
    }
    runWell({"render", "scene.toml", "-o", "o/x.exr", "--preview", "p/x.png", "--stats", "s.json"});
    for (const std::string folder : {"o/", "p/", ""}) EXPECT_FALSE(exists(folder + left)) << folder;
}

// ---- deep pictures

class DeepOutput : public ProgramTest {};

TEST_F(DeepOutput, NeverMeetsAnotherFile) {
    const auto with = [&](const std::string& deep) {
        return run({"render", "scene.toml", "-o", "x.exr", "--set", "output.deep=" + deep});
    };
    const ProgramResult same = with("x.exr");
    EXPECT_EQ(same.status, 2);
    EXPECT_NE(same.err.find("would be written twice, for the picture of scene.toml and for the deep picture of "
                            "scene.toml"),
              std::string::npos)
        << same.err;
    EXPECT_EQ(with("d.png").status, 3);
    std::filesystem::create_directory(file("folder.exr"));
    EXPECT_EQ(with("folder.exr").status, 4);
    EXPECT_FALSE(exists("x.exr")) << "seen before anything is rendered";
}

TEST_F(DeepOutput, OfTheCommandLineHasTheTypeThatTheSceneStates) {
    runWell({"render", "scene.toml", "-o", "x.exr", "--deep", "d.exr", "--set", "output.deep_type=float"});
    EXPECT_TRUE(isWholeExr(file("d.exr")));
    EXPECT_EQ(run({"render", "scene.toml", "-o", "x.exr", "--set", "output.deep_type=float"}).status, 3);
}

TEST_F(DeepOutput, IsPlannedAndWrittenBesideThePicture) {
    const std::vector<std::string> deep{"--set", "output.deep=new/d.exr", "--set", "output.deep_type=float"};
    const auto with = [&](std::vector<std::string> arguments) {
        arguments.insert(arguments.end(), deep.begin(), deep.end());
        return runWell(arguments);
    };
    EXPECT_NE(with({"plan", "scene.toml"}).out.find("deep picture            on   samples merged within 0.01"),
              std::string::npos);
    EXPECT_FALSE(exists("new"));
    runWell({"render", "scene.toml", "-o", "flat.exr"});
    with({"render", "scene.toml", "-o", "x.exr"});
    EXPECT_EQ(readExr(file("x.exr")).rgba, readExr(file("flat.exr")).rgba);
    EXPECT_TRUE(isWholeExr(file("new/d.exr")));
    const auto attributes = readExrAttributes(file("x.exr"));
    auto ofDeep = readExrAttributes(file("new/d.exr"));
    for (const char* name : {"worldToCamera", "worldToNDC", "colorInteropID", "software", "imageCounter",
                             "displayWindow", "pixelAspectRatio", "scrim:camera", "scrim:plan"})
        EXPECT_EQ(ofDeep[name], attributes.at(name)) << name;
    EXPECT_EQ(ofDeep["compression"], "zips");
}

TEST_F(DeepOutput, WarnsOfColouredExtinction) {
    const std::vector<std::string> arguments{"render", "scene.toml", "-o", "x.exr", "--set", "output.deep=d.exr"};
    EXPECT_EQ(runWell(arguments).err.find("one alpha for all channels"), std::string::npos);
    write("tint.toml", readBytes(file("scene.toml")) + "\n[output]\ndeep = \"d.exr\"\n");
    const ProgramResult result =
        runWell({"render", "tint.toml", "-o", "x.exr", "--set", "volume.volume1.medium.extinction_tint=[1, 0.5, 0.2]"});
    EXPECT_NE(result.err.find("one alpha for all channels"), std::string::npos) << result.err;
    EXPECT_NE(result.err.find("tint.toml:"), std::string::npos) << result.err;
}

// ---- --skip-existing

// Each layer is where it is asked for, and as it is in one file with all of them.
TEST_F(Outputs, HoldTheLayersThatTheyAreAskedFor) {
    const std::string scene = kCamera + kVolume + kLight + "[volume.medium]\nscattering = \"full\"\n";
    write("all.toml",
          scene + "[output]\nfile = \"all.exr\"\nlayers = [\"light\", \"direct\", \"indirect\", \"depth\"]\n");
    write("apart.toml", scene +
                            "[[output]]\nfile = \"a.exr\"\nlayers = [\"direct\"]\n[[output]]\nfile = \"sub/z.exr\"\n"
                            "layers = [\"depth\", \"light\"]\n[[output]]\nfile = \"b.exr\"\npicture = true\n");
    runWell({"render", "all.toml"});
    runWell({"render", "apart.toml"});
    const auto channels = [&](const std::string& name) {
        std::map<std::string, std::vector<float>> found;
        std::istringstream words(readExrAttributes(file(name)).at("channels"));
        for (std::string word; words >> word;) {
            const std::string channel = word.substr(0, word.find(':'));
            found[channel] = readExrChannel(file(name), channel);
        }
        return found;
    };
    const auto all = channels("all.exr");
    for (const auto& [name, expected] : std::map<std::string, std::set<std::string>>{
             {"a.exr", {"R", "G", "B", "A", "direct.R", "direct.G", "direct.B"}},
             {"sub/z.exr", {"Z", "depth.mean", "light.key.R", "light.key.G", "light.key.B"}},
             {"b.exr", {"R", "G", "B", "A"}}}) {
        const auto found = channels(name);
        std::set<std::string> names;
        for (const auto& [channel, values] : found) {
            names.insert(channel);
            EXPECT_TRUE(values == all.at(channel)) << name << " " << channel;
        }
        EXPECT_EQ(names, expected) << name;
    }
    // Half floats.
    for (std::size_t i = 0; i < all.at("R").size(); ++i)
        ASSERT_NEAR(all.at("direct.R")[i] + all.at("indirect.R")[i], all.at("R")[i], 2e-3 * all.at("R")[i] + 1e-6) << i;
    expectFailure({"render", "apart.toml", "-o", "b.exr"}, kUsage,
                  "'b.exr' would be written twice, for the picture of apart.toml and for the file of layers at "
                  "apart.toml:21:8");
    write("twice.toml", kCamera + kVolume + kLight +
                            "[[output]]\nfile = \"a.exr\"\n[[output]]\nfile = \"b.exr\"\nlayers = [\"depth\"]\n"
                            "[[output]]\nfile = \"b.exr\"\nlayers = [\"direct\"]\n");
    expectFailure({"render", "twice.toml"}, kUsage,
                  "'b.exr' would be written twice, for the file of layers at twice.toml:15:8 and for the file of "
                  "layers at twice.toml:18:8");
}

class SkipExisting : public ProgramTest {
  protected:
    const std::vector<std::string> m_arguments{"render",     "scene.toml", "-o",  "o.####.exr",     "--preview",
                                               "o.####.png", "--frames",   "1-3", "--skip-existing"};

    void expectLine(const ProgramResult& result, const std::string& line) const {
        EXPECT_NE(result.err.find(line), std::string::npos) << result.err;
    }
    std::vector<float> pixelsOf(const std::string& name) const { return pictureModule().read(file(name)).rgba; }
    /// By a step of 8 bits at most: a picture that was read again is rounded to half floats.
    static void expectNear(const std::vector<float>& found, const std::vector<float>& expected) {
        ASSERT_EQ(found.size(), expected.size());
        for (std::size_t i = 0; i < found.size(); ++i) ASSERT_NEAR(found[i], expected[i], 1.01f / 255) << i;
    }
};

TEST_F(SkipExisting, LeavesWholePicturesAlone) {
    runWell(m_arguments);
    const auto before = std::filesystem::last_write_time(file("o.0001.exr"));
    std::filesystem::remove(file("o.0002.exr"));
    const ProgramResult result = runWell(m_arguments);
    EXPECT_EQ(std::filesystem::last_write_time(file("o.0001.exr")), before);
    expectLine(result, "frame 1: o.0001.exr exists already\n");
    expectLine(result, "frame 2: o.0002.exr 32x24");
    expectLine(result, "frame 3: o.0003.exr exists already\n");
}

TEST_F(SkipExisting, RendersPicturesAgainThatAreNotWhole) {
    runWell(m_arguments);
    const std::string whole = readBytes(file("o.0001.exr"));
    write("o.0001.exr", "");
    std::filesystem::resize_file(file("o.0002.exr"), whole.size() / 2);
    const ProgramResult result = runWell(m_arguments);
    expectLine(result, "frame 1: o.0001.exr is incomplete; rendering it again\n");
    expectLine(result, "frame 2: o.0002.exr is incomplete; rendering it again\n");
    expectLine(result, "frame 3: o.0003.exr exists already\n");
    EXPECT_TRUE(readBytes(file("o.0001.exr")) == whole);
    EXPECT_EQ(readBytes(file("o.0002.exr")).size(), readBytes(file("o.0003.exr")).size());
}

TEST_F(SkipExisting, MakesUpForPreviews) {
    runWell(m_arguments);
    const std::vector<float> preview = pixelsOf("o.0001.png");
    const auto size = std::filesystem::file_size(file("o.0001.png"));
    const auto before = std::filesystem::last_write_time(file("o.0003.exr"));
    std::filesystem::remove(file("o.0001.png"));
    write("o.0002.png", "");
    std::filesystem::resize_file(file("o.0003.png"), size / 2);
    const ProgramResult result = runWell(m_arguments);
    for (const std::string name : {"o.0001", "o.0002", "o.0003"}) {
        expectLine(result, name + ".exr exists already; its preview was made\n");
        expectNear(pixelsOf(name + ".png"), preview);
    }
    EXPECT_EQ(std::filesystem::last_write_time(file("o.0003.exr")), before) << "pictures stay";
    EXPECT_EQ(runWell(m_arguments).err.find("preview"), std::string::npos);
}

TEST_F(SkipExisting, RendersAgainWhatHasNoWholeDeepPicture) {
    std::vector<std::string> arguments = m_arguments;
    arguments.insert(arguments.end(), {"--set", "output.deep=o.deep.####.exr"});
    runWell(arguments);
    const std::string whole = readBytes(file("o.deep.0001.exr"));
    std::filesystem::remove(file("o.deep.0001.exr"));
    std::filesystem::resize_file(file("o.deep.0002.exr"), whole.size() / 2);
    const auto before = std::filesystem::last_write_time(file("o.0003.exr"));
    const ProgramResult result = runWell(arguments);
    expectLine(result, "frame 1: o.0001.exr is complete, but a file beside it is not; rendering it again\n");
    expectLine(result, "frame 2: o.0002.exr is complete, but a file beside it is not; rendering it again\n");
    expectLine(result, "frame 3: o.0003.exr exists already\n");
    EXPECT_TRUE(readBytes(file("o.deep.0001.exr")) == whole);
    EXPECT_EQ(std::filesystem::last_write_time(file("o.0003.exr")), before);
}

TEST_F(SkipExisting, RendersAgainWhatHasNoFurtherFile) {
    std::vector<std::string> arguments = m_arguments;
    arguments.insert(arguments.end(), {"--set", "output.files=[{file=\"z.####.exr\", layers=[\"depth\"]}]"});
    runWell(arguments);
    const std::string whole = readBytes(file("z.0001.exr"));
    std::filesystem::remove(file("z.0001.exr"));
    const ProgramResult result = runWell(arguments);
    expectLine(result, "frame 1: o.0001.exr is complete, but a file beside it is not; rendering it again\n");
    expectLine(result, "frame 2: o.0002.exr exists already\n");
    EXPECT_TRUE(readBytes(file("z.0001.exr")) == whole);
}

TEST_F(SkipExisting, MakesUpForPreviewsAsBrightAsTheyWere) {
    std::vector<std::string> arguments = m_arguments;
    arguments.insert(arguments.end(), {"--exposure", "2"});
    runWell(arguments);
    const std::vector<float> preview = pixelsOf("o.0001.png");
    std::filesystem::remove(file("o.0001.png"));
    runWell(arguments);
    expectNear(pixelsOf("o.0001.png"), preview);
}

TEST_F(SkipExisting, MakesUpForPreviewsOfAnyFormat) {
    std::vector<std::string> arguments = m_arguments;
    arguments[5] = "o.####.tif";
    runWell(arguments);
    const std::vector<float> preview = pixelsOf("o.0001.tif");
    write("o.0001.tif", "no picture");
    expectLine(runWell(arguments), "frame 1: o.0001.exr exists already; its preview was made\n");
    expectNear(pixelsOf("o.0001.tif"), preview);
    EXPECT_EQ(runWell(arguments).err.find("preview"), std::string::npos);
}

TEST_F(SkipExisting, MakesPreviewsFromTheSpaceOfThePicture) {
    const std::vector<std::string> arguments{"render",
                                             "smoke.vdb",
                                             "-o",
                                             "o.exr",
                                             "--preview",
                                             "o.png",
                                             "--set",
                                             "output.colorspace=Linear Rec.709 (sRGB)",
                                             "--set",
                                             "output.type=float",
                                             "--skip-existing"};
    const ProgramResult first = run(arguments);
    ASSERT_EQ(first.status, 0) << first.err;
    const std::vector<float> preview = pictureModule().read(file("o.png")).rgba;
    std::filesystem::remove(file("o.png"));
    expectLine(runWell(arguments), "frame 1: o.exr exists already; its preview was made\n");
    const std::vector<float> again = pictureModule().read(file("o.png")).rgba;
    ASSERT_EQ(again.size(), preview.size());
    // There and back between colour spaces is rounded; unconverted, colours are tens of steps off.
    for (std::size_t i = 0; i < again.size(); ++i) ASSERT_NEAR(again[i], preview[i], 1.01 / 255) << i;
}

}  // namespace
}  // namespace scrim::test
