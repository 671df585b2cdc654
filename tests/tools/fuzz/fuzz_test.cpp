// SPDX-License-Identifier: Apache-2.0
// The fuzz targets as plain tests: all files of their corpora, and some mutations of them, always the same.
// SCRIM_FUZZ_RUNS=N asks for N mutations a target. An input that fails, or crashes the program, is left in the folder
// scrim_fuzz_failed, where temporary files go.
#include "support/vdb_make.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>
#include <cstdlib>
#include <filesystem>
#include <ostream>
#include <random>
#include <string>
#include <vector>

extern "C" {
int scrim_fuzz_scene_text(const std::uint8_t*, std::size_t);
int scrim_fuzz_vdb_layout(const std::uint8_t*, std::size_t);
int scrim_fuzz_transfer(const std::uint8_t*, std::size_t);
int scrim_fuzz_random_scene(const std::uint8_t*, std::size_t);
}

namespace scrim::test {
namespace {

struct Target {
    const char* name;
    int (*run)(const std::uint8_t*, std::size_t);
    int mutations;
};

std::ostream& operator<<(std::ostream& out, const Target& target) {
    return out << target.name;
}

std::vector<std::string> corpusOf(const Target& target) {
    std::vector<std::string> paths, inputs;
    for (const auto& entry : std::filesystem::directory_iterator(std::string(SCRIM_FUZZ_CORPUS) + "/" + target.name))
        paths.push_back(entry.path().string());
    std::sort(paths.begin(), paths.end());
    for (const std::string& path : paths) inputs.push_back(readBytes(path));
    return inputs;
}

/// One to four changes: bytes replaced, left out, doubled, or taken from another input.
std::string mutated(std::string input, const std::vector<std::string>& corpus, std::mt19937& random) {
    const auto below = [&](std::size_t n) { return n == 0 ? 0 : random() % n; };
    for (auto changes = 1 + below(4); changes > 0; --changes) {
        const std::size_t at = below(input.size() + 1), length = 1 + below(16);
        const std::string& other = corpus[below(corpus.size())];
        switch (below(5)) {
            case 0:
                input.insert(at, 1, static_cast<char>(random()));
                break;
            case 1:
                input.erase(at, length);
                break;
            case 2:
                input.insert(at, input.substr(at, length));
                break;
            case 3:
                input.replace(at, length, other.substr(below(other.size()), length));
                break;
            default:
                if (at < input.size()) input[at] = static_cast<char>(random());
        }
    }
    return input;
}

class FuzzTarget : public ::testing::TestWithParam<Target> {
  protected:
    /// Leaves the input behind where it fails.
    void run(const std::string& input, const std::string& what) const {
        const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "scrim_fuzz_failed";
        std::filesystem::create_directories(folder);
        const std::string file = (folder / (std::string(GetParam().name) + ".input")).string();
        writeBytes(file, input);
        try {
            GetParam().run(reinterpret_cast<const std::uint8_t*>(input.data()), input.size());
        } catch (const std::exception& error) {
            FAIL() << what << " (" << file << "): " << error.what();
        }
        std::filesystem::remove(file);
    }
};

TEST_P(FuzzTarget, StandsItsCorpus) {
    const std::vector<std::string> corpus = corpusOf(GetParam());
    ASSERT_FALSE(corpus.empty());
    for (std::size_t i = 0; i < corpus.size() && !HasFatalFailure(); ++i) run(corpus[i], "file " + std::to_string(i));
}

TEST_P(FuzzTarget, StandsMutationsOfIt) {
    const std::vector<std::string> corpus = corpusOf(GetParam());
    const char* runs = std::getenv("SCRIM_FUZZ_RUNS");
    const int count = runs == nullptr ? GetParam().mutations : std::atoi(runs);
    std::mt19937 random(1);
    for (int i = 0; i < count && !HasFatalFailure(); ++i)
        run(mutated(corpus[random() % corpus.size()], corpus, random), "mutation " + std::to_string(i));
}

INSTANTIATE_TEST_SUITE_P(All, FuzzTarget,
                         ::testing::Values(Target{"scene_text", scrim_fuzz_scene_text, 500},
                                           Target{"vdb_layout", scrim_fuzz_vdb_layout, 5000},
                                           Target{"transfer", scrim_fuzz_transfer, 1000},
                                           Target{"random_scene", scrim_fuzz_random_scene, 60}),
                         [](const auto& target) { return std::string(target.param.name); });

}  // namespace
}  // namespace scrim::test
