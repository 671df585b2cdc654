// SPDX-License-Identifier: Apache-2.0
// A volume source that calls the host as it must not, or throws; its parameter `act` chooses how.
#include <scrim/volume/scrim_source.h>

#include <limits>
#include <stdexcept>
#include <string>
#include <thread>

namespace {

constexpr double kUnit[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

int generate(const scrim_host* host, const scrim_value* values) {
    const std::string act = values[0].text;
    constexpr std::int32_t origin[3] = {0, 0, 0};
    constexpr float block[512] = {1};
    if (act == "throws") throw std::runtime_error("a surprise");
    if (act == "throws a number") throw 7;
    if (act == "no grid") return host->add_block(host, 0, origin, block);
    if (act == "nameless grid") return host->add_grid(host, "", kUnit);
    if (act == "null name") return host->add_grid(host, nullptr, kUnit);
    if (act == "null transform") return host->add_grid(host, "density", nullptr);
    double transform[16];
    for (int i = 0; i < 16; ++i) transform[i] = kUnit[i];
    if (act == "nan transform") transform[3] = std::numeric_limits<double>::quiet_NaN();
    if (act == "projective") transform[12] = 1;
    const int grid = host->add_grid(host, "density", transform);
    if (grid < 0) return grid;
    if (act == "negative grid") return host->add_block(host, -1, origin, block);
    if (act == "null origin") return host->add_block(host, grid, nullptr, block);
    if (act == "null values") return host->add_block(host, grid, origin, nullptr);
    if (act == "null tile") return host->add_tile(host, grid, nullptr, 8, 1);
    if (act == "tile of nothing") return host->add_tile(host, grid, origin, 0, 1);
    if (act == "tile of less") return host->add_tile(host, grid, origin, -8, 1);
    if (act == "tile off grid") {
        constexpr std::int32_t odd[3] = {8, 0, 0};
        return host->add_tile(host, grid, odd, 16, 1);
    }
    if (act == "tiles overlap") {
        host->add_tile(host, grid, origin, 8, 1);
        return host->add_tile(host, grid, origin, 16, 1);
    }
    if (act == "goes on") {  // with errors it was told of, and says all is well
        host->add_block(host, 9, origin, block);
        host->add_block(host, grid, origin, block);
        return 0;
    }
    if (act == "fails late") {  // after it has said all is well
        host->fail(host, "on second thoughts");
        return 0;
    }
    if (act == "null texts") {
        host->warn(host, nullptr);
        host->fail(host, nullptr);
        return 4;
    }
    if (act == "long text") {
        host->fail(host, std::string(1'000'000, 'x').c_str());
        return 1;
    }
    if (act == "other thread") {
        std::thread([&] { host->add_block(host, grid, origin, block); }).join();
        return 0;
    }
    return host->add_block(host, grid, origin, block);
}

constexpr scrim_parameter kParameters[] = {{"act", SCRIM_STRING, "well", 0, 0, nullptr, "what to do"}};
constexpr scrim_source kSource = {
    SCRIM_SOURCE_ABI, sizeof(scrim_source), "badcalls", nullptr, kParameters, 1, sizeof(scrim_parameter), generate};

}  // namespace

extern "C" SCRIM_SOURCE_EXPORT const scrim_source* scrim_source_v1(void) {
    return &kSource;
}
