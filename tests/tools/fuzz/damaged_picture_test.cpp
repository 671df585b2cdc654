// SPDX-License-Identifier: Apache-2.0
// Damaged pictures, as guarded loads read them: whatever is wrong, the process that wants the slides goes on, and so
// does the program that reads them. SCRIM_FUZZ_FILES=N asks for N damaged files of each kind.
#include "support/program_test.h"
#include "tools/fuzz/damage.h"

#include <scrim/base/error.h>
#include <scrim/guard/guarded_load.h>

#include <OpenImageIO/imageio.h>

#include <random>
#include <string>
#include <vector>

namespace scrim::test {
namespace {

class DamagedPicture : public ProgramTest {
  protected:
    void writePicture(const std::string& name, OIIO::TypeDesc type) const {
        constexpr int kSize = 48;
        std::vector<float> pixels(kSize * kSize * 3);
        for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<float>(i * 7919 % 1000) / 1000;
        const auto out = OIIO::ImageOutput::create(file(name));
        ASSERT_TRUE(out);
        ASSERT_TRUE(out->open(file(name), OIIO::ImageSpec(kSize, kSize, 3, type)));
        ASSERT_TRUE(out->write_image(OIIO::TypeDesc::FLOAT, pixels.data()));
        ASSERT_TRUE(out->close());
    }
};

/// Reads the file, and holds what comes of it against what may come of it.
void readDamaged(const std::string& path, Outcomes& outcomes) {
    LoadOptions options;
    options.volumes = VolumeLoading::guarded;
    options.memory = std::size_t{1} << 30;
    try {
        const FilePicture picture = guardedPicture(path, options, {});
        (picture.problem.empty() ? outcomes.read : outcomes.refused) += 1;
        if (!picture.problem.empty()) return;
        EXPECT_EQ(picture.rgba.size(), 4 * std::size_t(picture.width) * std::size_t(picture.height));
    } catch (const Error& error) {
        outcomes.expectTold(error, path);
    }
}

TEST_F(DamagedPicture, OfEveryKindIsRefusedOrRead) {
    const int files = damagedFiles(100, 10);
    std::mt19937 random(5);
    for (const auto& [name, type] : {std::pair{"png", OIIO::TypeDesc::UINT8},
                                     {"exr", OIIO::TypeDesc::HALF},
                                     {"jpg", OIIO::TypeDesc::UINT8},
                                     {"tif", OIIO::TypeDesc::UINT16}}) {
        const std::string good = std::string("good.") + name, bad = std::string("bad.") + name;
        writePicture(good, type);
        const std::string bytes = readBytes(file(good));
        Outcomes outcomes;
        for (int i = 0; i < files; ++i) {
            const std::string damagedBytes = damaged(bytes, random);
            write(bad, damagedBytes);
            readDamaged(file(bad), outcomes);
            if (HasFailure()) return writeBytes(::testing::TempDir() + "/scrim_damaged." + name, damagedBytes);
        }
        outcomes.print(name);
        LoadOptions options;
        options.volumes = VolumeLoading::guarded;
        EXPECT_EQ(guardedPicture(file(good), options, {}).problem, "");
    }
}

TEST_F(DamagedPicture, IsAnErrorOfTheProgram) {
    writePicture("slide.png", OIIO::TypeDesc::UINT8);
    write("scene.toml", kCamera + kVolume +
                            "[[light]]\nname = \"lamp\"\ntype = \"projector\"\nposition = [10, 0, 40]\n"
                            "slide = { file = \"slide.png\", fov = 30 }\ntarget = [0, 0, 0]\n");
    const std::string good = readBytes(file("slide.png"));
    std::mt19937 random(7);
    for (int i = 0; i < 5; ++i) {
        write("slide.png", damaged(good, random));
        expectPlannedOrLocated(run({"plan", "scene.toml"}));
    }
}

}  // namespace
}  // namespace scrim::test
