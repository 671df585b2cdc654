// SPDX-License-Identifier: Apache-2.0
#include "edit_volume.h"

#include "read_volume.h"

#include <scrim/base/parallel.h>
#include <scrim/base/system_error.h>
#include <scrim/guard/field_transfer.h>
#include <scrim/volume/read_fields.h>
#include <scrim/volume/vdb_file.h>
#include <scrim/volume/vdb_module.h>

#include <utility>

namespace scrim::load {

EditVolume::EditVolume(int transfer, LoadRequest request, const std::vector<int>& inputs, int threads)
    : m_transfer(transfer), m_threads(threads), m_request(std::move(request)), m_first(*editOf(m_request.task)) {
    allowThreadsWithArenas();
    try {
        if (!m_first.ax.empty()) m_ax = loadAxModule(m_first.ax, m_first.edit.programs.front().where);
    } catch (const Error& error) {
        m_problem = error;
    }
    if (std::holds_alternative<MadeFieldsTask>(m_request.task)) {
        m_made = receiveFields(inputs.front()).fields;
        return;
    }
    for (std::size_t i = 0; i < inputs.size(); ++i)
        m_files.push_back(std::make_unique<VdbBytes>(i == 0 ? m_request.path : m_first.edit.files.at(i), inputs[i]));
}

void EditVolume::send() const {
    if (m_problem) throw *m_problem;
    const auto editor = vdbModule().editor(m_first.edit, m_ax);
    if (const int problem = forbidCode(); problem != 0)
        throw Error(ErrorKind::render, "cannot forbid code in memory: " + systemErrorText(problem));
    std::vector<TransferMessage> messages;
    const auto hear = [&](Severity severity, const std::string& text) { messages.push_back({severity, text}); };
    TaskArena(m_threads).run([&] {
        if (const auto* const made = std::get_if<MadeFieldsTask>(&m_request.task))
            return sendFields(m_transfer, editFields(m_made, m_request.path, made->grids, *editor, hear), messages);
        if (const auto* const wanted = std::get_if<FieldsTask>(&m_request.task)) {
            if (m_first.edit.editsGrids())
                return sendFields(m_transfer, readFields(m_files, wanted->grids, *editor, hear), messages);
            TransferBlocks blocks(m_transfer);
            const auto fields = readFields(*m_files.front(), wanted->grids, hear, blocks, m_first.edit.points);
            return sendFields(m_transfer, fields, messages, &blocks);
        }
        const VdbFile all = VdbFile::open(m_files, *editor, hear);
        if (std::holds_alternative<EditedFileTask>(m_request.task)) return sendFile(m_transfer, all.asFile(), messages);
        VdbFileInfo info = all.info();
        for (const TransferMessage& message : messages) info.metadata.emplace_back("edit", message.text);
        sendInfo(m_transfer, info);
    });
}

void EditVolume::run() const {
    try {
        readWithErrors(m_request.path, [&] { send(); });
    } catch (const Error& error) {
        sendError(m_transfer, error);
    }
}

}  // namespace scrim::load
