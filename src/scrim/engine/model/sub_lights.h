// SPDX-License-Identifier: Apache-2.0
// The lights of a plan: those of the scene, and for an extended one a sum of lights that sweeps can handle: points of a
// surface, directions of the sun's disk or of the sky. Sweeps see only these; their light belongs to their owner.
//
// A sum of N sub-lights converges to the true light, which a blurred single shadow buffer does not. As long as N stays
// the same, their pattern is fixed to the light and is the same in all frames. There are two exceptions, which depend
// on the bounds of the volumes, too. Parts of a mesh are left out where no volume is in front of them, and shine as
// brightly as the whole mesh does at the volumes. A sphere is points where it is far from the volumes, else elements.
#pragma once

#include <scrim/engine/model/served_lights.h>
#include <scrim/geometry/bounds.h>
#include <scrim/scene/view_scene.h>

#include <vector>

namespace scrim {

/// The number of a light of the plan. It is not the number of a light of the scene, which is an `int`.
enum class PlanLight : int {};

struct SubLights {
    std::vector<Light> lights;  ///< at least one for each light of the scene; none is extended
    std::vector<int> owners;    ///< for each of them the index into the lights of the scene, ascending
    std::vector<bool> suns;     ///< for each of them whether it belongs to a sun in the picture of a sky
    /// For each of them what it stands for: of a sun or sky the solid angle, of a surface the area
    /// (world units squared); 0: it is a light of the scene itself.
    std::vector<double> parts;

    /// For each volume of the scene, which of `lights` buffers bring to it; empty: all of them.
    std::vector<std::vector<bool>> lit;

    const Light& of(PlanLight i) const { return lights[std::size_t(i)]; }
    /// The scene's light that light `i` belongs to.
    int ownerOf(PlanLight i) const { return owners[std::size_t(i)]; }
    /// The number of lights that represent light `owner` of the scene.
    int countOf(int owner) const;
    /// What light `i` stands for.
    double partOf(PlanLight i) const { return parts[std::size_t(i)]; }
};

/// The half angle (radians) of a cap that has this solid angle.
double capOf(double solidAngle);
/// The half angle, up to pi/2, under which a place in the box `ws` sees at most what a sub-light stands for.
double widestCap(const Light& subLight, double part, const Bounds& ws);

/// The most sub-lights that the dial light_error requests for one light.
inline constexpr int kMostSubLights = 1024;

/// The number of sub-lights for the scene's `light`: its `samples`, or as many as the dial light_error needs.
int subLightCount(const ViewScene& scene, const Light& light);

/// The number of points or directions that represent `light` on cells, which blur the steps between them: fewer.
int pointsOnCells(const ViewScene& scene, const Light& light);

/// True if on cells `light` counts as a lamp, all of whose light comes from about one direction: a
/// point, or a sphere that is small beside the volumes.
bool isLampOnCells(const ViewScene& scene, const Light& light);

/// True if the lamps on cells (isLampOnCells) share the cells that keep their light; only the light
/// near a lamp is then kept on cells of its own. They share cells if there are more than four of
/// them, since own cells are more precise; if no layer wants the light of one of them; and if no
/// solid casts a shadow, since its edges near a lamp are too fine for shared cells.
bool lampsShareCells(const ViewScene& scene);

/// True if two lights differ in brightness only.
bool sameColour(const Rgb& a, const Rgb& b);

/// `count` points whose mean transmittance is that of a lamp on cells. Those of a sphere have the
/// same spread across any line of sight as its disk: a quarter of the radius squared.
std::vector<Vec3> pointsOfLamp(const Light& light, int count);

/// The directions of the suns in the picture of a dome, which cast shadows as sharp as other suns do.
std::vector<Light> sunsOfSky(const ViewScene& scene, const Light& dome);

/// All lights of the scene, with the extended ones replaced by their sub-lights. Those that are not in sweeps become
/// black, or suns if they are skies with suns. Slides must be loaded. The result depends only on the lights, the dial
/// light_error, who serves the lights, and the volumes' bounds.
SubLights subLights(const ViewScene& scene, const std::vector<ServedLight>& served);
/// The same with no light on cells.
SubLights subLights(const ViewScene& scene);

enum class Skies {
    parted,  ///< into suns where buffers serve them; skies that enter at a border leave only their suns
    whole    ///< as they are, so that solves for scattered light have them
};

/// The scene with each extended light replaced by about `count` lights, for a rough look at it.
/// Pictures need not be loaded.
ViewScene withFewSubLights(const ViewScene& scene, int count, Skies skies = Skies::parted);

/// True if a surface with a spread is a sum of beams, parallel light through a window of its shape:
/// its cone is smaller than what the surface fills of the sky at the volumes, which are all in
/// front of it. Points, each with its cone, would show as dots there.
bool shinesInBeams(const ViewScene& scene, const Light& light);

}  // namespace scrim
