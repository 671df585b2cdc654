// SPDX-License-Identifier: Apache-2.0
// Where the values of a field's blocks are kept: memory of this process, or memory that another
// process will read, so that values need not be copied from one to the other.
#pragma once

#include <scrim/volume/sparse_field.h>

#include <cstddef>
#include <memory>

namespace scrim {

/// Memory of this process. Safe to use from several threads at once.
class BlockMemory {
  public:
    virtual ~BlockMemory() = default;

    /// Memory for the values of `count` blocks, which hold anything. Throws std::bad_alloc, or Error.
    virtual std::shared_ptr<float[]> take(std::size_t count) {
        return std::make_shared_for_overwrite<float[]>(count * kBlockVoxels);
    }
    /// Of `values`, all that take(count) returned, only the first `kept` blocks are needed from now
    /// on. The system gets back the memory of the others, which must not be read any more.
    virtual void shrink(float* values, std::size_t count, std::size_t kept);
};

}  // namespace scrim
