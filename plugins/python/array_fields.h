// SPDX-License-Identifier: Apache-2.0
// Grids from NumPy arrays. Each number is read where it lies and written to its block: numbers of other types, in other
// orders of bytes or axes, are not made floats in an array of their own first.
#pragma once

#include "bindings.h"

#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace scrim::python {

/// Numbers of shape (nx, ny, nz), or (nx, ny, nz, 3) for a colour.
class NumberArray {
  public:
    /// Takes an array, or what NumPy makes an array of, and keeps it. `name` is that of the grid, for messages. Needs
    /// the interpreter's lock. Throws Error(usage) where it holds no real numbers or has another shape.
    NumberArray(nb::handle numbers, const std::string& name);

    bool isColour() const { return m_isColour; }
    /// The field of the numbers, called `name`; of a colour one for each part, called "name.r", "name.g" and "name.b".
    /// Uses several threads, and not the interpreter.
    std::vector<SparseField> fields(const std::string& name, const Mat4& wsFromIs) const;

  private:
    nb::object m_kept;  ///< the array
    const char* m_first = nullptr;
    Int3 m_size{0};
    std::array<std::int64_t, 4> m_strides{};  ///< numbers from one element to the next
    bool m_isColour = false;
    char m_kind = 'f';  ///< NumPy's: 'f', 'i' or 'u'
    int m_bytes = 4;    ///< of a number
    bool m_swapped = false;
};

}  // namespace scrim::python
