// SPDX-License-Identifier: Apache-2.0
#include "read_profile.h"

#include <scrim/base/error.h>
#include <scrim/guard/picture_transfer.h>
#include <scrim/volume/read_fields.h>

#include <utility>

namespace scrim::load {

ReadProfile::ReadProfile(int transfer, LoadRequest request, int input)
    : m_transfer(transfer), m_request(std::move(request)), m_input(input) {}

void ReadProfile::run() const {
    try {
        readWithErrors(m_request.path, [&] { sendPhotometry(m_transfer, readPhotometry(m_request.path, m_input)); });
    } catch (const Error& error) {
        sendError(m_transfer, error);
    }
}

}  // namespace scrim::load
