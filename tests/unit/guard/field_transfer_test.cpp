// SPDX-License-Identifier: Apache-2.0
#include <scrim/guard/field_transfer.h>

#include <scrim/volume/field_builder.h>
#include <scrim/volume/grid_request.h>

#include "support/expect_error.h"
#include "support/temp_folder.h"

#include <algorithm>
#include <cstring>
#include <limits>
#include <utility>

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

namespace scrim {
namespace {

using test::errorOf;

struct Transfer {
    int fd = createTransfer();
    ~Transfer() { ::close(fd); }
    std::string bytes() const {
        std::string all(static_cast<std::size_t>(::lseek(fd, 0, SEEK_END)), '\0');
        EXPECT_EQ(::pread(fd, all.data(), all.size(), 0), static_cast<ssize_t>(all.size()));
        return all;
    }
    void replace(const std::string& all) const {
        ASSERT_EQ(::ftruncate(fd, 0), 0);
        ASSERT_EQ(::pwrite(fd, all.data(), all.size(), 0), static_cast<ssize_t>(all.size()));
    }
};

constexpr std::size_t kBlockBytes = kBlockVoxels * sizeof(float);

SparseField sample(const std::string& name) {
    FieldBuilder builder(name, Mat4{{2, 0, 1, 0}, {0, 3, 0, 0}, {0, 1, 4, 0}, {10, 20, 30, 1}});
    std::array<float, kBlockVoxels> block{};
    block[3] = 0.5f;
    block[4] = -1;
    builder.addBlock({-8, 16, 0}, block.data());
    block[9] = 7;
    builder.addBlock({8, 16, 0}, block.data());
    builder.addTile({{-128, 0, 128}, 128, 9.0f});
    return builder.finish();
}

std::string incompleteReason(int fd) {
    return errorOf(ErrorKind::input, [&] { receiveFields(fd); });
}

TEST(FieldTransfer, HandsFieldsOverUnchangedFromAChild) {
    const Transfer transfer;
    const std::vector<SparseField> fields{sample("a"), sample("\xff b")};
    const pid_t child = ::fork();
    if (child == 0) {
        sendFields(transfer.fd, fields, {{Severity::warning, "careful"}, {Severity::info, "x"}});
        ::_exit(0);
    }
    int status = -1;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_EQ(status, 0);
    const ReceivedFields received = receiveFields(transfer.fd);
    ASSERT_EQ(received.fields.size(), 2u);
    ASSERT_EQ(received.messages.size(), 2u);
    EXPECT_EQ(received.messages[0].text, "careful");
    EXPECT_EQ(received.messages[0].severity, Severity::warning);
    EXPECT_EQ(received.messages[1].severity, Severity::info);
    const SparseField expected = sample("\xff b");
    const SparseField& field = received.fields[1];
    EXPECT_EQ(field.name, expected.name);
    EXPECT_EQ(field.wsFromIs, expected.wsFromIs);
    ASSERT_EQ(field.blockOrigins, expected.blockOrigins);
    EXPECT_EQ(std::memcmp(field.block(0), expected.block(0), 2 * kBlockVoxels * sizeof(float)), 0);
    ASSERT_EQ(field.tiles.size(), 1u);
    EXPECT_EQ(field.tiles[0].origin, Int3(-128, 0, 128));
    EXPECT_EQ(field.tiles[0].value, 9.0f);
    EXPECT_EQ(field.activeVoxels, expected.activeVoxels);
    EXPECT_EQ(field.negative, 2u);
    EXPECT_EQ(field.maxValue, 9.0f);
}

TEST(FieldTransfer, KeepsValuesAfterTheDescriptorIsClosed) {
    SparseField field;
    {
        const Transfer transfer;
        sendFields(transfer.fd, {sample("a")}, {});
        field = receiveFields(transfer.fd).fields.at(0);
    }
    EXPECT_EQ(field.block(1)[9], 7.0f);
}

TEST(FieldTransfer, WorksThroughARegularFileToo) {
    const test::TempFolder folder;
    const int fd = ::open(folder.file("t").c_str(), O_RDWR | O_CREAT, 0600);
    ASSERT_GE(fd, 0);
    sendFields(fd, {sample("a")}, {});
    EXPECT_EQ(receiveFields(fd).fields.at(0).block(1)[9], 7.0f);
    ::close(fd);
}

/// A field of `count` blocks, the last `empty` of which hold nothing, made in `memory`.
SparseField madeIn(BlockMemory& memory, std::size_t count, std::size_t empty) {
    FieldPieces pieces;
    pieces.name = "made";
    for (std::size_t i = 0; i < count; ++i) pieces.blockOrigins.push_back({8 * static_cast<int>(count - i), 0, 0});
    FieldFill fill(std::move(pieces), memory);
    for (std::size_t i = 0; i < count; ++i) {
        std::fill_n(fill.block(i), kBlockVoxels, i < empty ? 0.0f : static_cast<float>(i + 1));
        fill.filled(i);
    }
    return fill.finish();
}

std::uint64_t bytesInMemory(int fd) {
    struct stat status {};
    EXPECT_EQ(::fstat(fd, &status), 0);
    return static_cast<std::uint64_t>(status.st_blocks) * 512;
}

TEST(FieldTransfer, HandsOverFieldsMadeInPlaceWithoutACopy) {
    constexpr std::size_t kBlocks = 3000, kEmpty = 1000;  // more than a large page
    const Transfer transfer;
    const pid_t child = ::fork();
    if (child == 0) {
        TransferBlocks blocks(transfer.fd);
        std::vector<SparseField> fields{sample("before")};
        fields.push_back(madeIn(blocks, kBlocks, kEmpty));
        fields.push_back(madeIn(blocks, 5, 0));
        sendFields(transfer.fd, fields, {}, &blocks);
        ::_exit(0);
    }
    int status = -1;
    ASSERT_EQ(::waitpid(child, &status, 0), child);
    ASSERT_EQ(status, 0);
    // The memory of blocks without values went back to the system.
    EXPECT_LT(bytesInMemory(transfer.fd), (kBlocks - kEmpty) * kBlockBytes + (std::uint64_t{4} << 20));
    const ReceivedFields received = receiveFields(transfer.fd);
    ASSERT_EQ(received.fields.size(), 3u);
    BlockMemory memory;
    const std::vector<SparseField> expected{sample("before"), madeIn(memory, kBlocks, kEmpty), madeIn(memory, 5, 0)};
    for (std::size_t f = 0; f < 3; ++f) {
        const SparseField& field = received.fields[f];
        ASSERT_EQ(field.blockOrigins, expected[f].blockOrigins);
        EXPECT_EQ(std::memcmp(field.block(0), expected[f].block(0), field.blockCount() * kBlockBytes), 0);
        EXPECT_EQ(field.activeVoxels, expected[f].activeVoxels);
        EXPECT_EQ(field.maxValue, expected[f].maxValue);
    }
}

TEST(FieldTransfer, RefusesValuesThatLieInItsContents) {
    const Transfer source;
    sendFields(source.fd, {sample("a")}, {});
    const std::string whole = source.bytes();
    std::uint64_t contents = 0;
    std::memcpy(&contents, whole.data() + 16, sizeof contents);
    for (const std::uint64_t valuesAt :
         {contents, contents + 64, whole.size(), std::uint64_t{1} << 63, std::uint64_t{1}}) {
        std::string bytes = whole;
        std::memcpy(bytes.data() + contents, &valuesAt, sizeof valuesAt);  // the first number of the first field
        const Transfer transfer;
        transfer.replace(bytes);
        EXPECT_EQ(incompleteReason(transfer.fd), "what was read is incomplete: its values lie elsewhere");
    }
}

TEST(FieldTransfer, ThrowsTheErrorThatWasSent) {
    const Transfer transfer;
    sendError(transfer.fd, Error(ErrorKind::memory, "a.vdb: too large"));
    EXPECT_EQ(errorOf(ErrorKind::memory, [&] { receiveFields(transfer.fd); }), "a.vdb: too large");
    EXPECT_EQ(errorOf(ErrorKind::memory, [&] { receiveInfo(transfer.fd); }), "a.vdb: too large");
}

TEST(FieldTransfer, RefusesASenderThatStopped) {
    const std::string stopped = "what was read is incomplete: the process that read it stopped before it was done";
    const Transfer empty;
    EXPECT_EQ(incompleteReason(empty.fd), stopped);
    const Transfer source;
    sendFields(source.fd, {sample("a")}, {});
    std::string bytes = source.bytes();
    std::memset(bytes.data(), 0, 8);  // the header comes last
    const Transfer half;
    half.replace(bytes);
    EXPECT_EQ(incompleteReason(half.fd), stopped);
}

TEST(FieldTransfer, RefusesEveryTruncation) {
    const Transfer source;
    sendFields(source.fd, {sample("a"), sample("b")}, {{Severity::info, "m"}});
    const std::string whole = source.bytes();
    for (std::size_t size = 0; size < whole.size(); size += 1 + size / 40) {
        std::string part = whole.substr(0, size);
        if (size >= 16) std::memcpy(part.data() + 8, &size, sizeof size);  // a header that fits the truncation
        const Transfer cut;
        cut.replace(part);
        const std::string reason = incompleteReason(cut.fd);
        EXPECT_TRUE(reason.starts_with("what was read is incomplete: ")) << size << " bytes: " << reason;
    }
}

TEST(FieldTransfer, NeverBelievesDamagedBytes) {
    const Transfer source;
    sendFields(source.fd, {sample("a")}, {{Severity::info, "m"}});
    const std::string whole = source.bytes();
    // The header, and the contents behind the values.
    constexpr std::size_t kHeader = 64;
    for (std::size_t at = 0; at < whole.size(); at = at + 1 == kHeader ? kHeader + 2 * kBlockBytes : at + 1)
        for (const int bit : {0, 3, 7}) {
            std::string damaged = whole;
            damaged[at] = static_cast<char>(damaged[at] ^ (1 << bit));
            const Transfer transfer;
            transfer.replace(damaged);
            try {
                for (const SparseField& field : receiveFields(transfer.fd).fields)
                    for (std::size_t i = 0; i < field.blockCount(); ++i)
                        for (int n = 0; n < kBlockVoxels; ++n) {
                            ASSERT_GE(field.block(i)[n], 0) << at;
                            ASSERT_LE(field.block(i)[n], std::numeric_limits<float>::max()) << at;
                        }
            } catch (const Error&) {
                // refused: fine as well
            }
        }
}

TEST(FieldTransfer, RefusesValuesThatNoFieldMayHold) {
    for (const float bad : {-1.0f, std::numeric_limits<float>::infinity(), std::numeric_limits<float>::quiet_NaN()}) {
        const Transfer source;
        sendFields(source.fd, {sample("a")}, {});
        std::string bytes = source.bytes();
        std::memcpy(bytes.data() + 64 + 2 * kBlockBytes - sizeof bad, &bad, sizeof bad);  // behind the header
        const Transfer transfer;
        transfer.replace(bytes);
        EXPECT_EQ(incompleteReason(transfer.fd),
                  "what was read is incomplete: its blocks hold values that are negative or not finite");
    }
}

TEST(FieldTransfer, HandsOverWhichRequestAFileCannotServe) {
    const Transfer transfer;
    sendError(transfer.fd, GridError("a.vdb: no grid 'Cd'", {"Cd", 1}));
    try {
        receiveFields(transfer.fd);
        ADD_FAILURE() << "nothing was thrown";
    } catch (const GridError& error) {
        EXPECT_STREQ(error.what(), "a.vdb: no grid 'Cd'");
        EXPECT_EQ(error.request(), (GridRequest{"Cd", 1}));
    }
    std::string bytes = transfer.bytes();
    bytes.replace(bytes.rfind("1:Cd"), 4, "7:Cd");
    const Transfer damaged;
    damaged.replace(bytes);
    EXPECT_EQ(incompleteReason(damaged.fd),
              "what was read is incomplete: '7:Cd' requests no grid; expected "
              "scalar:NAME, 0:NAME, 1:NAME or 2:NAME");
}

TEST(FieldTransfer, HandsFileDescriptionsOver) {
    VdbFileInfo info;
    info.path = "/a/\xff.vdb";  // not UTF-8
    info.fileVersion = 224;
    info.libraryMajor = 10;
    info.metadata = {{"creator", "x"}};
    GridInfo grid;
    grid.name = "density";
    grid.valueType = "float";
    grid.codec = "blosc";
    grid.activeVoxels = 1ull << 60;
    grid.voxelSize = {0.1, 0.2, 0.3};
    grid.wsFromIs[3] = {1, 2, 3, 1};
    grid.isLower = {-5, 0, 1};
    grid.isUpper = {5, 6, 7};
    grid.maxValue = 1.0 / 3;
    grid.usable = true;
    grid.colour = true;
    info.grids = {grid};
    const Transfer transfer;
    sendInfo(transfer.fd, info);
    const VdbFileInfo got = receiveInfo(transfer.fd);
    EXPECT_EQ(got.path, "/a/\xef\xbf\xbd.vdb");
    EXPECT_EQ(got.metadata, info.metadata);
    ASSERT_EQ(got.grids.size(), 1u);
    EXPECT_EQ(got.grids[0].activeVoxels, grid.activeVoxels);
    EXPECT_EQ(got.grids[0].wsFromIs, grid.wsFromIs);
    EXPECT_EQ(got.grids[0].isLower, grid.isLower);
    EXPECT_EQ(got.grids[0].voxelSize, grid.voxelSize);
    EXPECT_EQ(got.grids[0].maxValue, grid.maxValue);
    EXPECT_TRUE(got.grids[0].usable);
    EXPECT_TRUE(got.grids[0].colour);
    EXPECT_EQ(incompleteReason(transfer.fd), "what was read is incomplete: it holds something else");
}

}  // namespace
}  // namespace scrim
