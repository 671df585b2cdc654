// SPDX-License-Identifier: Apache-2.0
#include "read_picture.h"

#include "answered_calls.h"

#include <scrim/base/error.h>
#include <scrim/guard/field_transfer.h>
#include <scrim/guard/picture_transfer.h>
#include <scrim/volume/read_fields.h>

#include <chrono>
#include <cstddef>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <thread>
#include <utility>

#include <dlfcn.h>

namespace scrim::load {
namespace {

std::ptrdiff_t threadCount() {
    return std::distance(std::filesystem::directory_iterator("/proc/self/task"), {});
}

/// A thread that is about to end may hold a lock, which a child forked at that moment would find locked forever.
void waitForThreadsToEnd(std::ptrdiff_t count) {
    constexpr std::chrono::seconds kPatience{2};
    const auto start = std::chrono::steady_clock::now();
    while (threadCount() > count && std::chrono::steady_clock::now() - start < kPatience)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

}  // namespace

const PictureModule* loadPictureModule(const std::string& path) {
    const std::ptrdiff_t threads = threadCount();
    void* module = ::dlopen(path.c_str(), RTLD_LAZY | RTLD_LOCAL);
    void* function = module == nullptr ? nullptr : ::dlsym(module, SCRIM_PICTURE_MODULE_SYMBOL);
    if (function == nullptr) {
        const char* reason = ::dlerror();
        std::fprintf(stderr, "scrim-load: cannot load '%s': %s\n", path.c_str(), reason == nullptr ? "" : reason);
        return nullptr;
    }
    const PictureModule* pictures = reinterpret_cast<PictureModuleFunction>(function)();
    pictures->prepare();
    waitForThreadsToEnd(threads);  // OpenImageIO's threads
    return pictures;
}

ReadPicture::ReadPicture(const PictureModule& module, int transfer, LoadRequest request, int input)
    : m_module(module), m_transfer(transfer), m_request(std::move(request)) {
    if (hasFilter()) AnsweredCalls::install(m_request.path, input);
}

void ReadPicture::run() const {
    try {
        readWithErrors(m_request.path, [&] {
            const std::string& path = m_request.path;
            if (std::holds_alternative<HeaderTask>(m_request.task))
                sendPictureHeader(m_transfer, m_module.header(path));
            else if (const auto* const depth = std::get_if<DepthTask>(&m_request.task))
                sendPictureDepth(m_transfer, m_module.depth(path, depth->channel));
            else
                sendPicture(m_transfer, m_module.read(path));
        });
    } catch (const Error& error) {
        sendError(m_transfer, error);
    }
}

}  // namespace scrim::load
