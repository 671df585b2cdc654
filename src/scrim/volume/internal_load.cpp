// SPDX-License-Identifier: Apache-2.0
// The child's side of a guarded load: `scrim internal-load --fd FD fields|info MEMORY THREADS PATH REQUEST...`.
#include <scrim/volume/guarded_load.h>

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/volume/field_transfer.h>
#include <scrim/volume/load_fields.h>
#include <scrim/volume/vdb_file.h>

#include <csignal>
#include <fstream>

#include <malloc.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <unistd.h>

namespace scrim {
namespace {

constexpr int kBadArguments = 2;

#if defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define SCRIM_HUGE_SHADOW_MEMORY 1
#endif
#endif
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define SCRIM_HUGE_SHADOW_MEMORY 1
#endif

/// Bytes of address space this process has now.
[[maybe_unused]] std::size_t addressSpace() {
    std::size_t pages = 0;
    std::ifstream("/proc/self/statm") >> pages;
    return pages * std::size_t(::sysconf(_SC_PAGESIZE));
}

/// No dump of a crash that was expected, no more memory than `memory` beyond that of the program itself, and
/// no life beyond that of the parent.
void limitSelf([[maybe_unused]] std::size_t memory) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    const rlimit none{0, 0};
    ::setrlimit(RLIMIT_CORE, &none);
#if !defined(SCRIM_HUGE_SHADOW_MEMORY)
    // Arenas, one a thread, would take address space that holds nothing.
    ::mallopt(M_ARENA_MAX, 2);
    const rlim_t most = addressSpace() + memory;
    const rlimit space{most, most};
    ::setrlimit(RLIMIT_AS, &space);
#endif
}

void sendAll(int fd, const std::string& what, const std::string& path, const std::vector<GridRequest>& requests) {
    if (what == "info") return sendInfo(fd, VdbFile::open(path).info());
    std::vector<TransferMessage> messages;
    const auto hear = [&](Severity severity, const std::string& text) { messages.push_back({severity, text}); };
    const std::vector<SparseField> fields = readFields(path, requests, hear);
    sendFields(fd, fields, messages);
}

/// Sends what `sendAll` throws in place of its result.
void sendAllOrError(int fd, const std::string& what, const std::string& path,
                    const std::vector<GridRequest>& requests) {
    try {
        readWithErrors(path, [&] { sendAll(fd, what, path, requests); });
    } catch (const Error& error) {
        sendError(fd, error);
    }
}

}  // namespace

int internalLoad(const std::vector<std::string>& arguments) {
    if (arguments.size() < 6 || arguments[0] != "--fd") return kBadArguments;
    const int fd = std::stoi(arguments[1]);
    const std::string& what = arguments[2];
    limitSelf(std::stoull(arguments[3]));
    std::vector<GridRequest> requests;
    for (std::size_t i = 6; i < arguments.size(); ++i) requests.push_back(gridRequestFrom(arguments[i]));
    TaskArena(std::stoi(arguments[4])).run([&] { sendAllOrError(fd, what, arguments[5], requests); });
    return 0;
}

}  // namespace scrim
