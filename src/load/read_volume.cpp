// SPDX-License-Identifier: Apache-2.0
#include "read_volume.h"

#include "vdb_library.h"

#include <scrim/base/error.h>
#include <scrim/base/parallel.h>
#include <scrim/guard/field_transfer.h>
#include <scrim/guard/load_protocol.h>
#include <scrim/volume/direct_fields.h>
#include <scrim/volume/read_fields.h>
#include <scrim/volume/vdb_file.h>

#include <tbb/global_control.h>

#include <optional>
#include <thread>
#include <utility>

#include <malloc.h>
#include <unistd.h>

namespace scrim::load {
namespace {

void sendAll(int transfer, const LoadTask& task, const VdbBytes& bytes) {
    const auto* const wanted = std::get_if<FieldsTask>(&task);
    if (wanted == nullptr) return sendInfo(transfer, VdbFile::open(bytes).info());
    std::vector<TransferMessage> messages;
    const auto hear = [&](Severity severity, const std::string& text) { messages.push_back({severity, text}); };
    TransferBlocks blocks(transfer);
    if (triedOpenVdb()) return sendFields(transfer, readFields(bytes, wanted->grids, hear, blocks), messages, &blocks);
    const auto fields = readWithoutOpenVdb(bytes, wanted->grids, hear, blocks);
    if (!fields) ::_exit(kNeedsOpenVdb);
    sendFields(transfer, *fields, messages, &blocks);
}

std::optional<tbb::global_control>& oneThread() {
    static std::optional<tbb::global_control> limit;
    return limit;
}

}  // namespace

void prepareToRead() {
    oneThread().emplace(tbb::global_control::max_allowed_parallelism, 1);
    // oneTBB looks for libraries of its own when the first loop runs. A single task would not start a loop.
    parallelFor(2, [](std::size_t) {});
    // With its first thread the C library sets up signals, which a confined child may not.
    std::thread([] {}).join();
    // Memory grows in large steps and is not returned to the system, since a child ends soon.
    constexpr int kStep = 16 << 20;
    ::mallopt(M_TOP_PAD, kStep);
    ::mallopt(M_TRIM_THRESHOLD, kStep);
    ::mallopt(M_ARENA_MAX, 1);
}

void allowThreads() {
    oneThread().reset();
}

void allowThreadsWithArenas() {
    allowThreads();
    constexpr int kMostArenas = 8;
    ::mallopt(M_ARENA_MAX, kMostArenas);
}

ReadVolume::ReadVolume(int transfer, LoadRequest request, int input, int threads)
    : m_transfer(transfer),
      m_threads(threads),
      m_request(std::move(request)),
      m_bytes(std::make_unique<VdbBytes>(m_request.path, input)) {}

/// An exception is sent in place of the result.
void ReadVolume::run() const {
    allowThreads();
    try {
        readWithErrors(m_request.path,
                       [&] { TaskArena(m_threads).run([&] { sendAll(m_transfer, m_request.task, *m_bytes); }); });
    } catch (const Error& error) {
        sendError(m_transfer, error);
    }
}

}  // namespace scrim::load
