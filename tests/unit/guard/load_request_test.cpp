// SPDX-License-Identifier: Apache-2.0
// What a child is asked to do.
#include <scrim/guard/load_request.h>

#include <scrim/base/descriptor.h>
#include <scrim/guard/transfer_file.h>

#include "support/expect_error.h"

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

#include <gtest/gtest.h>

namespace scrim {
namespace {

LoadEdit edit() {
    LoadEdit out{{}, "/lib/scrim_ax.so"};
    out.edit.resample = 2;
    out.edit.density = "density";
    out.edit.programs.push_back({"@density *= 2;", "scene.toml:7:6", "scene.toml", 7, 6});
    return out;
}

const std::vector<GridRequest> kGrids{{"density"}, {"Cd", 1}, {"v", 2, GridPart::negative}};

/// A task of each kind, with something in each of its members, and some without.
std::vector<LoadTask> tasks() {
    return {FieldsTask{kGrids},
            FieldsTask{kGrids, edit()},
            InfoTask{},
            InfoTask{edit()},
            EditedFileTask{edit()},
            MadeFieldsTask{kGrids, edit()},
            SourceTask{"/lib/scan.so", {{"file", "a.nhdr"}, {"size", "1, 2, 3"}}, "a.raw"},
            MeshTask{"/lib/scrim_meshes.so"},
            PhotometryTask{},
            PictureTask{},
            HeaderTask{},
            DepthTask{"Z"}};
}

LoadRequest passed(const LoadRequest& request) {
    const Descriptor transfer(createTransfer());
    sendRequest(transfer.fd(), request);
    return receiveRequest(transfer.fd());
}

TEST(LoadRequest, ArrivesAsItWasSent) {
    std::vector<bool> kinds(std::variant_size_v<LoadTask>);
    for (const LoadTask& task : tasks()) {
        const LoadRequest got = passed({"a folder/file.vdb", task});
        EXPECT_EQ(got.path, "a folder/file.vdb");
        EXPECT_TRUE(got.task == task) << task.index();
        kinds[task.index()] = true;
    }
    EXPECT_EQ(kinds, std::vector<bool>(kinds.size(), true));
}

TEST(LoadRequest, HasItsEditWhereItsTaskCan) {
    for (const LoadTask& task : tasks()) {
        const LoadEdit* const first = editOf(task);
        const bool edits = std::holds_alternative<EditedFileTask>(task) || std::holds_alternative<MadeFieldsTask>(task);
        if (edits) {
            ASSERT_NE(first, nullptr) << task.index();
        }
        if (first != nullptr) {
            EXPECT_TRUE(*first == edit()) << task.index();
        }
    }
    EXPECT_EQ(editOf(FieldsTask{kGrids}), nullptr);
    EXPECT_EQ(editOf(InfoTask{}), nullptr);
    EXPECT_EQ(editOf(SourceTask{"/lib/scan.so"}), nullptr);
}

TEST(LoadRequest, OfAnUnknownKindIsRefused) {
    const Descriptor transfer(createTransfer());
    const std::string path = "file.vdb";
    sendRequest(transfer.fd(), {path, PhotometryTask{}});
    const auto unknown = static_cast<std::uint32_t>(std::variant_size_v<LoadTask>);
    ASSERT_TRUE(writeAll(transfer.fd(), &unknown, sizeof unknown,
                         sizeof(TransferHeader) + sizeof(std::uint64_t) + path.size()));
    EXPECT_EQ(test::errorOf(ErrorKind::input, [&] { receiveRequest(transfer.fd()); }),
              "what was read is incomplete: it asks for something unknown");
}

}  // namespace
}  // namespace scrim
