// SPDX-License-Identifier: Apache-2.0
#include "array_fields.h"

#include <scrim/base/half_float.h>
#include <scrim/base/parallel.h>
#include <scrim/volume/field_builder.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <type_traits>

#include <nanobind/ndarray.h>
#include <nanobind/stl/string.h>

namespace scrim::python {
namespace {

[[noreturn]] void fail(const std::string& name, const std::string& problem) {
    throw Error(ErrorKind::usage, "grid '" + name + "': " + problem);
}

struct Half {
    std::uint16_t bits;
};

std::uint8_t swappedBytes(std::uint8_t bits) {
    return bits;
}
std::uint16_t swappedBytes(std::uint16_t bits) {
    return __builtin_bswap16(bits);
}
std::uint32_t swappedBytes(std::uint32_t bits) {
    return __builtin_bswap32(bits);
}
std::uint64_t swappedBytes(std::uint64_t bits) {
    return __builtin_bswap64(bits);
}

template <std::size_t size>
using Bits = std::conditional_t<
    size == 1, std::uint8_t,
    std::conditional_t<size == 2, std::uint16_t, std::conditional_t<size == 4, std::uint32_t, std::uint64_t>>>;

template <typename Number, bool swapped>
float numberAt(const char* at) {
    Bits<sizeof(Number)> bits;
    std::memcpy(&bits, at, sizeof bits);
    if constexpr (swapped) bits = swappedBytes(bits);
    const auto number = std::bit_cast<Number>(bits);
    if constexpr (std::is_same_v<Number, Half>)
        return fromHalf(number.bits);
    else
        return static_cast<float>(number);
}

/// An array without its types.
struct Numbers {
    const char* first;
    Int3 size;
    std::array<std::int64_t, 3> steps;  ///< bytes from one number to the next along each axis
    std::array<int, 3> axes;            ///< those that are farthest apart in memory come first
};

/// Reads the numbers of a block. Returns false where they all are 0; with null `values` it only finds that out.
template <typename Number, bool swapped>
bool readBlock(const Numbers& numbers, const Int3& origin, float* values) {
    constexpr std::array<int, 3> kPlaces{blockOffset(1, 0, 0), blockOffset(0, 1, 0), blockOffset(0, 0, 1)};
    const Int3 end = glm::min(numbers.size - origin, Int3(kBlockEdge));
    const int a = numbers.axes[0], b = numbers.axes[1], c = numbers.axes[2];
    const auto stepOf = [&](int axis) { return numbers.steps[std::size_t(axis)]; };
    const char* const first = numbers.first + origin.x * stepOf(0) + origin.y * stepOf(1) + origin.z * stepOf(2);
    bool any = false;
    for (int i = 0; i < end[a]; ++i)
        for (int j = 0; j < end[b]; ++j) {
            const char* row = first + i * stepOf(a) + j * stepOf(b);
            const int place = i * kPlaces[std::size_t(a)] + j * kPlaces[std::size_t(b)];
            for (int k = 0; k < end[c]; ++k, row += stepOf(c)) {
                const float value = numberAt<Number, swapped>(row);
                any = any || value != 0;
                if (values != nullptr) values[place + k * kPlaces[std::size_t(c)]] = value;
            }
            if (any && values == nullptr) return true;
        }
    return any;
}

using ReadBlock = bool (*)(const Numbers&, const Int3&, float*);

/// The reader of that one of some types which has so many bytes; null: none has.
template <typename... Number>
ReadBlock readerOf(int bytes, bool swapped) {
    ReadBlock found = nullptr;
    const auto offer = [&](int size, ReadBlock plain, ReadBlock ofSwapped) {
        if (size == bytes) found = swapped ? ofSwapped : plain;
    };
    (offer(sizeof(Number), &readBlock<Number, false>, &readBlock<Number, true>), ...);
    return found;
}

/// Null for numbers that are not read here.
ReadBlock readerOf(char kind, int bytes, bool swapped) {
    switch (kind) {
        case 'f':
            return readerOf<Half, float, double>(bytes, swapped);
        case 'i':
            return readerOf<std::int8_t, std::int16_t, std::int32_t, std::int64_t>(bytes, swapped);
        case 'u':
        case 'b':
            return readerOf<std::uint8_t, std::uint16_t, std::uint32_t, std::uint64_t>(bytes, swapped);
        default:
            return nullptr;
    }
}

/// The origins of the blocks in which one of `parts` holds a number that is not 0, in the array's own order.
std::vector<Int3> occupiedBlocks(const std::vector<Numbers>& parts, ReadBlock read) {
    const Numbers& numbers = parts.front();
    const Int3 blocks = (numbers.size + (kBlockEdge - 1)) / kBlockEdge;
    const int a = numbers.axes[0], b = numbers.axes[1], c = numbers.axes[2];
    const auto rows = static_cast<std::size_t>(blocks[b]);
    std::vector<std::vector<Int3>> found(static_cast<std::size_t>(blocks[a]) * rows);
    parallelFor(found.size(), [&](std::size_t row) {
        Int3 origin(0);
        origin[a] = kBlockEdge * static_cast<int>(row / rows);
        origin[b] = kBlockEdge * static_cast<int>(row % rows);
        for (; origin[c] < numbers.size[c]; origin[c] += kBlockEdge)
            if (std::any_of(parts.begin(), parts.end(), [&](const Numbers& n) { return read(n, origin, nullptr); }))
                found[row].push_back(origin);
    });
    std::vector<Int3> origins;
    for (const std::vector<Int3>& row : found) origins.insert(origins.end(), row.begin(), row.end());
    return origins;
}

}  // namespace

NumberArray::NumberArray(nb::handle numbers, const std::string& name) {
    const nb::object numpy = nb::module_::import_("numpy");
    nb::object array = numpy.attr("asarray")(numbers);
    const nb::object dtype = array.attr("dtype");
    m_kind = nb::cast<std::string>(dtype.attr("kind")).at(0);
    if (std::string("fiub").find(m_kind) == std::string::npos)
        fail(name, "the array holds " + nb::cast<std::string>(nb::str(dtype)) + "; expected floats or whole numbers");
    m_bytes = nb::cast<int>(dtype.attr("itemsize"));
    m_swapped = !nb::cast<bool>(dtype.attr("isnative"));
    if (readerOf(m_kind, m_bytes, m_swapped) == nullptr) {  // long doubles
        array = array.attr("astype")("float32");
        m_kind = 'f';
        m_bytes = sizeof(float);
        m_swapped = false;
    }
    // The interface between the two counts strides in numbers, which the fields of packed records need not be.
    for (const nb::handle stride : array.attr("strides"))
        if (nb::cast<std::int64_t>(stride) % m_bytes != 0) {
            array = array.attr("copy")();
            break;
        }
    // Bytes have no type that could matter to the interface between the two.
    m_kept = array.attr("view")("u" + std::to_string(m_bytes));
    const auto bits = nb::cast<nb::ndarray<nb::ro, nb::device::cpu>>(m_kept);
    m_isColour = bits.ndim() == 4;
    bool fits = bits.ndim() == 3 || (m_isColour && bits.shape(3) == 3);
    std::string shape;
    for (std::size_t i = 0; i < bits.ndim(); ++i) {
        shape += (i > 0 ? ", " : "") + std::to_string(bits.shape(i));
        fits = fits && bits.shape(i) >= 1 && bits.shape(i) <= 1 << 20;
    }
    if (!fits)
        fail(name, "the array is of shape (" + shape + "); expected (nx, ny, nz), or (nx, ny, nz, 3) for colours");
    m_first = static_cast<const char*>(bits.data());
    m_size = Int3(bits.shape(0), bits.shape(1), bits.shape(2));
    for (std::size_t i = 0; i < bits.ndim(); ++i) m_strides.at(i) = bits.stride(i);
}

std::vector<SparseField> NumberArray::fields(const std::string& name, const Mat4& wsFromIs) const {
    const ReadBlock read = readerOf(m_kind, m_bytes, m_swapped);
    std::vector<Numbers> parts(m_isColour ? 3 : 1, Numbers{m_first, m_size, {}, {0, 1, 2}});
    for (std::size_t c = 0; c < parts.size(); ++c) {
        Numbers& part = parts[c];
        part.first += std::int64_t(c) * m_strides[3] * m_bytes;
        for (std::size_t axis = 0; axis < 3; ++axis) part.steps[axis] = m_strides[axis] * m_bytes;
        std::stable_sort(part.axes.begin(), part.axes.end(), [&](int a, int b) {
            return std::abs(m_strides[std::size_t(a)]) > std::abs(m_strides[std::size_t(b)]);
        });
    }
    const std::vector<Int3> origins = occupiedBlocks(parts, read);
    BlockMemory memory;
    std::deque<FieldFill> fills;
    for (std::size_t c = 0; c < parts.size(); ++c)
        fills.emplace_back(FieldPieces{m_isColour ? name + "." + "rgb"[c] : name, wsFromIs, origins, {}, {}}, memory);
    constexpr std::size_t kBlocksPerTask = 64;
    parallelFor((origins.size() + kBlocksPerTask - 1) / kBlocksPerTask, [&](std::size_t task) {
        const std::size_t end = std::min(origins.size(), (task + 1) * kBlocksPerTask);
        for (std::size_t i = task * kBlocksPerTask; i < end; ++i)
            for (std::size_t c = 0; c < parts.size(); ++c) {
                float* const values = fills[c].block(i);
                if (glm::any(glm::lessThan(m_size - origins[i], Int3(kBlockEdge))))
                    std::fill_n(values, kBlockVoxels, 0.0f);
                read(parts[c], origins[i], values);
                fills[c].filled(i);
            }
    });
    std::vector<SparseField> fields;
    for (FieldFill& fill : fills) fields.push_back(fill.finish());
    return fields;
}

}  // namespace scrim::python
