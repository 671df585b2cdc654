// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/field_choice.h>

#include <array>
#include <cstddef>

namespace scrim {

std::string fieldName(const std::string& grid, const FieldChoice& choice) {
    if (choice.component == GridRequest::kScalar) return grid;
    constexpr std::array<const char*, 3> kColours{".r", ".g", ".b"}, kAxes{".x", ".y", ".z"};
    return grid + (choice.part == GridPart::whole ? kColours : kAxes).at(std::size_t(choice.component));
}

// Component `c` of a staggered grid lies half a voxel below the voxel's centre (openvdb/tools/Interpolation.h).
void placeOnFaces(SparseField& field, const FieldChoice& choice) {
    if (choice.component == GridRequest::kScalar || choice.part == GridPart::whole) return;
    Mat4 isFromFace(1.0);
    isFromFace[3][choice.component] = -0.5;
    field.wsFromIs = field.wsFromIs * isFromFace;
}

}  // namespace scrim
