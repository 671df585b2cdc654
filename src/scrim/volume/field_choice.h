// SPDX-License-Identifier: Apache-2.0
// Internal: what of a grid becomes a field.
#pragma once

#include <scrim/volume/grid_request.h>
#include <scrim/volume/sparse_field.h>

#include <string>

namespace scrim {

struct FieldChoice {
    int component = GridRequest::kScalar;  ///< of a vec3 grid; kScalar for a scalar grid
    GridPart part = GridPart::whole;       ///< `positive` and `negative` are those of a velocity
    /// The number in the field that stands for `value`. NaN and infinity pass unchanged, so that cleaning finds them.
    float operator()(float value) const {
        if (part == GridPart::whole) return value;
        const float v = part == GridPart::negative ? -value : value;
        return v < 0 ? 0.0f : v;
    }
    /// The same for the value of a voxel.
    float of(float value) const { return (*this)(value); }
    template <typename Vector>
    float of(const Vector& value) const {
        return (*this)(value[component]);
    }
};

/// The name of that field of the grid called `grid`.
std::string fieldName(const std::string& grid, const FieldChoice& choice);

/// Moves the component of a velocity on a staggered grid to the faces of voxels; leaves every other field unchanged.
void placeOnFaces(SparseField& field, const FieldChoice& choice);

}  // namespace scrim
