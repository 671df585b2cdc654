// SPDX-License-Identifier: Apache-2.0
// A volume source that reads a file, and before does what a file that takes over its reader might do; its parameter
// `act` chooses what.
#include <scrim/volume/scrim_source.h>

#include <csignal>
#include <cstdlib>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include <sys/socket.h>
#include <unistd.h>

namespace {

constexpr double kUnit[16] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1};

bool opens(const std::string& path) {
    return std::ifstream(path).good();
}

/// What to say it failed with; "": nothing.
std::string act(const std::string& what, const std::string& file) {
    const std::string folder = file.substr(0, file.rfind('/') + 1);
    if (what == "crash") std::raise(SIGSEGV);
    if (what == "abort") std::abort();
    if (what == "have had its time") std::raise(SIGXCPU);
    if (what == "make a socket") (void)::socket(AF_INET, SOCK_STREAM, 0);
    if (what == "write") std::ofstream(folder + "written").put('x');
    if (what == "fork") return ::fork() < 0 ? "no process" : "a process";
    if (what == "open another") return opens("/etc/passwd") || opens("/dev/null") ? "opened" : "nothing there";
    if (what == "need one") return opens(folder + "one") ? "" : "no file 'one'";
    if (what == "need two") return opens(folder + "one") && opens(folder + "two") ? "" : "not both";
    if (what == "loop")
        for (volatile int i = 0;; i = i + 1) {
        }
    if (what == "sleep")
        for (;;) std::this_thread::sleep_for(std::chrono::hours(1));
    if (what == "eat memory")
        for (std::vector<std::string> all;;) all.emplace_back(std::size_t{1} << 24, 'x');
    return "";
}

int generate(const scrim_host* host, const scrim_value* values) {
    const std::string file = values[0].text, what = values[1].text;
    try {
        if (what == "warn") host->warn(host, "careful");
        if (what == "say whether alone") {
            host->fail(host, host->alone != 0 ? "alone" : "not alone");
            return 1;
        }
        if (const std::string failure = act(what, file); !failure.empty()) {
            host->fail(host, failure.c_str());
            return 1;
        }
    } catch (const std::bad_alloc&) {
        host->fail(host, "not enough memory");
        return 1;
    }
    float block[512] = {};
    std::ifstream in(file, std::ios::binary);
    for (float& value : block)
        if (const int byte = in.get(); byte >= 0) value = static_cast<float>(byte);
    constexpr std::int32_t origin[3] = {0, 0, 0};
    const int grid = what == "nothing" ? 0 : host->add_grid(host, "density", kUnit);
    return what == "nothing" ? 0 : host->add_block(host, grid, origin, block);
}

constexpr scrim_parameter kParameters[] = {{"file", SCRIM_STRING, "", 0, 0, nullptr, "what to read"},
                                           {"act", SCRIM_STRING, "", 0, 0, nullptr, "what to do before"}};
constexpr scrim_source kSource = {
    SCRIM_SOURCE_ABI, sizeof(scrim_source), "readsfile", nullptr, kParameters, 2, sizeof(scrim_parameter), generate};

}  // namespace

extern "C" SCRIM_SOURCE_EXPORT const scrim_source* scrim_source_v1(void) {
    return &kSource;
}
