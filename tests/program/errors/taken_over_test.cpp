// SPDX-License-Identifier: Apache-2.0
// What a child that was taken over by the file it read may hand over: anything. Here a loader's children hand over,
// byte by byte, the "file" they were given to read (support/echo_loader.cpp). The process that waits for them takes
// what could have been read, or says where and what was refused.
#include "support/program_test.h"

#include <scrim/image/colour.h>
#include <scrim/image/texture.h>
#include <scrim/image/texture_read.h>
#include <scrim/volume/field_builder.h>
#include <scrim/guard/field_transfer.h>
#include <scrim/guard/guarded_load.h>
#include <scrim/guard/load_fields.h>
#include <scrim/guard/picture_transfer.h>

#include "support/file_size_limit.h"
#include "support/expect_error.h"

#include <array>
#include <cmath>
#include <cstdint>
#include <cstring>
#include <functional>
#include <limits>
#include <string>
#include <vector>

#include <unistd.h>

namespace scrim::test {
namespace {

constexpr std::size_t kValuesAt = 64;  // of the first field, behind the header
const LoadOptions kTakenOver{VolumeLoading::guarded, SCRIM_ECHO_LOADER};
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();

std::string sent(const std::function<void(int)>& send) {
    const Descriptor transfer(createTransfer());
    send(transfer.fd());
    std::string bytes(static_cast<std::size_t>(::lseek(transfer.fd(), 0, SEEK_END)), '\0');
    EXPECT_EQ(::pread(transfer.fd(), bytes.data(), bytes.size(), 0), static_cast<ssize_t>(bytes.size()));
    return bytes;
}

template <typename T>
std::string with(std::string bytes, std::size_t at, const T& value) {
    std::memcpy(bytes.data() + at, &value, sizeof value);
    return bytes;
}

// Places in transfers of pictures (picture_transfer.cpp), after their header (transfer_file.h).
constexpr std::size_t kHeader = sizeof(TransferHeader), kWidth = kHeader, kHeight = kHeader + 4, kAspect = kHeader + 16,
                      kProblemSize = kHeader + 24;

class TakenOver : public ProgramTest {
  protected:
    static std::string picture(float value = 0.5f) {
        FilePicture picture;
        picture.width = 3;
        picture.height = 2;
        picture.rgba.assign(24, value);
        return sent([&](int fd) { sendPicture(fd, picture); });
    }
    static std::string field() {
        FieldBuilder builder("density", Mat4{1.0});
        std::array<float, kBlockVoxels> block{};
        block[3] = 0.5f;
        builder.addBlock({-8, 16, 0}, block.data());
        builder.addTile({{-128, 0, 128}, 128, 9.0f});
        const SparseField field = builder.finish();
        return sent([&](int fd) { sendFields(fd, {field}, {{Severity::warning, "careful"}}); });
    }
    static std::string asksFor(const std::string& name) {
        return sent([&](int fd) { sendError(fd, BesideError(Error(ErrorKind::input, "in: torn"), name)); });
    }

    FilePicture readPicture(const std::string& bytes) const {
        write("x.png", bytes);
        return guardedPicture(file("x.png"), kTakenOver, {});
    }
    /// What is said of it, without the place, which must be there.
    std::string refusedPicture(const std::string& bytes) const {
        return withoutPlace(errorOf(ErrorKind::input, [&] { readPicture(bytes); }), file("x.png"));
    }
    std::vector<SparseField> readFields(const std::string& bytes) const {
        write("x.nrrd", bytes);
        return sourceFields("scan", {{"file", file("x.nrrd")}}, kTakenOver, {});
    }
    std::string refusedFields(const std::string& bytes) const {
        return withoutPlace(errorOf(ErrorKind::input, [&] { readFields(bytes); }), "source 'scan': " + file("x.nrrd"));
    }
    static std::string withoutPlace(const std::string& text, const std::string& place) {
        const std::string start = place + ": damaged: ";
        EXPECT_EQ(text.rfind(start, 0), 0u) << text;
        const std::string reason = text.substr(std::min(text.size(), start.size()));
        const std::string incomplete = "what was read is incomplete: ";
        return reason.starts_with(incomplete) ? reason.substr(incomplete.size()) : reason;
    }
};

TEST_F(TakenOver, PicturesComeThroughWhereTheyAreSound) {
    const FilePicture got = readPicture(picture());
    EXPECT_EQ(got.width, 3);
    EXPECT_EQ(got.height, 2);
    EXPECT_EQ(got.rgba, std::vector<float>(24, 0.5f));
}

TEST_F(TakenOver, PicturesThatCannotBeAreRefused) {
    const std::string good = picture();
    for (const std::int32_t size : {0, -1, std::numeric_limits<std::int32_t>::min()})
        for (const std::size_t at : {kWidth, kHeight})
            EXPECT_EQ(refusedPicture(with(good, at, size)), "its picture has no pixels");
    constexpr std::int32_t kMost = std::numeric_limits<std::int32_t>::max();
    EXPECT_EQ(refusedPicture(with(with(good, kWidth, kMost), kHeight, kMost)), "its picture has too many pixels");
    EXPECT_EQ(refusedPicture(with(good, kWidth, kMost)), "its picture has too many pixels");
    EXPECT_EQ(refusedPicture(with(good, kWidth, 4)), "it is shorter than it says");
    EXPECT_EQ(refusedPicture(with(good, kHeight, 1 << 20)), "it is shorter than it says");
    EXPECT_EQ(refusedPicture(with(good, kWidth, 2)), "it is longer than its header says");
    for (const double aspect : {0.0, -1.0, 1e300, std::nan(""), std::numeric_limits<double>::infinity()})
        EXPECT_EQ(refusedPicture(with(good, kAspect, aspect)), "its pixel aspect ratio is invalid");
    for (const std::uint64_t size : {std::uint64_t{1} << 20, std::uint64_t{1} << 63, ~std::uint64_t{0}})
        EXPECT_EQ(refusedPicture(with(good, kProblemSize, size)), "it is shorter than it says");
    EXPECT_EQ(refusedPicture(""), "the process that read it stopped before it was done");
    EXPECT_EQ(refusedPicture(std::string(good.size(), '\0')), "the process that read it stopped before it was done");
    EXPECT_EQ(refusedPicture(field()), "it holds something else");
    EXPECT_EQ(refusedPicture(good + "x"), "it has 225 bytes, expected 224");
}

TEST_F(TakenOver, PicturesCutAnywhereAreRefused) {
    const std::string whole = picture();
    for (std::uint64_t size = 0; size < whole.size(); ++size) {
        std::string part = whole.substr(0, size);
        if (size >= 16) part = with(part, 8, size);  // a header that fits what is left
        EXPECT_NE(refusedPicture(part), "") << size;
    }
}

// Values that no colour has are the business of whoever makes a texture of the file's.
TEST_F(TakenOver, PicturesOfNoNumbersMakeBlackTextures) {
    for (const float value : {kNan, std::numeric_limits<float>::infinity(), -1.0f}) {
        std::vector<std::string> said;
        const auto texture = textureOf(readPicture(picture(value)), "x.png", "", ColourConfig::open(""),
                                       [&](Severity, const std::string& text) { said.push_back(text); });
        ASSERT_NE(texture, nullptr);
        EXPECT_EQ(said, std::vector<std::string>{"x.png: 24 values that are not finite or less than 0 count as 0"});
        for (const float v : texture->levels().at(0).rgba) EXPECT_EQ(v, 0);
    }
}

TEST_F(TakenOver, AnyDamagedBitOfAPictureIsRefusedOrHarmless) {
    const std::string good = picture();
    for (std::size_t at = 0; at < good.size(); ++at)
        for (const int bit : {0, 4, 7}) {
            std::string bad = good;
            bad[at] = static_cast<char>(bad[at] ^ (1 << bit));
            try {
                const FilePicture got = readPicture(bad);
                EXPECT_TRUE(!got.problem.empty() || got.rgba.size() == 4u * 6) << at;
            } catch (const Error& error) {
                EXPECT_FALSE(std::string(error.what()).starts_with("what was read")) << at << ": " << error.what();
            }
        }
}

TEST_F(TakenOver, FieldsComeThroughWhereTheyAreSound) {
    std::vector<std::string> said;
    write("x.nrrd", field());
    const auto got = sourceFields("scan", {{"file", file("x.nrrd")}}, kTakenOver,
                                  [&](Severity, const std::string& text) { said.push_back(text); });
    ASSERT_EQ(got.size(), 1u);
    EXPECT_EQ(got[0].maxValue, 9.0f);
    EXPECT_EQ(said, std::vector<std::string>{"careful"});
}

TEST_F(TakenOver, FieldsOfASourceThatCannotBeAreRefused) {
    const std::string good = field();
    EXPECT_EQ(refusedFields(sent([](int fd) { sendFields(fd, {}, {}); })), "no grid was made");
    constexpr std::size_t kLastValue = kValuesAt + (kBlockVoxels - 1) * sizeof(float);
    for (const float bad : {kNan, -1.0f, -0.0f})
        EXPECT_EQ(refusedFields(with(good, kLastValue, bad)), "its blocks hold values that are negative or not finite");
    EXPECT_EQ(refusedFields(with(good, good.size() - 4, -1.0f)), "a tile holds a value that is not above 0");
    EXPECT_EQ(refusedFields(picture()), "it holds something else");
    const std::uint64_t many = std::uint64_t{1} << 60;
    for (const std::size_t count : {offsetof(TransferHeader, fields), offsetof(TransferHeader, messages)})
        EXPECT_EQ(refusedFields(with(good, count, many)), "it is shorter than it says");
    for (std::uint64_t size = 0; size < good.size(); size += 1 + size / 30) {
        std::string part = good.substr(0, size);
        if (size >= 16) part = with(part, 8, size);
        EXPECT_NE(refusedFields(part), "") << size;
    }
}

TEST_F(TakenOver, AnyDamagedBitOfASourcesFieldIsRefusedOrHarmless) {
    const std::string good = field();
    const std::size_t contents = kValuesAt + kBlockVoxels * sizeof(float);  // what is said of the field
    for (std::size_t at = 0; at < good.size(); at = at + 1 == kValuesAt ? contents : at + 1)
        for (const int bit : {0, 4, 7}) {
            std::string bad = good;
            bad[at] = static_cast<char>(bad[at] ^ (1 << bit));
            try {
                for (const SparseField& got : readFields(bad)) EXPECT_LE(got.blockCount(), 1u);
            } catch (const Error& error) {
                EXPECT_FALSE(std::string(error.what()).starts_with("what was read")) << at << ": " << error.what();
            }
        }
}

TEST_F(TakenOver, OnlyFilesOfTheSameFolderCanBeAskedFor) {
    for (const std::string& name :
         {std::string("../x"), std::string("/etc/passwd"), std::string("sub/../../x"), std::string("sub/"),
          std::string("."), std::string(".."), std::string("a\0b", 3), std::string(256, 'x')})
        EXPECT_EQ(refusedFields(asksFor(name)), "it names a file in another folder") << name;
    // It is run again with that file, and asks again: that is the end.
    write("other", "1");
    for (const std::string& name : {std::string("other"), std::string("none")})
        EXPECT_EQ(errorOf(ErrorKind::input, [&] { readFields(asksFor(name)); }), "in: torn");
}

TEST_F(TakenOver, ErrorsAreOfThoseKindsThatReadingHas) {
    for (const ErrorKind kind : {ErrorKind::interrupted, ErrorKind::usage, ErrorKind::accuracy})
        EXPECT_EQ(errorOf(ErrorKind::input,
                          [&] { readFields(sent([&](int fd) { sendError(fd, Error(kind, "x.nrrd: torn")); })); }),
                  "x.nrrd: torn");
    EXPECT_EQ(errorOf(ErrorKind::memory,
                      [&] { readFields(sent([&](int fd) { sendError(fd, Error(ErrorKind::memory, "x: large")); })); }),
              "x: large");
    // What does not fit into a file is too large for memory, unless files have a limit of their own.
    const auto tooLarge = [&] {
        readFields(sent([&](int fd) { sendError(fd, Error(ErrorKind::output, "x: large")); }));
    };
    EXPECT_EQ(errorOf(ErrorKind::memory, tooLarge), "x: large");
    const FileSizeLimit limit(std::size_t{1} << 30);
    EXPECT_EQ(errorOf(ErrorKind::output, tooLarge), "x: large");
}

TEST_F(TakenOver, VolumesAndWhatIsKnownOfThemAreRefused) {
    const auto refused = [&](const std::string& bytes, const std::function<void(const std::string&)>& read) {
        write("x.vdb", bytes);
        return withoutPlace(errorOf(ErrorKind::input, [&] { read(file("x.vdb")); }), file("x.vdb"));
    };
    const auto fields = [](const std::string& path) { loadFields(path, {{}, {"other"}}, kTakenOver, {}); };
    const auto info = [](const std::string& path) { loadInfo(path, kTakenOver); };
    EXPECT_EQ(refused(field(), fields), "1 grids were read, expected 2");
    EXPECT_EQ(refused(picture(), fields), "it holds something else");
    EXPECT_EQ(refused(picture(), info), "it holds something else");
    EXPECT_EQ(refused("", info), "the process that read it stopped before it was done");
}

}  // namespace
}  // namespace scrim::test
