// SPDX-License-Identifier: Apache-2.0
// Shading of a density between its voxels, where that shows.
//
// Shading of voxels that were divided by a factor k takes k^3 times as many. Here the density becomes a sum of two
// fields: voxels as they are, without those around which shading changes what is seen, and voxels of 1/k of the edge in
// place of these. A tent is a sum of tents of 1/k of its width (the two-scale relation), so the sum has no seam where
// shading changes nothing between voxels. All that renders volumes adds volumes up, so it needs to know nothing of
// this. Which voxels are divided depends on the volume, and not on where it is seen from: nothing changes while a
// camera moves past.
#pragma once

#include <scrim/scene/scene.h>
#include <scrim/shot/derived_fields.h>

#include <optional>
#include <utility>
#include <vector>

namespace scrim {

/// What the detail of a density is made from.
struct DetailSource {
    FieldPointer grid = nullptr;       ///< the density before displacement and shading
    FieldPointer displaced = nullptr;  ///< the same after displacement, at voxels
    FieldPointer shaded = nullptr;     ///< after displacement and shading, but for the ramp, at voxels
    FieldPointer mask = nullptr;       ///< the grid of the mask after displacement; null: there is none
    DensityShading shading = {};
    std::optional<Noise> displacement = {};
    std::vector<std::pair<double, double>> ramp = {};
    Mat4 wsFromAsset{1.0};  ///< for noise in world space
    int times = 2;          ///< voxels are divided by 2, 4 or 8 along each axis
    /// Optical depth of a density of 1 along the longest and the shortest edge of a voxel.
    float longDepth = 1, shortDepth = 1;
    /// All voxels are divided, because two fields do not add up: the volume is classified, or not linear.
    bool whole = false;
    bool hides = true;              ///< nothing cuts the volume open: what is deep in it is not seen
    std::vector<Int3> inside = {};  ///< voxels that eyes or lights are near

    bool operator==(const DetailSource&) const = default;
};

/// Two fields whose sum is the density.
struct DetailedDensity {
    FieldPointer coarse;  ///< on the voxels of the grid; empty where all of them are divided
    FieldPointer finer;   ///< on voxels of 1 / DetailSource::times of the edge, every so many of which lie on one voxel
};

/// Divides voxels as far as it shows; all of them, if that is about half of them. Throws
/// Error(memory) where that takes too many.
DetailedDensity detailedDensity(const DetailSource& source);

/// By how much voxels have to be divided so that two of them fit a feature of the noise's finest
/// octave: 1, 2 or 4. `edge`: of a voxel, in the noise's space.
int timesFor(const Noise& noise, double edge);

/// The detail that `volume`, a volume of `scene`, asks for, with the fields left out but for
/// `grid`; no value where it asks for none.
std::optional<DetailSource> detailOf(const Scene& scene, const SceneVolume& volume, const FieldPointer& grid);

/// Makes the detail of densities, and keeps it as long as the next frame needs it, too.
class DetailMaker {
  public:
    DetailedDensity of(DetailSource source);
    /// Forgets what was not asked for since the last call.
    void forgetUnused();

  private:
    struct Made {
        DetailSource source;
        DetailedDensity density;
        bool used = true;
    };
    std::vector<Made> m_all;
};

}  // namespace scrim
