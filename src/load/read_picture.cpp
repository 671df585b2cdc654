// SPDX-License-Identifier: Apache-2.0
#include "read_picture.h"

#include "answered_calls.h"
#include "fork.h"

#include <scrim/base/error.h>
#include <scrim/guard/field_transfer.h>
#include <scrim/guard/picture_transfer.h>
#include <scrim/volume/read_fields.h>

#include <cstdio>
#include <utility>

#include <dlfcn.h>

namespace scrim::load {

const PictureModule* loadPictureModule(const std::string& path) {
    void* module = ::dlopen(path.c_str(), RTLD_LAZY | RTLD_LOCAL);
    void* function = module == nullptr ? nullptr : ::dlsym(module, SCRIM_PICTURE_MODULE_SYMBOL);
    if (function == nullptr) {
        const char* reason = ::dlerror();
        std::fprintf(stderr, "scrim-load: cannot load '%s': %s\n", path.c_str(), reason == nullptr ? "" : reason);
        return nullptr;
    }
    const PictureModule* pictures = reinterpret_cast<PictureModuleFunction>(function)();
    pictures->prepare();
    // OpenImageIO's threads end. Those of log4cplus, which it may bring along with OpenVDB, stay asleep.
    waitForThreadsToSleep();
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
