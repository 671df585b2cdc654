// SPDX-License-Identifier: Apache-2.0
// Times one way of reading a .vdb file; loading.py compares them.
//   scrim_loading convert FROM TO none|zip|blosc float|half   writes FROM again: its grids with that compression
//   scrim_loading openvdb FILE ROUNDS                         OpenVDB's own read of all grids, without delayed loading
//   scrim_loading scrim FILE ROUNDS                           Scrim's load of the density, in a confined child
// Both reads print one line: the shortest time of all rounds in seconds, and bytes in memory.
#include <scrim/base/error.h>
#include <scrim/guard/load_fields.h>

#include <chrono>
#include <cstdlib>
#include <functional>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include <fmt/format.h>
#include <openvdb/openvdb.h>

namespace {

constexpr int kUsage = 2;

using Clock = std::chrono::steady_clock;

/// Bytes in memory after a read, and the time it took. What was read is released after that time.
struct Round {
    std::size_t bytes = 0;
    double seconds = 0;
};

template <typename Read, typename BytesOf>
Round timed(const Read& read, const BytesOf& bytesOf) {
    const auto begin = Clock::now();
    const auto all = read();
    const double seconds = std::chrono::duration<double>(Clock::now() - begin).count();
    return {bytesOf(all), seconds};
}

void printBest(int rounds, const std::function<Round()>& round) {
    Round best{0, std::numeric_limits<double>::infinity()};
    for (int i = 0; i < rounds; ++i)
        if (const Round one = round(); one.seconds < best.seconds) best = one;
    fmt::print("{:.4f} {}\n", best.seconds, best.bytes);
}

openvdb::GridPtrVecPtr readAll(const std::string& path) {
    openvdb::io::File file(path);
    file.open(/*delayLoad=*/false);
    return file.getGrids();
}

std::uint32_t compressionOf(std::string_view codec) {
    return openvdb::io::COMPRESS_ACTIVE_MASK | (codec == "blosc" ? openvdb::io::COMPRESS_BLOSC
                                                : codec == "zip" ? openvdb::io::COMPRESS_ZIP
                                                                 : openvdb::io::COMPRESS_NONE);
}

void convert(const std::string& from, const std::string& to, std::string_view codec, bool half) {
    const openvdb::GridPtrVecPtr grids = readAll(from);
    for (const auto& grid : *grids) grid->setSaveFloatAsHalf(half);
    openvdb::io::File file(to);
    file.setCompression(compressionOf(codec));
    file.write(*grids);
}

Round readByOpenVdb(const std::string& path) {
    return timed([&] { return readAll(path); },
                 [](const openvdb::GridPtrVecPtr& grids) {
                     std::size_t bytes = 0;
                     for (const auto& grid : *grids) bytes += grid->memUsage();
                     return bytes;
                 });
}

Round readByScrim(const std::string& path) {
    scrim::LoadOptions options;
    options.volumes = scrim::VolumeLoading::guarded;
    return timed([&] { return scrim::loadFields(path, {{}}, options, {}); },
                 [](const std::vector<scrim::SparseField>& fields) {
                     std::size_t bytes = 0;
                     for (const scrim::SparseField& field : fields) bytes += field.bytes();
                     return bytes;
                 });
}

}  // namespace

int main(int argc, char** argv) {
    const std::vector<std::string> words(argv + 1, argv + argc);
    const std::string mode = words.empty() ? "" : words[0];
    try {
        openvdb::initialize();
        if (mode == "convert" && words.size() == 5)
            convert(words[1], words[2], words[3], words[4] == "half");
        else if (mode == "openvdb" && words.size() == 3)
            printBest(std::atoi(words[2].c_str()), [&] { return readByOpenVdb(words[1]); });
        else if (mode == "scrim" && words.size() == 3)
            printBest(std::atoi(words[2].c_str()), [&] { return readByScrim(words[1]); });
        else {
            fmt::print(stderr, "scrim_loading: see the start of tests/tools/bench/loading.cpp\n");
            return kUsage;
        }
    } catch (const std::exception& error) {
        fmt::print(stderr, "scrim_loading: {}\n", error.what());
        return 1;
    }
    return 0;
}
