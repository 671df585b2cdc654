// SPDX-License-Identifier: Apache-2.0
// The light on cells that shading shows.
#pragma once

#include <scrim/engine/cells/cell_field.h>
#include <scrim/engine/lamps/area_field.h>
#include <scrim/engine/lamps/lamp_field.h>
#include <scrim/engine/model/plan.h>

#include <memory>
#include <optional>
#include <vector>

namespace scrim {

/// What one volume shows of some lights, as CellField has light: the sum of its parts.
struct VolumeLight {
    std::shared_ptr<const CellField> field;  ///< null: there is none
    std::vector<std::shared_ptr<const LampField>> lamps = {};
    std::vector<std::shared_ptr<const AreaField>> areas = {};  ///< what `field` does not have of lights close by

    /// The light at a point.
    void sample(const Vec3& ws, Real (&rgb)[3]) const;
    /// The light at a tile of samples (see CellField::lookUp).
    void lookUp(const SamplePlane& plane, const SampleTile& samples, const Real* extinction, Real* const rgb[3],
                const Real* nearer = nullptr) const;
};

/// What volumes make of light on cells: media and surfaces that have scattered it evenly, and what
/// surfaces reflect by the two parts of Phong's model.
enum class ShownAs { scattered, diffuse, mirrored };

/// The light on cells that belongs to one output.
struct CellLight {
    std::optional<Output> output;                              ///< none: the beauty
    bool again = false;                                        ///< it has scattered before it arrives
    std::vector<std::shared_ptr<const VolumeLight>> ofVolume;  ///< for each volume of the scene; null: none
    ShownAs as = ShownAs::scattered;
};

}  // namespace scrim
