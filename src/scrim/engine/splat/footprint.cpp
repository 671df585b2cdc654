// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/splat/footprint.h>

#include <scrim/base/parallel.h>

#include <algorithm>
#include <cmath>
#include <tuple>
#include <utility>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

// Half the extent of the kernel along each axis of texel space.
Vec3 kernelExtents(Kernel kernel, const Mat4& tsFromIs) {
    Vec3 extent;
    for (int axis = 0; axis < 3; ++axis)
        extent[axis] = kernelExtent(kernel, {tsFromIs[0][axis], tsFromIs[1][axis], tsFromIs[2][axis]});
    return extent;
}

}  // namespace

struct FootprintTable::Shape {
    Vec3 extent;
    Int3 first, count;  // columns, rows, sheets
    int rowStride;
};

FootprintTable::Shape FootprintTable::shapeOf(Kernel kernel, const Mat4& tsFromIs, const Steps& steps) {
    const auto texels = [&](double extent) {  // integers i with |i - fraction| < extent for some fraction
        const double most = 1 - 1.0 / steps.texel;
        const int first = static_cast<int>(std::floor(-extent)) + 1;
        const int last = static_cast<int>(std::ceil(most + extent)) - 1;
        return std::pair(first, std::max(2, last - first + 1));  // a piece has two rows
    };
    Shape shape;
    shape.extent = kernelExtents(kernel, tsFromIs);
    std::tie(shape.first.x, shape.count.x) = texels(shape.extent.x);
    std::tie(shape.first.y, shape.count.y) = texels(shape.extent.y);
    // The slabs [m, m+1) - fraction that overlap the open interval (-extent, extent).
    const double most = 1 - 1.0 / steps.sheet;
    const int firstSheet = static_cast<int>(std::floor(-shape.extent.z - 1)) + 1;
    const int lastSheet = static_cast<int>(std::ceil(most + shape.extent.z)) - 1;
    shape.first.z = firstSheet;
    shape.count.z = lastSheet - firstSheet + 1;
    shape.rowStride = (shape.count.x + 3) / 4 * 4;
    return shape;
}

std::size_t FootprintTable::bytes(Kernel kernel, const Mat4& tsFromIs, const Steps& steps) {
    const Shape shape = shapeOf(kernel, tsFromIs, steps);
    const std::size_t parts = steps.sloped ? 4 : 1;
    return parts * std::size_t(steps.texel * steps.texel * steps.sheet) * sizeof(Real) * std::size_t(shape.count.z) *
           std::size_t(shape.count.y * shape.rowStride);
}

FootprintTable::Steps footprintSteps(const Mat4& tsFromIs, int stepsPerVoxel) {
    // A voxel's size along an axis of texel space: the combined length of its three edges along it.
    const auto voxelAlong = [&](int axis) {
        const Vec3 edges(tsFromIs[0][axis], tsFromIs[1][axis], tsFromIs[2][axis]);
        return glm::length(edges);
    };
    // The smallest power of two that suffices. With six instead of eight steps of texels per voxel,
    // the error of thin media rises by 0.7 %; for sheets six steps suffice.
    constexpr double kTexels = 0.95, kSheets = 0.75;
    // Texels of a quarter of a voxel are for small errors. Two steps a texel left more than the texels themselves:
    // where one depth is all that is seen, beside a lamp, 3.8 % instead of 1.1, which flickered. Much larger footprints
    // have enough steps anyway, and their tables would be large.
    constexpr double kWide = 8;
    const auto steps = [&](int n, double voxel, double enough) {
        while (n < 128 && n * voxel < enough * stepsPerVoxel) n *= 2;
        return n;
    };
    const double voxel = std::min(voxelAlong(0), voxelAlong(1));
    return {steps(voxel < kWide ? 4 : 2, voxel, kTexels), steps(2, voxelAlong(2), kSheets)};
}

namespace {

// True if each axis of the grid runs along U, V or N, within `most` texels a voxel.
bool liesAlongTexels(const Mat4& tsFromIs, double most) {
    for (int axis = 0; axis < 3; ++axis)
        if (std::min(std::abs(tsFromIs[axis].x), std::abs(tsFromIs[axis].y)) > most) return false;
    return true;
}

}  // namespace

FootprintTable::Steps slopedSteps(Kernel kernel, const Mat4& tsFromIs, int stepsPerVoxel) {
    FootprintTable::Steps steps = footprintSteps(tsFromIs, stepsPerVoxel);
    steps.sloped = true;
    if (kernel != Kernel::linear || !liesAlongTexels(tsFromIs, 1.0 / steps.texel)) return steps;
    // A texel straight above a voxel is at the peak of its kernel, whose slope is 0 there: all voxels that are rounded
    // to it are as bright as the peak, and no rounding at the kernel's foot makes up for that. Haze of 2.2 texels a
    // voxel, seen along an axis, was 2.4 % too dense with 4 steps a texel, and a lamp in it 5.9 % off; with 8 steps,
    // which its table has room for, 0.3 and 0.9 %.
    constexpr int kPerVoxel = 32;
    constexpr std::size_t kMostBytes = std::size_t{1} << 21;
    const int enough = footprintSteps(tsFromIs, kPerVoxel).texel;
    for (FootprintTable::Steps finer = steps;; steps = finer) {
        finer.texel *= 2;
        if (finer.texel > enough || FootprintTable::bytes(kernel, tsFromIs, finer) > kMostBytes) return steps;
    }
}

FootprintTable::FootprintTable(Kernel kernel, const Mat4& tsFromIs, const Steps& steps) : m_steps(steps) {
    const Shape shape = shapeOf(kernel, tsFromIs, steps);
    m_extent = shape.extent;
    m_first = shape.first;
    m_count = shape.count;
    m_rowStride = shape.rowStride;
    m_weights.resize(bytes(kernel, tsFromIs, steps) / sizeof(Real));

    const Mat3 isFromTs = glm::inverse(Mat3(tsFromIs));
    parallelFor(std::size_t(steps.texel), [&](std::size_t stepV) { fill(kernel, isFromTs, static_cast<int>(stepV)); });
    if (steps.sloped)
        parallelFor(std::size_t(steps.texel), [&](std::size_t stepV) { addSlopes(static_cast<int>(stepV)); });
}

// Central differences over one step to either side. The step after a texel's last one is the first
// step of the next texel, where the footprint has moved by one texel.
void FootprintTable::addSlopes(int stepV) {
    const auto weight = [&](int stepU, int v, int stepN, int slab, int row, int column) {
        const auto wrap = [](int& step, int steps, int& place) {
            if (step < 0) {
                step += steps;
                ++place;
            } else if (step >= steps) {
                step -= steps;
                --place;
            }
        };
        wrap(stepU, m_steps.texel, column);
        wrap(v, m_steps.texel, row);
        wrap(stepN, m_steps.sheet, slab);
        if (column < 0 || column >= columns() || row < 0 || row >= rows() || slab < 0 || slab >= sheets())
            return Real(0);
        return m_weights[offset(stepU, v, stepN) + std::size_t(slab * sheetStride() + row * m_rowStride + column)];
    };
    for (int stepU = 0; stepU < m_steps.texel; ++stepU)
        for (int stepN = 0; stepN < m_steps.sheet; ++stepN)
            for (int slab = 0; slab < sheets(); ++slab)
                for (int row = 0; row < rows(); ++row)
                    for (int column = 0; column < columns(); ++column) {
                        const auto change = [&](int u, int v, int n) {
                            return Real(0.5) * (weight(stepU + u, stepV + v, stepN + n, slab, row, column) -
                                                weight(stepU - u, stepV - v, stepN - n, slab, row, column));
                        };
                        Real* entry = m_weights.data() + offset(stepU, stepV, stepN) + slab * sheetStride() +
                                      row * m_rowStride + column;
                        entry[partStride()] = change(1, 0, 0);
                        entry[2 * partStride()] = change(0, 1, 0);
                        entry[3 * partStride()] = change(0, 0, 1);
                    }
}

// Fills the entries of one quantised fraction in v. For each texel of the footprint, the kernel is integrated along w
// once, cumulatively in the table's steps; every sheet's share is then a difference.
void FootprintTable::fill(Kernel kernel, const Mat3& isFromTs, int stepV) {
    const int fineCount = (sheets() + 1) * m_steps.sheet;
    const double fine = 1.0 / m_steps.sheet;
    const double depth0 = m_first.z - 1.0;  // N of the cumulative integral's first point
    // Two-point Gauss quadrature is exact for the cubics of which `linear` consists, apart from its kinks. If rays of a
    // view lie almost within the sheets, a step of the table spans many voxels, and is divided.
    constexpr double kLongestStep = 0.25;  // voxels
    const int cuts = std::max(1, static_cast<int>(std::ceil(glm::length(isFromTs[2]) * fine / kLongestStep - 1e-9)));
    const double cut = fine / cuts, gauss = 0.5 * cut / std::sqrt(3.0);
    std::vector<double> cumulative(std::size_t(fineCount) + 1);

    for (int stepU = 0; stepU < m_steps.texel; ++stepU)
        for (int row = 0; row < rows(); ++row)
            for (int column = 0; column < columns(); ++column) {
                const double x = m_first.x + column - double(stepU) / m_steps.texel;
                const double y = m_first.y + row - double(stepV) / m_steps.texel;
                const Vec3 at0 = isFromTs * Vec3(x, y, 0);
                double sum = 0;
                cumulative[0] = 0;
                for (int i = 0; i < fineCount; ++i) {
                    for (int c = 0; c < cuts; ++c) {
                        const double middle = depth0 + i * fine + (c + 0.5) * cut;
                        if (std::abs(middle) < m_extent.z + fine)
                            sum += 0.5 * cut *
                                   (kernelValue(kernel, at0 + isFromTs[2] * (middle - gauss)) +
                                    kernelValue(kernel, at0 + isFromTs[2] * (middle + gauss)));
                    }
                    cumulative[std::size_t(i) + 1] = sum;
                }
                for (int stepN = 0; stepN < m_steps.sheet; ++stepN) {
                    const auto read = [&](int slab) { return cumulative[(slab + 1) * m_steps.sheet - stepN]; };
                    Real* entry = m_weights.data() + offset(stepU, stepV, stepN) + row * m_rowStride + column;
                    for (int slab = 0; slab < sheets(); ++slab)
                        entry[slab * sheetStride()] = static_cast<Real>(read(slab + 1) - read(slab));
                }
            }
}

FootprintPieces::FootprintPieces(const FootprintTable& table) : m_beginStride(std::size_t(table.sheets()) + 1) {
    std::vector<int> done;  // for each kind, its rows that belong to the preceding piece
    for (int sheet = 0; sheet < table.sheets(); ++sheet)
        for (int row = 0; row < table.rows(); row += kRows)
            for (int column = 0; column < table.rowStride(); column += kColumns) {
                // With an odd number of rows, the last piece starts one row earlier, and leaves
                // that row to the preceding piece.
                m_places.emplace_back(column, std::min(row, table.rows() - kRows), sheet);
                done.push_back(row - m_places.back().y);
            }
    const std::size_t perSheet = m_places.size() / std::size_t(table.sheets());
    const std::size_t entrySize = std::size_t(table.sheets() * table.sheetStride());
    const std::size_t entries = table.bytes() / sizeof(Real) / entrySize;
    m_begins.reserve(entries * m_beginStride);
    for (std::size_t e = 0; e < entries; ++e) {
        const Real* entry = table.weights() + e * entrySize;
        for (std::size_t k = 0; k < m_places.size(); ++k) {
            if (k % perSheet == 0) m_begins.push_back(static_cast<std::uint32_t>(m_kinds.size()));
            const Int3& place = m_places[k];
            Piece piece{};
            bool empty = true;
            for (int part = 0; part < 4; ++part)
                for (int row = done[k]; row < kRows; ++row)
                    for (int column = 0; column < kColumns; ++column) {
                        const Real weight = entry[place.z * table.sheetStride() + part * table.partStride() +
                                                  (place.y + row) * table.rowStride() + place.x + column];
                        piece.values[(part * kRows + row) * kColumns + column] = weight;
                        empty = empty && weight == 0;
                    }
            if (empty) continue;
            m_kinds.push_back(static_cast<std::uint32_t>(k));
            m_pieces.push_back(piece);
        }
        m_begins.push_back(static_cast<std::uint32_t>(m_kinds.size()));
    }
}

std::vector<std::ptrdiff_t> FootprintPieces::offsets(std::ptrdiff_t planeStride, std::ptrdiff_t rowStride) const {
    std::vector<std::ptrdiff_t> offsets;
    for (const Int3& place : m_places) offsets.push_back(place.z * planeStride + place.y * rowStride + place.x);
    return offsets;
}

std::size_t FootprintPieces::bytes() const {
    return (m_begins.size() + m_kinds.size()) * sizeof(std::uint32_t) + m_pieces.size() * sizeof(Piece);
}

}  // namespace scrim
