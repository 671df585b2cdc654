// SPDX-License-Identifier: Apache-2.0
#include <scrim/engine/cells/surface_cells.h>

#include <scrim/base/parallel.h>
#include <scrim/scene/optics.h>

#include <algorithm>
#include <cmath>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim {
namespace {

// What a volume shows at places close together. For one thread.
class Places {
  public:
    Places(const ViewVolume& volume, const VolumeOptics& optics, const FieldSampler& field, double edge, double voxel)
        : m_volume(volume), m_look(*volume.classified), m_optics(optics), m_field(field), m_edge(edge), m_voxel(voxel) {
        m_isFromWs = glm::inverse(volume.wsFromIs);
        m_gradient = 0.5 * glm::transpose(Mat3(m_isFromWs));
    }

    // Copies the voxels around a box. Returns false if nothing is there.
    bool enter(const Bounds& ws) {
        if (m_optics.emptyDistance(ws.center()) > 0.5 * glm::length(ws.size()) + m_edge) return false;
        Bounds is = transformed(m_isFromWs, ws);
        is.lower -= 1.0;
        is.upper += 1.0;
        m_copied = !m_volume.velocity && m_brick.fill(m_field, is);
        return true;
    }
    double value(const Vec3& ws) const {
        return m_copied ? m_brick.value(transformPoint(m_isFromWs, ws)) : m_optics.density(ws);
    }
    Vec3 gradient(const Vec3& ws) const {
        return m_copied ? m_gradient * m_brick.difference(transformPoint(m_isFromWs, ws)) : m_optics.gradient(ws);
    }
    double extinction(const Vec3& ws, double value, const Vec3& slope) const {
        double own = classify(m_look, std::max(value, 0.0)).extinction;
        if (own > 0 && !m_volume.wsClip.empty()) own *= partIn(m_volume.wsClip, ws, Mat3(m_edge));
        return m_look.gradientRamp.empty() ? own : own * gradientFactor(m_look, glm::length(slope));
    }
    // The normal, and its weight.
    std::array<Real, 4> facing(const Vec3& ws, Vec3 slope) const {
        if (!m_volume.wsClip.empty())
            slope += cutGradient(m_look, m_voxel) * scrim::facing(m_volume.wsClip, ws, m_voxel);
        const double length = glm::length(slope);
        if (length == 0) return {};
        const Vec3 normal = -slope / length;
        return {Real(normal.x), Real(normal.y), Real(normal.z), Real(normalWeight(m_look, length, m_voxel))};
    }

  private:
    const ViewVolume& m_volume;
    const Classified& m_look;
    const VolumeOptics& m_optics;
    const FieldSampler& m_field;
    double m_edge, m_voxel;
    Mat4 m_isFromWs;
    Mat3 m_gradient;
    FieldBrick m_brick;
    bool m_copied = false;
};

// Calls visit(places, cell, its centre) for the cells of a grid that the volume's voxels may reach, in parallel.
template <class Visit>
void visitPlaces(const CellGrid& grid, const ViewVolume& volume, Kernel kernel, double voxel, const Visit& visit) {
    FieldSamplers samplers;
    const VolumeOptics optics(volume, kernel, samplers);
    const FieldSampler field(*volume.field, volume.kernel.value_or(kernel));
    // Eighths of blocks are small enough for what is known of empty space.
    constexpr int kHalf = kCellEdge / 2;
    parallelFor(grid.storedBlocks().size(), [&](std::size_t b) {
        Places places(volume, optics, field, grid.edge(), voxel);
        for (int eighth = 0; eighth < 8; ++eighth) {
            const Int3 within = kHalf * Int3(eighth & 1, eighth >> 1 & 1, eighth >> 2 & 1),
                       corner = grid.storedBlocks()[b] * kCellEdge + within;
            if (!places.enter({grid.wsFromCs(Vec3(corner)), grid.wsFromCs(Vec3(corner + kHalf))})) continue;
            for (int i = 0; i < kHalf * kHalf * kHalf; ++i) {
                const Int3 at = within + Int3(i % kHalf, i / kHalf % kHalf, i / (kHalf * kHalf));
                const std::size_t cell = b * kBlockCells + std::size_t(cellOffset(at.x, at.y, at.z));
                visit(places, cell, grid.wsCenter(cell));
            }
        }
    });
}

// Rays find the extinction interpolated between the cells beside them: takes the mean error of that from it.
void sharpen(const CellGrid& grid, std::vector<Real>& extinction) {
    constexpr Real kPerBend = Real(1.0 / 12);
    const std::vector<Real> own = extinction;
    parallelFor(grid.storedBlocks().size(), [&](std::size_t b) {
        for (std::size_t cell = b * kBlockCells; cell < (b + 1) * kBlockCells; ++cell) {
            const Int3 at = grid.place(cell);
            Real bend = 0;
            for (int a = 0; a < 3; ++a) {
                Int3 step(0);
                step[a] = 1;
                for (const std::ptrdiff_t beside : {grid.index(at - step), grid.index(at + step)})
                    bend += (beside < 0 ? 0 : own[std::size_t(beside)]) - own[cell];
            }
            extinction[cell] = std::max(own[cell] - kPerBend * bend, Real(0));
        }
    });
}

}  // namespace

ExtinctionIntegral::ExtinctionIntegral(const Classified& look, double most)
    : integral(kCount + 2), mean(kCount + 2), scale(static_cast<Real>(kCount / most)) {
    constexpr int kPoints = 8;  // of an interval
    double sum = 0;
    for (int i = 0; i < kCount + 2; ++i) {
        double own = 0;
        for (int p = 0; p < kPoints; ++p)
            own += classify(look, std::min((i + (p + 0.5) / kPoints) / double(scale), most)).extinction / kPoints;
        integral[std::size_t(i)] = static_cast<Real>(sum);
        mean[std::size_t(i)] = static_cast<Real>(own);
        sum += own / double(scale);
    }
    int first = 0;
    while (first < kCount && mean[std::size_t(first)] == 0) ++first;
    empty = static_cast<Real>(first / double(scale));
}

bool isByValueAlone(const ViewVolume& volume) {
    return volume.wsClip.empty() && volume.classified->gradientRamp.empty();
}

SurfaceCells surfaceCells(const CellGrid& grid, const ViewVolume& volume, Kernel kernel, double voxel) {
    SurfaceCells out;
    out.extinction.assign(grid.cells(), Real(0));
    out.value.assign(grid.cells(), Real(0));
    const bool byGradient = !volume.classified->gradientRamp.empty();
    visitPlaces(grid, volume, kernel, voxel, [&](const Places& places, std::size_t cell, const Vec3& ws) {
        const double value = places.value(ws);
        out.value[cell] = static_cast<Real>(value);
        out.extinction[cell] =
            static_cast<Real>(places.extinction(ws, value, byGradient ? places.gradient(ws) : Vec3(0)));
    });
    // Where values say what holds light back, extinction only says where there is any.
    if (!isByValueAlone(volume)) sharpen(grid, out.extinction);
    return out;
}

SurfaceNormals surfaceNormals(const CellGrid& grid, const ViewVolume& volume, Kernel kernel, double voxel) {
    SurfaceNormals out;
    for (std::vector<Real>& row : out) row.assign(grid.cells(), Real(0));
    visitPlaces(grid, volume, kernel, voxel, [&](const Places& places, std::size_t cell, const Vec3& ws) {
        const auto facing = places.facing(ws, places.gradient(ws));
        for (std::size_t part = 0; part < facing.size(); ++part) out[part][cell] = facing[part];
    });
    return out;
}

std::vector<Bounds> SurfaceCells::boxes(const CellGrid& grid, const std::vector<bool>& blocks, double margin) const {
    std::vector<Bounds> boxes;
    // Kernels reach beyond voxels, and may end in the outermost cells.
    const Vec3 least = grid.wsFromCs(Vec3(0.5)), most = grid.wsFromCs(Vec3(grid.blocks() * kCellEdge) - 0.5);
    for (std::size_t b = 0; b < grid.storedBlocks().size(); ++b) {
        const auto first = extinction.begin() + static_cast<std::ptrdiff_t>(b * kBlockCells);
        if (!blocks[b] || std::none_of(first, first + kBlockCells, [](Real sigma) { return sigma > 0; })) continue;
        Bounds box;
        const Int3 corner = grid.storedBlocks()[b] * kCellEdge;
        for (int i = 0; i < kBlockCells; ++i)
            if (first[i] > 0)
                box.include(grid.wsFromCs(
                    Vec3(corner + Int3(i % kCellEdge, i / kCellEdge % kCellEdge, i / (kCellEdge * kCellEdge))) + 0.5));
        boxes.push_back({glm::max(box.lower - margin, least), glm::min(box.upper + margin, most)});
    }
    return boxes;
}

}  // namespace scrim
