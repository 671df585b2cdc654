// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/nano_grid.h>

#include <scrim/base/error.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <memory>
#include <type_traits>

#include <blosc.h>
#include <fmt/format.h>
#include <nanovdb/NanoVDB.h>
#include <zlib.h>

namespace scrim {

namespace {

constexpr std::size_t kAlignment = 32;                         // of all nodes
constexpr std::uint64_t kBloscChunk = std::uint64_t{1} << 30;  // nanovdb/util/IO.h, MAX_SIZE
constexpr int kVoxels = 512;                                   // of a leaf

struct FreeAligned {
    void operator()(char* bytes) const { ::operator delete[](bytes, std::align_val_t(kAlignment)); }
};

/// The bytes of a grid as they lie in memory.
struct NanoBytes {
    std::unique_ptr<char[], FreeAligned> bytes;
    std::uint64_t size = 0;
};

[[noreturn]] void damaged(const VdbBytes& file, const VdbLayout::Grid& layout, const std::string& reason) {
    throw Error(ErrorKind::input, fmt::format("{}: truncated or damaged: grid '{}': {}", file.path(),
                                              shortened(layout.name, 80), reason));
}

/// Unpacks the grid's bytes.
NanoBytes unpacked(const VdbBytes& file, const VdbLayout::Grid& layout) {
    const auto refuse = [&](const std::string& reason) { damaged(file, layout, reason); };
    const VdbLayout::Nano& nano = *layout.nano;
    NanoBytes out;
    out.size = nano.bytes;
    out.bytes.reset(static_cast<char*>(::operator new[](out.size, std::align_val_t(kAlignment))));
    if (nano.codec == 0) {
        file.copy(layout.begin, out.size, out.bytes.get());
        return out;
    }
    std::uint64_t at = layout.begin, done = 0;
    do {
        std::uint64_t packed = 0;
        if (layout.end - at < sizeof packed) refuse("its compressed data ends too early");
        file.copy(at, sizeof packed, reinterpret_cast<char*>(&packed));
        at += sizeof packed;
        if (packed > layout.end - at) refuse("its compressed data ends too early");
        std::vector<char> from(packed);
        file.copy(at, packed, from.data());
        at += packed;
        if (nano.codec == 1) {
            uLongf size = out.size;
            const int error = ::uncompress(reinterpret_cast<Bytef*>(out.bytes.get()), &size,
                                           reinterpret_cast<const Bytef*>(from.data()), packed);
            if (error != Z_OK || size != out.size) refuse("its compressed data is damaged");
            done = out.size;
        } else {
            const std::uint64_t chunk = std::min(out.size - done, kBloscChunk);
            std::size_t size = 0;
            if (::blosc_cbuffer_validate(from.data(), packed, &size) != 0 || size != chunk ||
                ::blosc_decompress_ctx(from.data(), out.bytes.get() + done, chunk, 1) != static_cast<int>(chunk))
                refuse("its compressed data is damaged");
            done += chunk;
        }
    } while (done < out.size);
    return out;
}

/// The numbers of a value: a scalar, or the first three of a vector.
template <typename Value>
auto toOpenVdb(const Value& value) {
    if constexpr (std::is_arithmetic_v<Value>)
        return static_cast<float>(value);
    else if constexpr (std::is_same_v<Value, nanovdb::Rgba8>)
        return openvdb::Vec3s(value.r(), value.g(), value.b()) / 255.0f;
    else
        return openvdb::Vec3s(static_cast<float>(value[0]), static_cast<float>(value[1]), static_cast<float>(value[2]));
}

/// Walks a tree of NanoVDB's build type and makes the OpenVDB grid.
template <typename Build>
class Walk {
    using Root = typename nanovdb::NanoRoot<Build>::DataType;
    using Upper = typename nanovdb::NanoUpper<Build>::DataType;
    using Lower = typename nanovdb::NanoLower<Build>::DataType;
    using Leaf = typename nanovdb::NanoLeaf<Build>::DataType;
    using Out = decltype(toOpenVdb(std::declval<typename Root::ValueT>()));
    using Grid = openvdb::Grid<typename openvdb::tree::Tree4<Out>::Type>;
    static constexpr bool kIsMask = std::is_same_v<Build, nanovdb::ValueMask>;

  public:
    Walk(const VdbBytes& file, const VdbLayout::Grid& layout, const NanoBytes& bytes)
        : m_file(file), m_layout(layout), m_bytes(bytes) {}

    openvdb::GridBase::Ptr run() {
        const auto& head = node<nanovdb::GridData>(0);
        const auto& tree = node<nanovdb::TreeData<3>>(sizeof(nanovdb::GridData));
        if (static_cast<std::uint32_t>(head.mGridType) != m_layout.nano->type)
            refuse("its type is not that of its description");
        const std::uint64_t rootAt = sizeof(nanovdb::GridData) + tree.mNodeOffset[3];
        const auto& root = node<Root>(rootAt);
        m_grid = Grid::create(valueOf(root.mBackground));
        place(head.mMap);
        using Tile = typename Root::Tile;
        const std::uint64_t tilesAt = rootAt + sizeof(Root);
        if (root.mTableSize > m_bytes.size / sizeof(Tile)) refuse("it claims too many tiles");
        for (std::uint32_t i = 0; i < root.mTableSize; ++i) {
            const std::uint64_t tileAt = tilesAt + i * sizeof(Tile);
            const Tile& tile = node<Tile>(tileAt);
            const nanovdb::Coord key = tile.origin();
            const openvdb::Coord origin(key[0] & ~4095, key[1] & ~4095, key[2] & ~4095);
            if (tile.child != 0)
                upper(offsetOf(rootAt, tile.child), origin);
            else
                addTile(3, origin, valueOf(tile.value), tile.state != 0);
        }
        return m_grid;
    }

  private:
    [[noreturn]] void refuse(const std::string& reason) const { damaged(m_file, m_layout, reason); }

    std::uint64_t offsetOf(std::uint64_t parent, std::int64_t child) const {
        return parent + static_cast<std::uint64_t>(child);  // what lies outside of the bytes is refused by `node`
    }
    /// What lies at an offset, all of which is within the bytes; `more` bytes must follow it.
    template <typename T>
    const T& node(std::uint64_t at, std::uint64_t more = 0) const {
        if (at % alignof(T) != 0 || at > m_bytes.size || sizeof(T) + more > m_bytes.size - at)
            refuse("one of its nodes lies outside of its bytes");
        return *reinterpret_cast<const T*>(m_bytes.bytes.get() + at);
    }
    /// Nodes that a damaged file refers to many times would make a tree without end.
    void count(std::uint64_t& nodes, std::uint64_t bytes) const {
        if (++nodes > m_bytes.size / bytes) refuse("it has more nodes than its bytes can hold");
    }

    template <typename Value>
    static Out valueOf(const Value& value) {
        if constexpr (kIsMask)
            return 0;
        else
            return toOpenVdb(value);
    }
    void addTile(openvdb::Index level, const openvdb::Coord& origin, Out value, bool on) {
        if constexpr (kIsMask) value = on ? 1.0f : 0.0f;
        if (on || value != m_grid->background()) m_grid->tree().addTile(level, origin, value, on);
    }

    void upper(std::uint64_t at, const openvdb::Coord& origin) {
        const auto& data = node<Upper>(at);
        count(m_uppers, sizeof(Upper));
        inner<5, 128>(data, 2, origin,
                      [&](std::int64_t child, const openvdb::Coord& place) { lower(offsetOf(at, child), place); });
    }
    void lower(std::uint64_t at, const openvdb::Coord& origin) {
        const auto& data = node<Lower>(at);
        count(m_lowers, sizeof(Lower));
        inner<4, 8>(data, 1, origin,
                    [&](std::int64_t child, const openvdb::Coord& place) { leaf(offsetOf(at, child), place); });
    }
    /// The children and tiles of a node of (2^Log)^3 cells of `Edge` voxels.
    template <int Log, int Edge, typename Data, typename Visit>
    void inner(const Data& data, openvdb::Index level, const openvdb::Coord& origin, const Visit& visit) {
        constexpr std::uint32_t kMask = (1u << Log) - 1;
        for (std::uint32_t n = 0; n < 1u << (3 * Log); ++n) {
            const openvdb::Coord place =
                origin + openvdb::Coord(static_cast<int>(n >> (2 * Log)) * Edge,
                                        static_cast<int>(n >> Log & kMask) * Edge, static_cast<int>(n & kMask) * Edge);
            if (data.mChildMask.isOn(n))
                visit(data.mTable[n].child, place);
            else
                addTile(level, place, valueOf(data.mTable[n].value), data.mValueMask.isOn(n));
        }
    }
    void leaf(std::uint64_t at, const openvdb::Coord& origin) {
        const auto& data = node<Leaf>(at);
        if constexpr (std::is_same_v<Build, nanovdb::FpN>) node<Leaf>(at, data.bitWidth() * std::uint64_t{64});
        count(m_leaves, sizeof(Leaf));
        auto* const to = m_grid->tree().touchLeaf(origin);
        for (std::uint32_t n = 0; n < kVoxels; ++n) {
            const bool on = data.mValueMask.isOn(n);
            if constexpr (kIsMask)
                to->setValueOnly(n, on ? 1.0f : 0.0f);
            else
                to->setValueOnly(n, toOpenVdb(data.getValue(n)));
            to->setActiveState(n, on);
        }
    }

    void place(const nanovdb::Map& map) {
        openvdb::Mat4d m = openvdb::Mat4d::identity();
        // NanoVDB multiplies column vectors.
        for (int row = 0; row < 3; ++row) {
            for (int column = 0; column < 3; ++column) m(column, row) = map.mMatD[3 * row + column];
            m(3, row) = map.mVecD[row];
        }
        for (int i = 0; i < 16; ++i)
            if (!std::isfinite(m.asPointer()[i])) refuse("its transform is not finite");
        try {
            m_grid->setTransform(openvdb::math::Transform::createLinearTransform(m));
        } catch (const openvdb::Exception&) {
            refuse("its transform cannot be inverted");
        }
    }

    const VdbBytes& m_file;
    const VdbLayout::Grid& m_layout;
    const NanoBytes& m_bytes;
    typename Grid::Ptr m_grid;
    std::uint64_t m_uppers = 0, m_lowers = 0, m_leaves = 0;
};

openvdb::GridBase::Ptr converted(const VdbBytes& file, const VdbLayout::Grid& layout, const NanoBytes& bytes) {
    using nanovdb::GridType;
    const auto as = [&]<typename Build>(Build*) { return Walk<Build>(file, layout, bytes).run(); };
    switch (static_cast<GridType>(layout.nano->type)) {
        case GridType::Float:
            return as(static_cast<float*>(nullptr));
        case GridType::Double:
            return as(static_cast<double*>(nullptr));
        case GridType::Int16:
            return as(static_cast<std::int16_t*>(nullptr));
        case GridType::Int32:
            return as(static_cast<std::int32_t*>(nullptr));
        case GridType::Int64:
            return as(static_cast<std::int64_t*>(nullptr));
        case GridType::UInt32:
            return as(static_cast<std::uint32_t*>(nullptr));
        case GridType::Boolean:
            return as(static_cast<bool*>(nullptr));
        case GridType::Mask:
            return as(static_cast<nanovdb::ValueMask*>(nullptr));
        case GridType::Fp4:
            return as(static_cast<nanovdb::Fp4*>(nullptr));
        case GridType::Fp8:
            return as(static_cast<nanovdb::Fp8*>(nullptr));
        case GridType::Fp16:
            return as(static_cast<nanovdb::Fp16*>(nullptr));
        case GridType::FpN:
            return as(static_cast<nanovdb::FpN*>(nullptr));
        case GridType::Vec3f:
            return as(static_cast<nanovdb::Vec3f*>(nullptr));
        case GridType::Vec3d:
            return as(static_cast<nanovdb::Vec3d*>(nullptr));
        case GridType::Vec4f:
            return as(static_cast<nanovdb::Vec4f*>(nullptr));
        case GridType::Vec4d:
            return as(static_cast<nanovdb::Vec4d*>(nullptr));
        case GridType::RGBA8:
            return as(static_cast<nanovdb::Rgba8*>(nullptr));
        default:
            throw Error(ErrorKind::input,
                        fmt::format("{}: grid '{}' has the type '{}', which is not read; save it as float", file.path(),
                                    shortened(layout.name, 80), layout.type));
    }
}

}  // namespace

openvdb::GridBase::Ptr readNanoGrid(const VdbBytes& file, const VdbLayout::Grid& layout) {
    const openvdb::GridBase::Ptr grid = converted(file, layout, unpacked(file, layout));
    grid->setName(layout.name);
    grid->setGridClass(openvdb::GridBase::stringToGridClass(layout.gridClass));
    return grid;
}

}  // namespace scrim
