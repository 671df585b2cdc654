// SPDX-License-Identifier: Apache-2.0
// What passes through the cells: lights as sources of rays, and the phase functions by which
// volumes send their light towards the eye.
#pragma once

#include <scrim/scene/phase_over_caps.h>
#include <scrim/scene/view_scene.h>

#include <cstddef>
#include <memory>
#include <optional>
#include <vector>

namespace scrim {

/// Sub-lights as sources of rays, and the light that they send if it has one colour.
struct Sources {
    std::vector<Light> lights;
    std::vector<int> owners;         ///< for each the index of the light that it is a part of, ascending
    std::vector<double> parts = {};  ///< SubLights::parts of each; empty: none stands for others
    std::vector<int> ofScene = {};   ///< for each owner its index into the lights of the scene
    Rgb tint{1};
    std::size_t colours = 1;  ///< 3 if the lights differ in colour
    bool lamp = false;        ///< points of a lamp, of which the transmittance alone is asked
    bool attenuated = true;   ///< by volumes
    bool blocked = false;     ///< by solids
};

/// A lamp's cells keep its transmittance: its `count` points stand alone, each shines 4 pi over
/// their number, and all that arrives is scattered to all sides alike.
Sources sourcesOfLamp(const Light& light, int count);

/// These lights of the scene, which the same volumes and solids hold back; either others or one lamp (isLampOnCells).
/// All count as attenuated: volumes that `scene` does not have may hold them back, too.
Sources sourcesOf(const ViewScene& scene, const std::vector<int>& lights);
/// The same for surfaces, which ask for the direction of each source: lamps are points that shine. Those of a sphere of
/// radius r send (1 + r^2 / 4 d^2) times the light of its middle to a place at distance d, as the sphere does.
Sources sourcesForSurfaces(const ViewScene& scene, const std::vector<int>& lights);

/// What stands for a phase function where the sub-lights of a light are wider than its lobes. A sky
/// is smooth: a few rays see what a peak shows of it (addPeaks). A surface has edges, which the
/// peak blurs, and so do means over what its points stand for.
struct WidePhase {
    std::optional<CutPhase> ofSky;                     ///< without its peaks
    PhaseRow ofSun{};                                  ///< the mean over what one of a sun's directions stands for
    std::shared_ptr<const PhaseOverCaps> ofSurface{};  ///< of all surfaces but meshes
};

/// For each light that the sources are parts of; no other light changes it.
std::vector<WidePhase> widePhases(const ViewScene& scene, const Sources& sources, const Phase& phase);

}  // namespace scrim
