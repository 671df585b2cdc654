// SPDX-License-Identifier: Apache-2.0
// `scrim merge` as it is called: crops of a render, put together, are the render; and what it refuses. How many threads
// a job of a farm takes.
#include "support/program_test.h"

#include <scrim/image/exr_read.h>

#include <OpenImageIO/deepdata.h>
#include <OpenImageIO/imagebuf.h>
#include <nlohmann/json.hpp>

#include <cstring>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

namespace scrim::test {
namespace {

constexpr int kUsage = 2, kInput = 3;

// Between the squares that are rendered at a time: elsewhere depths of the whole and of crops may round differently.
const std::vector<std::string> kCrops{"0,0,16,16", "16,0,32,16", "0,16,16,24", "16,16,32,24"};
const std::string kLayers = "[output]\nlayers = [\"light\", \"depth\", \"ambient\"]\ndeep = \"deep.exr\"\n";

class Merge : public ProgramTest {
  protected:
    /// Renders `crops`, flat and deep, and names the flat ones.
    std::vector<std::string> renderTiles(const std::vector<std::string>& crops = kCrops) {
        std::vector<std::string> tiles;
        for (const std::string& crop : crops) {
            tiles.push_back("tile" + std::to_string(tiles.size()) + ".exr");
            runWell({"render", "scene.toml", "--crop", crop, "-o", tiles.back(), "--deep", "deep." + tiles.back()});
        }
        return tiles;
    }
    static std::vector<std::string> mergeOf(std::vector<std::string> tiles, const std::string& whole,
                                            const std::string& prefix = "") {
        for (std::string& tile : tiles) tile = prefix + tile;
        tiles.insert(tiles.begin(), "merge");
        tiles.insert(tiles.end(), {"-o", whole});
        return tiles;
    }
    /// Every attribute but those that tell of the work, which tiles do apart.
    std::map<std::string, std::string> attributes(const std::string& name) const {
        auto all = readExrAttributes(file(name));
        all.erase("scrim:plan");
        all.erase("scrim:stats");
        return all;
    }
};

TEST_F(Merge, OfCropsIsTheRenderOfTheWhole) {
    for (const std::string more : {"", "overscan", "transmittance"}) {
        const std::string layers = more == "transmittance" ? "[output]\nlayers = [\"transmittance\"]\n" : kLayers;
        write("scene.toml", kCamera + (more == "overscan" ? "overscan = 3\n" : "") + kVolume + kLight +
                                (more == "transmittance" ? layers + "deep = \"deep.exr\"\n" : layers));
        runWell({"render", "scene.toml", "-o", "whole.exr"});
        const auto tiles = more == "overscan" ? renderTiles({"-3,-3,13,27", "13,-3,35,27"}) : renderTiles();
        const ProgramResult result = runWell(mergeOf(tiles, "merged.exr"));
        EXPECT_NE(result.err.find("merged.exr: " + std::to_string(tiles.size()) + " flat tiles, "), std::string::npos)
            << result.err;
        const auto wanted = attributes("whole.exr"), found = attributes("merged.exr");
        EXPECT_EQ(found, wanted);
        std::istringstream channels(wanted.at("channels"));
        int compared = 0;
        for (std::string channel; channels >> channel; ++compared) {
            const std::string name = channel.substr(0, channel.find(':'));
            const std::vector<float> a = readExrChannel(file("whole.exr"), name);
            const std::vector<float> b = readExrChannel(file("merged.exr"), name);
            ASSERT_EQ(a.size(), b.size());
            EXPECT_EQ(std::memcmp(a.data(), b.data(), a.size() * sizeof(float)), 0) << name << ' ' << more;
        }
        EXPECT_GE(compared, 7);
        const auto plans = nlohmann::json::parse(readExrAttributes(file("merged.exr")).at("scrim:plan"));
        EXPECT_EQ(plans.size(), tiles.size());
    }
}

TEST_F(Merge, OfDeepCropsIsTheDeepRenderOfTheWhole) {
    write("scene.toml", kCamera + kVolume + kLight + kLayers);
    runWell({"render", "scene.toml", "-o", "whole.exr"});
    runWell(mergeOf(renderTiles(), "merged.exr", "deep."));
    EXPECT_EQ(attributes("merged.exr"), attributes("deep.exr"));
    OIIO::ImageBuf whole(file("deep.exr")), merged(file("merged.exr"));
    ASSERT_TRUE(whole.read(0, 0, true)) << whole.geterror();
    ASSERT_TRUE(merged.read(0, 0, true)) << merged.geterror();
    const OIIO::DeepData &a = *whole.deepdata(), &b = *merged.deepdata();
    ASSERT_EQ(a.pixels(), b.pixels());
    int samples = 0;
    for (std::int64_t p = 0; p < a.pixels(); ++p) {
        ASSERT_EQ(a.samples(p), b.samples(p));
        samples += a.samples(p);
        for (int s = 0; s < a.samples(p); ++s)
            for (int c = 0; c < a.channels(); ++c) ASSERT_EQ(a.deep_value(p, c, s), b.deep_value(p, c, s));
    }
    EXPECT_GT(samples, 300);
}

TEST_F(Merge, RefusesWhatIsNoPicture) {
    const auto tiles = renderTiles();
    expectFailure({"merge"}, kUsage, "merge: expected one or more TILE.exr; see scrim merge --help");
    expectFailure({"merge", "tile0.exr"}, kUsage, "merge: expected -o WHOLE.exr, the file to write");
    expectFailure(mergeOf(tiles, "whole.png"), kUsage, "the output 'whole.png' does not end in '.exr'");
    expectFailure(mergeOf(tiles, "tile2.exr"), kUsage,
                  "--output 'tile2.exr' would overwrite the tile, which is read; write to another file");
    expectFailure(mergeOf({"tile0.exr", "tile1.exr", "tile2.exr"}, "whole.exr"), kInput,
                  "a tile is missing: none holds the pixels 16,16,32,24 of the picture 0,0,32,24");
    write("other.toml", kCamera + kVolume + kLight + "intensity = 2\n");
    runWell({"render", "other.toml", "--crop", kCrops[3], "-o", "other.exr"});
    expectFailure(mergeOf({"tile0.exr", "tile1.exr", "tile2.exr", "other.exr"}, "whole.exr"), kInput,
                  "cannot merge 'other.exr': it is not of the same render as 'tile0.exr': the attribute 'scrim:scene' "
                  "differs");
    expectFailure({"merge", "scene.toml", "-o", "whole.exr"}, kInput,
                  "cannot merge 'scene.toml': it is not an OpenEXR file, or it is truncated");
    expectFailure({"render", "scene.toml", "--deep", "deep.tif"}, kUsage,
                  "--deep: the deep picture 'deep.tif' does not end in '.exr'");
}

TEST_F(Merge, OfFurtherFilesNeedsTheirNames) {
    write("scene.toml", kCamera + kVolume + kLight +
                            "[[output]]\nfile = \"a.exr\"\n[[output]]\nfile = \"z.exr\"\nlayers = [\"depth\"]\n" +
                            "[[output]]\nfile = \"l.exr\"\nlayers = [\"light\"]\n");
    runWell({"render", "scene.toml"});
    for (const std::string i : {"0", "1", "2", "3"})
        runWell({"render", "scene.toml", "--crop", kCrops[std::size_t(std::stoi(i))], "-o", "a" + i + ".exr", "--file",
                 "z" + i + ".exr", "--file", "l" + i + ".exr"});
    for (const std::string name : {"a", "z", "l"}) {
        runWell(mergeOf({"0.exr", "1.exr", "2.exr", "3.exr"}, "merged.exr", name));
        EXPECT_EQ(attributes("merged.exr"), attributes(name + ".exr"));
    }
    expectFailure({"render", "scene.toml", "--file", "z.exr"}, kUsage,
                  "--file: expected one name for each further file of scene.toml, 2 in all; found 1");
    expectFailure({"render", "scene.toml", "--file", "z.exr", "--file", "l.png"}, kUsage,
                  "--file: 'l.png' does not end in '.exr'");
    expectFailure({"render", "scene.toml", "--file", "z.exr", "--file", "a.exr"}, kUsage,
                  "'a.exr' would be written twice, for the picture of scene.toml and for the file of layers at --file");
}

TEST_F(Merge, SaysWhichPicturesAreNotWhole) {
    const auto tiles = renderTiles();
    EXPECT_EQ(runWell({"merge", "--check", "tile0.exr", "tile1.exr"}).out, "");
    std::filesystem::resize_file(file("tile1.exr"), std::filesystem::file_size(file("tile1.exr")) / 2);
    const ProgramResult result = run({"merge", "--check", "tile0.exr", "tile1.exr", "none.exr"});
    EXPECT_EQ(result.status, kInput);
    EXPECT_EQ(result.out, "tile1.exr\nnone.exr\n");
    EXPECT_EQ(result.err, "scrim: error: 2 of 3 pictures are missing or incomplete\n");
    expectFailure({"merge", "--check", "tile0.exr", "-o", "a.exr"}, kUsage, "--check writes nothing; remove -o");
}

TEST_F(Merge, WarnsOfWhatIsLost) {
    write("scene.toml", kCamera + kVolume + kLight + "[output]\ncompression = \"dwaa\"\n");
    for (const std::size_t i : {0, 1, 2, 3})
        runWell({"render", "scene.toml", "--crop", kCrops[i], "-o", "t" + std::to_string(i) + ".exr", "--verify", "4"});
    const ProgramResult result = runWell({"merge", "t0.exr", "t1.exr", "t2.exr", "t3.exr", "-o", "whole.exr", "-q"});
    EXPECT_NE(result.err.find("whole.exr: the tiles have lossy compression, which is applied once more; render tiles "
                              "with lossless compression, and merge them with --compression dwaa\n"),
              std::string::npos)
        << result.err;
    EXPECT_NE(result.err.find("whole.exr: dropped attributes that describe single tiles: scrim:verify:alpha, "),
              std::string::npos)
        << result.err;
}

TEST_F(Merge, ThreadsAreThoseOfTheJob) {
    const auto threadsOf = [&](const std::vector<std::string>& more, const ProgramOptions& options) {
        std::vector<std::string> arguments{"render", "scene.toml", "-o", "a.exr", "--stats", "a.json"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        runWell(arguments, options);
        std::ifstream stream(file("a.json"));
        return nlohmann::json::parse(stream).at(0).at("threads").get<int>();
    };
    const auto job = [](const std::string& text) {
        ProgramOptions options;
        options.environment = {{"SLURM_CPUS_PER_TASK", text}};
        return options;
    };
    EXPECT_EQ(threadsOf({}, job("1")), 1);
    const int all = threadsOf({}, {});
    EXPECT_EQ(threadsOf({}, job("no number")), all);
    EXPECT_EQ(threadsOf({"--threads", "0"}, job("1")), all);
    ProgramOptions bound;
    bound.shell = "exec taskset -c \"$(taskset -cp $$ | sed 's/.*: //; s/[-,].*//')\" \"$0\" \"$@\"";
    EXPECT_EQ(threadsOf({}, bound), 1);
}

}  // namespace
}  // namespace scrim::test
