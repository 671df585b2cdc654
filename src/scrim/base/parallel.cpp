// SPDX-License-Identifier: Apache-2.0
#include <scrim/base/parallel.h>

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <optional>

namespace scrim {

void parallelFor(std::size_t count, const std::function<void(std::size_t)>& task) {
    if (count == 1) return task(0);
    tbb::parallel_for(
        tbb::blocked_range<std::size_t>(0, count, 1),
        [&](const tbb::blocked_range<std::size_t>& range) {
            for (std::size_t i = range.begin(); i != range.end(); ++i) task(i);
        },
        tbb::simple_partitioner());
}

int threadCount() {
    return static_cast<int>(tbb::global_control::active_value(tbb::global_control::max_allowed_parallelism));
}

struct ThreadLimit::Control {
    std::optional<tbb::global_control> control;
};

ThreadLimit::ThreadLimit(int threads) : m_control(std::make_unique<Control>()) {
    if (threads > 0)
        m_control->control.emplace(tbb::global_control::max_allowed_parallelism,
                                   static_cast<std::size_t>(threads));
}

ThreadLimit::~ThreadLimit() = default;

}  // namespace scrim
