// SPDX-License-Identifier: Apache-2.0
// Pictures read by a confined process: whatever OpenImageIO's formats do with a good file, the filter allows it.
#include "support/program_test.h"

#include <scrim/image/picture_module.h>
#include <scrim/guard/guarded_load.h>

#include "support/loader_processes.h"

#include <OpenImageIO/imageio.h>
#include <OpenImageIO/strutil.h>

#include <iostream>
#include <set>
#include <string>
#include <vector>

#include <unistd.h>

namespace scrim::test {
namespace {

class PictureLoader : public ProgramTest {
  protected:
    void SetUp() override { m_options.volumes = VolumeLoading::guarded; }
    /// False where the format has no such pictures.
    bool writePicture(const std::string& path, const std::string& format) const {
        const auto out = OIIO::ImageOutput::create(format);
        // As wide as libheif's rows are in memory: OpenImageIO 2.4 copies whole ones, past the end of a shorter row.
        constexpr int kSide = 64;
        const OIIO::ImageSpec spec(kSide, kSide, 3, OIIO::TypeDesc::UINT8);
        if (!out || !out->open(path, spec)) return false;
        std::vector<float> pixels(kSide * kSide * 3);
        for (std::size_t i = 0; i < pixels.size(); ++i) pixels[i] = static_cast<float>(i % 17) / 17;
        return out->write_image(OIIO::TypeDesc::FLOAT, pixels.data()) && out->close();
    }
    void expectSame(const std::string& path) const {
        const FilePicture here = pictureModule().read(path), there = guardedPicture(path, m_options, {});
        EXPECT_EQ(there.problem, here.problem) << path;
        EXPECT_EQ(there.width, here.width) << path;
        EXPECT_EQ(there.height, here.height) << path;
        EXPECT_EQ(there.rgba, here.rgba) << path;
        EXPECT_EQ(there.integers, here.integers) << path;
        EXPECT_EQ(there.alphaApart, here.alphaApart) << path;
        EXPECT_EQ(there.pixelAspect, here.pixelAspect) << path;
    }

    LoadOptions m_options;
};

TEST_F(PictureLoader, ReadsEveryFormatAsThisProcessDoes) {
    // Not pictures at all: they end the process where they are written, or take no file.
    const std::set<std::string> others{"null", "term", "openvdb", "ptex"};
    int written = 0;
    for (const std::string& entry : OIIO::Strutil::splits(OIIO::get_string_attribute("extension_list"), ";")) {
        const std::string format = entry.substr(0, entry.find(':'));
        if (format.empty() || others.contains(format)) continue;
        const std::string extensions = entry.substr(entry.find(':') + 1);
        const std::string path = file("picture." + extensions.substr(0, extensions.find(',')));
        if (!writePicture(path, format)) continue;
        ++written;
        expectSame(path);
        // Without the ending every format is tried.
        const std::string unnamed = file("picture_" + format);
        std::filesystem::copy_file(path, unnamed);
        expectSame(unnamed);
    }
    EXPECT_GT(written, 8);
}

TEST_F(PictureLoader, SaysWhatThisProcessSaysOfFilesThatAreNoPictures) {
    write("text.png", "This is not a picture.");
    write("empty.exr", "");
    write("text", "This is not a picture.");
    for (const char* name : {"text.png", "empty.exr", "text"}) expectSame(file(name));
}

// Running programs that this process started and that have OpenImageIO, which those for volumes do not.
std::vector<int> pictureLoaders() {
    std::vector<int> found;
    for (const LoaderProcess& process : loaderProcesses())
        if (process.parent == ::getpid() && hasMapped(process.id, "libOpenImageIO.so")) found.push_back(process.id);
    return found;
}

TEST_F(PictureLoader, StartsOnceAndServesAll) {
    for (const char* name : {"a.png", "b.png"}) ASSERT_TRUE(writePicture(file(name), "png"));
    expectSame(file("a.png"));
    const std::vector<int> running = pictureLoaders();
    ASSERT_EQ(running.size(), 1u);
    write("damaged.png", "This is not a picture.");
    for (int i = 0; i < 50; ++i)
        for (const char* name : {"a.png", "damaged.png", "b.png"}) expectSame(file(name));
    EXPECT_EQ(pictureLoaders(), running);
}

}  // namespace
}  // namespace scrim::test
