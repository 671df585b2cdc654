// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/source_host.h>

#include <scrim/base/error.h>

#include <new>

#include <fmt/format.h>

namespace scrim {

SourceHost::SourceHost(std::string where, MessageSink messages, ProgressSink progressSink, bool alone)
    : m_where(std::move(where)), m_messages(std::move(messages)), m_progress(std::move(progressSink)) {
    m_abi.abi_version = SCRIM_SOURCE_ABI;
    m_abi.struct_size = sizeof(scrim_host);
    m_abi.context = this;
    m_abi.add_grid = &SourceHost::addGrid;
    m_abi.add_block = &SourceHost::addBlock;
    m_abi.add_tile = &SourceHost::addTile;
    m_abi.warn = &SourceHost::warn;
    m_abi.progress = &SourceHost::progress;
    m_abi.fail = &SourceHost::fail;
    m_abi.alone = alone;
}

template <typename Task>
int SourceHost::guarded(const Task& task) noexcept {
    // Recording this error from another thread is a race. It is the lesser evil in an error path that ends the run:
    // calling sinks from a thread that their owner does not expect would be worse.
    try {
        if (std::this_thread::get_id() != m_thread) refuse("it called the host from another thread");
        if (m_problem) return -1;
        return task();
    } catch (...) {
        if (!m_problem) m_problem = std::current_exception();
        return -1;
    }
}

void SourceHost::refuse(const std::string& reason) const {
    throw Error(ErrorKind::input, shortened(m_where + ": " + reason));
}

FieldBuilder& SourceHost::grid(int number) {
    if (number < 0 || std::size_t(number) >= m_grids.size())
        refuse(fmt::format("it used grid number {}, but has added {} grids", number, m_grids.size()));
    return m_grids[number];
}

int SourceHost::addGrid(const scrim_host* host, const char* name, const double worldFromIndex[16]) noexcept {
    SourceHost& h = self(host);
    return h.guarded([&] {
        if (name == nullptr || *name == '\0') h.refuse("it added a grid without a name");
        if (worldFromIndex == nullptr) h.refuse("it added a grid without a transform");
        for (const FieldBuilder& other : h.m_grids)
            if (other.name() == name) h.refuse("it added two grids called '" + shortened(name, 80) + "'");
        Mat4 m;
        for (int row = 0; row < 4; ++row)
            for (int column = 0; column < 4; ++column) m[column][row] = worldFromIndex[row * 4 + column];
        h.m_grids.emplace_back(name, m);
        return static_cast<int>(h.m_grids.size()) - 1;
    });
}

int SourceHost::addBlock(const scrim_host* host, int grid, const std::int32_t origin[3],
                         const float values[512]) noexcept {
    SourceHost& h = self(host);
    return h.guarded([&] {
        FieldBuilder& builder = h.grid(grid);
        if (origin == nullptr || values == nullptr) h.refuse("it added a block without origin or values");
        builder.addBlock({origin[0], origin[1], origin[2]}, values);
        return 0;
    });
}

int SourceHost::addTile(const scrim_host* host, int grid, const std::int32_t origin[3], std::int32_t edge,
                        float value) noexcept {
    SourceHost& h = self(host);
    return h.guarded([&] {
        FieldBuilder& builder = h.grid(grid);
        if (origin == nullptr) h.refuse("it added a tile without an origin");
        builder.addTile({{origin[0], origin[1], origin[2]}, edge, value});
        return 0;
    });
}

void SourceHost::warn(const scrim_host* host, const char* text) noexcept {
    SourceHost& h = self(host);
    h.guarded([&] {
        notify(h.m_messages, Severity::warning, h.m_where + ": " + shortened(text != nullptr ? text : ""));
        return 0;
    });
}

int SourceHost::progress(const scrim_host* host, double done) noexcept {
    SourceHost& h = self(host);
    return h.guarded([&] {
        const double part = done >= 0 && done <= 1 ? done : 1;  // NaN also becomes 1
        if (h.m_progress && !h.m_progress(part)) throw Error(ErrorKind::interrupted, h.m_where + ": interrupted");
        return 0;
    });
}

void SourceHost::fail(const scrim_host* host, const char* text) noexcept {
    SourceHost& h = self(host);
    h.guarded([&] {
        if (h.m_failure.empty() && text != nullptr) h.m_failure = shortened(text);
        return 0;
    });
}

std::vector<SparseField> SourceHost::finish(int code, BlockMemory& memory) {
    try {
        if (m_problem) std::rethrow_exception(m_problem);
    } catch (const std::bad_alloc&) {
        throw Error(ErrorKind::memory, m_where + ": not enough memory for its grids");
    }
    if (code != 0 || !m_failure.empty())
        refuse(m_failure.empty() ? fmt::format("it failed with code {} and gave no reason", code) : m_failure);
    if (m_grids.empty()) refuse("it made no grid");
    std::vector<SparseField> fields;
    for (FieldBuilder& builder : m_grids) {
        try {
            fields.push_back(builder.finish(memory));
        } catch (const Error& error) {
            throw Error(error.kind(), m_where + ": " + error.what());
        }
        reportCleaning(fields.back(), m_where, m_messages);
    }
    return fields;
}

}  // namespace scrim
