// SPDX-License-Identifier: Apache-2.0
// What passes through the cells of a level: of which lights, by which octaves of a medium, into which fields.
#pragma once

#include <scrim/engine/cells/cell_levels.h>
#include <scrim/engine/lamps/cell_light.h>
#include <scrim/engine/passes/lit_surfaces.h>
#include <scrim/engine/passes/sources.h>

#include <cstddef>
#include <limits>
#include <memory>
#include <vector>

namespace scrim {

/// How much larger the cells of further octaves may be, by their edge.
inline constexpr int kLargerCells = 2;

/// Octaves of media (scene/medium.h) that have cells of one size. To the light of further octaves the medium is
/// thinner: cells that are larger in proportion are as exact, as long as they show the volumes' features.
struct OctaveCells {
    int larger = 1;  ///< than the cells of the first octave: the ratio of their edges
    double above = -1, upTo = std::numeric_limits<double>::infinity();  ///< what is between: factors on extinction

    bool have(const Octave& octave) const { return octave.extinction > above && octave.extinction <= upTo; }
};

/// All sizes that a level's octaves have for these lights, smallest first; `edge`: that of the
/// first octave, world units. Solids and surfaces, whose shadows have edges, leave one for all.
std::vector<OctaveCells> octaveCells(const LevelScene& level, const std::vector<int>& lights, double edge);

/// What one class of volumes shows of some lights by one octave: a field, and the passes that fill it.
struct LightJob {
    int first;  ///< index of the first light; the same volumes hold back all
    Sources sources;
    Octave octave;
    std::shared_ptr<CellField> field;           ///< of a lamp: what it shares with others; null: it is alone
    std::shared_ptr<LampField> lamp = nullptr;  ///< of the only light, if it is a lamp
    std::size_t knot = 0;                       ///< of the lamp's knots, the one whose transmittance is kept
    std::shared_ptr<CellField> open = nullptr;  ///< of a lamp: what solids let through; null: there are none
    std::size_t media = 0;                      ///< index of what holds the light back
    std::vector<WidePhase> wide = {};           ///< for each light of `sources`; empty: of a lamp, or of surfaces
    int surface = -1;                           ///< the classified volume that reflects the light; -1: media scatter it
    std::shared_ptr<CellField> mirrored = {};   ///< its highlights, if it has any; `field` has its diffuse part
    /// For each light of `sources` what keeps it where it is close to the cells; null: it is not, or `field` does.
    std::vector<std::shared_ptr<AreaField>> areas = {};
};

/// The jobs of these lights for those octaves and, with cells of the usual size, for surfaces. The fields become those
/// of lights that are added to `all`. `grey`: extinction is the same in all colours.
std::vector<LightJob> lightJobs(const LevelScene& level, const std::vector<int>& lights, const OctaveCells& octaves,
                                const std::shared_ptr<const CellGrid>& grid, const LitSurfaces& surfaces, bool grey,
                                std::vector<CellLight>& all);

/// What the fields of the jobs keep.
std::size_t bytesOf(const std::vector<LightJob>& jobs);

}  // namespace scrim
