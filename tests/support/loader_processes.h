// SPDX-License-Identifier: Apache-2.0
// Processes of the program scrim-load, as /proc shows them. A test looks at those that it knows by their parent or by
// their group: whatever else runs on the machine may have some, too.
#pragma once

#include <chrono>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

namespace scrim::test {

struct LoaderProcess {
    int id = -1, parent = -1, group = -1;
};

/// All that run. What has ended and was not waited for yet does not run.
inline std::vector<LoaderProcess> loaderProcesses() {
    std::vector<LoaderProcess> found;
    for (const auto& entry : std::filesystem::directory_iterator("/proc")) {
        std::ifstream in(entry.path() / "stat");
        LoaderProcess process;
        std::string name, state;
        if (in >> process.id >> name >> state >> process.parent >> process.group && name == "(scrim-load)" &&
            state != "Z")
            found.push_back(process);
    }
    return found;
}

/// True if a process has mapped a file whose name contains `library`.
inline bool hasMapped(int process, const std::string& library) {
    std::ifstream maps("/proc/" + std::to_string(process) + "/maps");
    for (std::string line; std::getline(maps, line);)
        if (line.find(library) != std::string::npos) return true;
    return false;
}

/// Waits half a minute at most until `condition` holds; false where it did not.
template <typename Condition>
bool comesTrue(const Condition& condition) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(30);
    while (!condition()) {
        if (std::chrono::steady_clock::now() > end) return false;
        std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    return true;
}

}  // namespace scrim::test
