// SPDX-License-Identifier: Apache-2.0
#include "read_source.h"

#include "answered_calls.h"
#include "read_volume.h"

#include <scrim/base/parallel.h>
#include <scrim/guard/field_transfer.h>
#include <scrim/volume/read_fields.h>

#include <string>
#include <utility>
#include <vector>

namespace scrim::load {

ReadSource::ReadSource(int transfer, std::string path, SourceTask task, int input, int beside, int threads)
    : m_transfer(transfer), m_threads(threads), m_path(std::move(path)), m_task(std::move(task)) {
    try {
        m_source.emplace(m_task.source);
    } catch (const Error& error) {
        m_problem = error;
    }
    if (!hasFilter()) return;
    AnsweredCalls::install(m_path, input);
    if (!m_task.beside.empty()) AnsweredCalls::add(m_task.beside, beside);
}

void ReadSource::send() const {
    if (m_problem) throw *m_problem;
    std::vector<TransferMessage> messages;
    const auto hear = [&](Severity severity, const std::string& text) { messages.push_back({severity, text}); };
    TaskArena(m_threads).run([&] {
        TransferBlocks blocks(m_transfer);
        const std::vector<SparseField> fields = m_source->run(m_task.parameters, hear, {}, blocks, true);
        sendFields(m_transfer, fields, messages, &blocks);
    });
}

void ReadSource::run() const {
    allowThreadsWithArenas();
    try {
        readWithErrors("source '" + sourceNameOf(m_task.source) + "': " + m_path, [&] { send(); });
    } catch (const Error& error) {
        const std::string lacked = AnsweredCalls::lacked();
        if (lacked.empty())
            sendError(m_transfer, error);
        else
            sendError(m_transfer, BesideError(error, lacked));
    }
}

}  // namespace scrim::load
