// SPDX-License-Identifier: Apache-2.0
#include "edit_volume.h"

#include "read_volume.h"

#include <scrim/base/parallel.h>
#include <scrim/base/system_error.h>
#include <scrim/volume/read_fields.h>
#include <scrim/volume/vdb_module.h>

#include <utility>

namespace scrim::load {

EditVolume::EditVolume(int transfer, LoadRequest request, int input, int threads)
    : m_transfer(transfer), m_threads(threads), m_request(std::move(request)), m_edit(gridEditFrom(m_request.edit)) {
    allowThreads();
    try {
        if (!m_edit.programs.empty()) m_ax = loadAxModule(m_request.source, m_edit.programs.front().where);
    } catch (const Error& error) {
        m_problem = error;
    }
    if (m_request.what == kMadeFields)
        m_made = receiveFields(input).fields;
    else
        m_bytes = std::make_unique<VdbBytes>(m_request.path, input);
}

std::vector<SparseField> EditVolume::fields(const MessageSink& messages) const {
    if (m_problem) throw *m_problem;
    const auto editor = vdbModule().editor(m_edit, m_ax);
    if (const int problem = forbidCode(); problem != 0)
        throw Error(ErrorKind::render, "cannot forbid code in memory: " + systemErrorText(problem));
    std::vector<SparseField> made;
    TaskArena(m_threads).run([&] {
        made = m_bytes ? readFields(*m_bytes, m_request.grids, *editor, messages)
                       : editFields(m_made, m_request.path, m_request.grids, *editor, messages);
    });
    return made;
}

void EditVolume::run() const {
    try {
        readWithErrors(m_request.path, [&] {
            std::vector<TransferMessage> messages;
            const auto hear = [&](Severity severity, const std::string& text) { messages.push_back({severity, text}); };
            const std::vector<SparseField> made = fields(hear);
            sendFields(m_transfer, made, messages);
        });
    } catch (const Error& error) {
        sendError(m_transfer, error);
    }
}

}  // namespace scrim::load
