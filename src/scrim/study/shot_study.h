// SPDX-License-Identifier: Apache-2.0
// The study of one frame of a shot.
#pragma once

#include <scrim/shot/load_shot.h>
#include <scrim/shot/shot.h>
#include <scrim/study/study.h>

#include <map>
#include <utility>

namespace scrim {

class ShotStudy {
  public:
    /// Loads the frame with all its volumes. Missing files are errors, whatever the options say. Throws Error.
    ShotStudy(Shot& shot, int frame, const RenderOptions& options);

    /// Runs the study. `budget` is in seconds, 0: none. Throws as runStudy.
    Study run(double budget, const ProgressSink& progress);

  private:
    ViewScene viewWith(const Dials& dials, VolumesOf volumesOf);

    RenderOptions m_options;
    LoadedShot m_loaded;
    /// Keyed by lod, the only dial that changes which fields are assembled.
    std::map<std::pair<double, VolumesOf>, ViewScene> m_views;
};

}  // namespace scrim
