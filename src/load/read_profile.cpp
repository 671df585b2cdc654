// SPDX-License-Identifier: Apache-2.0
#include "read_profile.h"

#include <scrim/base/error.h>
#include <scrim/guard/field_transfer.h>
#include <scrim/guard/picture_transfer.h>
#include <scrim/volume/read_fields.h>

#include <utility>

namespace scrim::load {

ReadProfile::ReadProfile(int transfer, std::string path, int input)
    : m_transfer(transfer), m_path(std::move(path)), m_input(input) {}

void ReadProfile::run() const {
    try {
        readWithErrors(m_path, [&] { sendPhotometry(m_transfer, readPhotometry(m_path, m_input)); });
    } catch (const Error& error) {
        sendError(m_transfer, error);
    }
}

}  // namespace scrim::load
