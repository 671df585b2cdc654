// SPDX-License-Identifier: Apache-2.0
#include "sweep_marcher.h"

#include <scrim/base/parallel.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>

#include <glm/geometric.hpp>
#include <glm/matrix.hpp>

namespace scrim::bench {
namespace {

constexpr int kMargin = 2;
constexpr int kPad = 20;  // floats around the scratch planes of a sweep: a vector, and a look-up's neighbours
constexpr float kInverseFourPi = 0.0795774715f;

struct Free {
    void operator()(float* p) const { std::free(p); }
};
using Zeroed = std::unique_ptr<float[], Free>;

/// Zeros whose pages cost nothing before they are written.
Zeroed zeroed(std::size_t count) {
    return Zeroed(static_cast<float*>(std::calloc(count, sizeof(float))));
}

/// Weights of the places -1, 0, 1 and 2 for a look-up at t between 0 and 1.
std::array<float, 4> weights(float t, bool cubic) {
    if (!cubic) return {0, 1 - t, t, 0};
    const float s = 1 - t;  // Catmull-Rom
    return {-0.5f * t * s * s, s * (1 + t - 1.5f * t * t), t * (1 + s - 1.5f * s * s), -0.5f * s * t * t};
}

}  // namespace

/// The lattice of a light volume.
struct SweepMarcher::Cells {
    int coarseness;
    int size[3];

    std::size_t count() const {
        return static_cast<std::size_t>(size[0]) * static_cast<std::size_t>(size[1]) *
               static_cast<std::size_t>(size[2]);
    }
};

SweepMarcher::SweepMarcher(const ViewScene& scene) : m_scene(scene) {
    const ViewVolume& volume = scene.volumes.front();
    const SparseField& field = *volume.field;
    const Vec3 light = glm::normalize(glm::inverse(Mat3(volume.wsFromIs)) * -scene.lights.front().wsDirection);
    int sun = 0;
    for (int a = 1; a < 3; ++a)
        if (std::abs(light[a]) > std::abs(light[sun])) sun = a;
    m_axis[0] = sun;
    m_axis[1] = sun == 0 ? 1 : 0;
    m_axis[2] = sun == 2 ? 1 : 2;
    const Bounds is = field.isBounds();
    for (int a = 0; a < 3; ++a) {
        m_toLight[a] = static_cast<float>(light[m_axis[a]]);
        m_isOrigin[a] = is.lower[m_axis[a]] - kMargin;
        m_size[a] = static_cast<int>(is.upper[m_axis[a]] - is.lower[m_axis[a]]) + 1 + 2 * kMargin;
        m_bricks[a] = (m_size[a] + 7) / 8;
    }
    fill(field, static_cast<float>(volume.medium.densityScale * glm::length(Vec3(volume.wsFromIs[0]))));
    findBricks();
}

void SweepMarcher::fill(const SparseField& field, float scale) {
    m_values.assign(place(m_size[0], 0, 0) + kPad, 0.0f);
    for (std::size_t n = 0; n < field.blockCount(); ++n) {
        const Int3 origin = field.blockOrigins[n];
        int at[3];
        for (int a = 0; a < 3; ++a) at[a] = origin[m_axis[a]] - static_cast<int>(m_isOrigin[a]);
        for (int i = 0; i < kBlockVoxels; ++i) {
            const int in[3] = {i >> 6, i >> 3 & 7, i & 7};
            const float value = field.block(n)[i] * scale;
            if (value > 0) m_values[place(at[0] + in[m_axis[0]], at[1] + in[m_axis[1]], at[2] + in[m_axis[2]])] = value;
        }
    }
}

// A brick is occupied where it or the voxel around it is not empty. The others know how far, in the largest of three
// coordinates, the next occupied one is.
void SweepMarcher::findBricks() {
    const auto brick = [&](int a, int b, int c) {
        return static_cast<std::size_t>((a * m_bricks[1] + b) * m_bricks[2] + c);
    };
    const int far = std::max({m_bricks[0], m_bricks[1], m_bricks[2]}) + 1;
    m_gap.assign(brick(m_bricks[0], 0, 0), far);
    const auto neighbours = [](int x, int axisBricks, const auto& visit) {
        for (int n = std::max(0, x - 1) / 8; n <= std::min((x + 1) / 8, axisBricks - 1); ++n) visit(n);
    };
    for (int a = 0; a < m_size[0]; ++a)
        for (int b = 0; b < m_size[1]; ++b)
            for (int c = 0; c < m_size[2]; ++c) {
                if (m_values[place(a, b, c)] == 0) continue;
                neighbours(a, m_bricks[0], [&](int x) {
                    neighbours(b, m_bricks[1],
                               [&](int y) { neighbours(c, m_bricks[2], [&](int z) { m_gap[brick(x, y, z)] = 0; }); });
                });
            }
    // A round for each distance: bricks next to those that are nearer, an axis after the other.
    const std::size_t strides[3] = {brick(1, 0, 0), brick(0, 1, 0), 1};
    for (int round = 1; round < far; ++round) {
        std::vector<char> near(m_gap.size());
        for (std::size_t i = 0; i < near.size(); ++i) near[i] = m_gap[i] < round;
        for (int axis = 0; axis < 3; ++axis) {
            const std::vector<char> now = near;
            for (std::size_t i = 0; i < now.size(); ++i) {
                const int at = static_cast<int>(i / strides[axis]) % m_bricks[axis];
                const bool below = at > 0 && now[i - strides[axis]];
                const bool above = at + 1 < m_bricks[axis] && now[i + strides[axis]];
                if (below || above) near[i] = 1;
            }
        }
        for (std::size_t i = 0; i < near.size(); ++i)
            if (near[i]) m_gap[i] = std::min(m_gap[i], round);
    }
    findRows();
}

void SweepMarcher::findRows() {
    const auto brick = [&](int a, int b, int c) {
        return static_cast<std::size_t>((a * m_bricks[1] + b) * m_bricks[2] + c);
    };
    // Rows of voxels that a sample in an occupied brick looks at: those of the brick, and one more.
    m_rows.assign(2 * static_cast<std::size_t>(m_size[0] * m_size[1]), 0);
    for (int a = 0; a < m_size[0]; ++a)
        for (int b = 0; b < m_size[1]; ++b) {
            int* row = m_rows.data() + 2 * (a * m_size[1] + b);
            for (int c = 0; c < m_bricks[2]; ++c)
                for (int i = 0; i < 4; ++i) {
                    if (m_gap[brick((a - (i & 1)) / 8, (b - (i >> 1)) / 8, c)] != 0) continue;
                    if (row[1] == 0) row[0] = 8 * c;
                    row[1] = std::min(8 * c + 9, m_size[2]);
                }
        }
}

std::vector<float> SweepMarcher::averaged(const Cells& cells) const {
    std::vector<float> out(cells.count() + kPad, 0.0f);
    const int n = cells.coarseness;
    const float weight = 1.0f / static_cast<float>(n * n * n);
    parallelFor(static_cast<std::size_t>(cells.size[0]), [&](std::size_t a) {
        for (int x = static_cast<int>(a) * n; x < std::min(m_size[0], static_cast<int>(a + 1) * n); ++x)
            for (int y = 0; y < m_size[1]; ++y) {
                const int* row = m_rows.data() + 2 * (x * m_size[1] + y);
                const std::size_t to = (a * static_cast<std::size_t>(cells.size[1]) + static_cast<std::size_t>(y / n)) *
                                       static_cast<std::size_t>(cells.size[2]);
                for (int z = row[0]; z < row[1]; ++z)
                    out[to + static_cast<std::size_t>(z / n)] += weight * m_values[place(x, y, z)];
            }
    });
    return out;
}

// From the plane next to the sun to the farthest.
void SweepMarcher::sweep(const float* extinction, const Cells& cells, bool cubic, float* light) const {
    const float slope[2] = {m_toLight[1] / std::abs(m_toLight[0]), m_toLight[2] / std::abs(m_toLight[0])};
    const int shift[2] = {static_cast<int>(std::floor(slope[0])), static_cast<int>(std::floor(slope[1]))};
    const auto down = weights(slope[0] - static_cast<float>(shift[0]), cubic);
    const auto across = weights(slope[1] - static_cast<float>(shift[1]), cubic);
    const float halfStep = 0.5f * static_cast<float>(cells.coarseness) / std::abs(m_toLight[0]);
    const std::ptrdiff_t stride = cells.size[2] + 2 * kPad;
    std::vector<float> planes[2];
    for (auto& plane : planes) plane.assign(static_cast<std::size_t>(stride * (cells.size[1] + 7)), 0.0f);
    const auto rowOf = [&](int plane, int b) { return planes[plane].data() + (b + 3) * stride + kPad; };
    constexpr int kRows = 64;  // a task
    for (int k = 0; k < cells.size[0]; ++k) {
        const int a = m_toLight[0] > 0 ? cells.size[0] - 1 - k : k;
        const int from = k & 1, to = 1 - from;
        parallelFor(static_cast<std::size_t>((cells.size[1] + kRows - 1) / kRows), [&](std::size_t task) {
            const int begin = static_cast<int>(task) * kRows;
            for (int b = begin; b < std::min(begin + kRows, cells.size[1]); ++b) {
                const std::ptrdiff_t at = (static_cast<std::ptrdiff_t>(a) * cells.size[1] + b) * cells.size[2];
                const int* range = m_rows.data() + 2 * (a * m_size[1] + b);
                const bool whole = cells.coarseness > 1;
                sweepRow({rowOf(from, b + shift[0]) + shift[1],
                          stride,
                          {down[0], down[1], down[2], down[3]},
                          {across[0], across[1], across[2], across[3]},
                          cubic ? 0 : 1,
                          extinction + at,
                          halfStep,
                          rowOf(to, b),
                          light + at,
                          whole ? 0 : range[0],
                          whole ? cells.size[2] : range[1],
                          cells.size[2]});
                // Nothing lies beyond the array's edges.
                std::fill(rowOf(to, b) + cells.size[2], rowOf(to, b) + cells.size[2] + kPad, 0.0f);
            }
        });
    }
}

// A ray from where it enters the array.
void SweepMarcher::setUp(const Vec3& isOrigin, const Vec3& isDirection, Packet& packet, int i) const {
    const Vec3 way = glm::normalize(isDirection);
    double begin = 0, end = 1e30, o[3], d[3];
    for (int a = 0; a < 3; ++a) {
        o[a] = isOrigin[m_axis[a]] - m_isOrigin[a];
        d[a] = std::abs(way[m_axis[a]]) > 1e-12 ? way[m_axis[a]] : 1e-12;
        const double t0 = (0.5 - o[a]) / d[a], t1 = (m_size[a] - 1.5 - o[a]) / d[a];
        begin = std::max(begin, std::min(t0, t1));
        end = std::min(end, std::max(t0, t1));
    }
    packet.length[i] = static_cast<float>(end - begin);
    for (int a = 0; a < 3; ++a) {
        packet.origin[a][i] = begin < end ? static_cast<float>(o[a] + begin * d[a]) : 1.0f;
        packet.direction[a][i] = static_cast<float>(d[a]);
    }
}

Image SweepMarcher::render(double step, int coarseness, bool cubic) const {
    Cells cells{coarseness, {m_size[0], m_size[1], m_size[2]}};
    if (coarseness > 1)
        for (int& n : cells.size) n = (n + coarseness - 1) / coarseness + 1;
    const Zeroed light = zeroed(cells.count() + kPad);
    if (coarseness > 1)
        sweep(averaged(cells).data(), cells, cubic, light.get());
    else
        sweep(m_values.data(), cells, cubic, light.get());

    Image image = emptyImage(m_scene.region);
    const RayFamily rays = wsRays(m_scene.camera);
    const ViewVolume& volume = m_scene.volumes.front();
    const Mat4 isFromWs = glm::inverse(volume.wsFromIs);
    const Light& sun = m_scene.lights.front();
    const DenseGrid grid{
        {m_size[0], m_size[1], m_size[2]}, m_values.data(), {m_bricks[0], m_bricks[1], m_bricks[2]}, m_gap.data()};
    const int pixels = packetSize(), high = pixels / 4;
    parallelFor(static_cast<std::size_t>((image.window.height() + high - 1) / high), [&](std::size_t row) {
        Packet packet;
        const int y0 = image.window.y0 + static_cast<int>(row) * high;
        for (int x0 = image.window.x0; x0 < image.window.x1; x0 += 4) {
            for (int i = 0; i < pixels; ++i) {
                const double x = x0 + i % 4 + 0.5, y = y0 + i / 4 + 0.5;
                setUp(transformPoint(isFromWs, rays.origin(x, y)), transformVector(isFromWs, rays.direction(x, y)),
                      packet, i);
            }
            marchPacket(grid, light.get(), cells.size, coarseness, static_cast<float>(step), packet);
            for (int i = 0; i < pixels; ++i) {
                const int x = x0 + i % 4, y = y0 + i / 4;
                if (x >= image.window.x1 || y >= image.window.y1) continue;
                float* pixel = image.rgba.data() + image.indexOf(x, y);
                for (int c = 0; c < 3; ++c)
                    pixel[c] = packet.radiance[i] * kInverseFourPi *
                               static_cast<float>(sun.intensity[c] * volume.medium.albedo[c]);
                pixel[3] = 1 - packet.transmittance[i];
            }
        }
    });
    return image;
}

}  // namespace scrim::bench
