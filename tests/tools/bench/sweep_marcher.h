// SPDX-License-Identifier: Apache-2.0
// The strongest peer: a ray marcher over a dense copy of the grid, whose light volume is filled by one sweep of
// planes along that axis of the grid that the sun is nearest to. A plane's transmittance is that of the plane before,
// looked up where the ray towards the sun crosses it, times that of what lies between (trapezoidal rule). So light
// costs a few operations a voxel, and no ray; but each look-up blurs it a little, an error that no setting takes away.
// Tuned in earnest: transmittance is carried and not optical depth, whose large values darken all around (twice the
// error); look-ups are bilinear or cubic (Catmull-Rom); the copy's planes lie across the sun; bricks of 8^3 know how
// far the next one is that is not empty; eye rays march as packets of pixels in vectors; steps are integrated in closed
// form; rays stop when opaque. One distant light, one medium.
#pragma once

#include <scrim/image/image.h>
#include <scrim/scene/view_scene.h>

#include <memory>
#include <vector>

namespace scrim::bench {

/// A dense array of floats, the last axis fastest; with its own bricks.
struct DenseGrid {
    int size[3];
    const float* values;
    int bricks[3];
    const int* gap;  ///< of each brick of 8^3: 0 where a sample can be above 0, else bricks to the next of these
};

/// The eye rays of 4 x N pixels and what they gather.
struct Packet {
    float origin[3][16], direction[3][16], length[16];
    float radiance[16], transmittance[16];
};

class SweepMarcher {
  public:
    /// Copies the first volume of `scene` (a uniform, unrotated grid) into a dense array. `scene` must outlive this.
    explicit SweepMarcher(const ViewScene& scene);

    /// Steps of eye rays of `step` voxels; light at `coarseness` voxels a cell (1 or more); look-ups in planes of light
    /// cubic or bilinear.
    Image render(double step, int coarseness, bool cubic) const;

  private:
    struct Cells;
    void fill(const SparseField& field, float scale);
    void findBricks();
    void findRows();
    void setUp(const Vec3& isOrigin, const Vec3& isDirection, Packet& packet, int pixel) const;
    std::size_t place(int a, int b, int c) const {
        return (static_cast<std::size_t>(a) * static_cast<std::size_t>(m_size[1]) + static_cast<std::size_t>(b)) *
                   static_cast<std::size_t>(m_size[2]) +
               static_cast<std::size_t>(c);
    }
    std::vector<float> averaged(const Cells& cells) const;
    void sweep(const float* extinction, const Cells& cells, bool cubic, float* light) const;

    const ViewScene& m_scene;
    int m_axis[3];                // of the grid, for each of the array's; the first is the sun's
    int m_size[3];                // voxels, two of margin on each side
    Vec3 m_isOrigin;              // index-space position of voxel (0, 0, 0) of the array, in the array's order of axes
    std::vector<float> m_values;  // extinction a voxel
    int m_bricks[3];
    std::vector<int> m_gap;
    std::vector<int> m_rows;  // of each row of voxels: the first that a sample can look at, and one past the last
    float m_toLight[3];       // unit, in the array's order of axes
};

/// The number of pixels in a packet, a multiple of 4.
int packetSize();

/// Marches a packet with steps of `step` voxels. `light`: transmittance towards the light, with cells of `coarseness`
/// voxels on an array of `lightSize`.
void marchPacket(const DenseGrid& grid, const float* light, const int* lightSize, int coarseness, float step,
                 Packet& packet);

/// A row of a plane of the sweep. Planes carry 1 - transmittance, behind half a step. `before`: the look-up's place in
/// the plane before, `stride` to its next row; `down`, `across`: weights of the rows and columns from -1 to +2, of
/// which `first` are left out at both ends.
struct SweepRow {
    const float* before;
    std::ptrdiff_t stride;
    float down[4], across[4];
    int first;
    const float* extinction;
    float halfStep;
    float* out;
    float* light;    ///< transmittance at the cells
    int begin, end;  ///< where there is extinction and light is wanted
    int count;
};
void sweepRow(const SweepRow& row);

}  // namespace scrim::bench
