// SPDX-License-Identifier: Apache-2.0
// How steady the frames of a shot are: each is rendered as it is, and once more with finer dials,
// which stands for the truth.
#pragma once

#include <scrim/shot/shot.h>
#include <scrim/study/steadiness.h>

#include <optional>
#include <string>
#include <vector>

namespace scrim {

/// What was found of the frames so far.
struct ShotSteadinessResult {
    std::string quality;     ///< name of the preset
    double promised = 0;     ///< the largest excess of a layer that keeps its promise, relative
    Dials dials, converged;  ///< of the frames, and of the converged ones
    Int2 resolution{0};      ///< pixels that were rendered
    std::vector<int> frames;
    std::vector<LayerSteadiness> layers;  ///< the beauty, then the layers of colours that the scene asks for
    double seconds = 0;                   ///< time of all renders
    int threads = 0;

    /// The layers that show something and exceed what is promised.
    std::vector<std::string> restless() const;
};

class ShotSteadiness {
  public:
    struct Options {
        /// The picture is shrunk to this many pixels along its longer side, if it has more; 0: it is not.
        int mostPixels = 256;
    };

    /// Chooses the dials of the shot at `frame`. Missing files are errors, whatever `rendering`
    /// says. Throws Error: of kind usage where nothing in the scene changes from frame to frame, or
    /// where a tolerance chooses other dials for each frame; and as rendering does.
    ShotSteadiness(Shot& shot, int frame, const RenderOptions& rendering, const Options& options);

    /// Renders the next frame twice. Frames must follow one another. Throws as rendering does.
    void add(int frame, const ProgressSink& progress = {});

    ShotSteadinessResult result() const;

  private:
    std::vector<SteadyLayer> rendered(int frame, bool converged, RenderOptions options);

    Shot& m_shot;
    RenderOptions m_rendering;
    Int2 m_resolution{0};  // of the shrunk picture; 0: that of the scene
    ShotSteadinessResult m_result;
    std::optional<SteadinessMeter> m_meter;
};

/// Dials whose picture stands for the truth: texels, sheets and all cells half as large, twice as many directions of
/// scattered light, the finest levels of all grids. `lightCell`: the edge, in voxels, of the smallest cells of lights
/// that `dials` lead to; 0: none. What a dial's limits do not allow stays as fine as they allow.
Dials convergedDials(const Dials& dials, double lightCell);

}  // namespace scrim
