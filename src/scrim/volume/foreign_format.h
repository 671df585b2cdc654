// SPDX-License-Identifier: Apache-2.0
// Volume formats that Scrim does not read, by the extensions of their files, with advice for messages.
#pragma once

#include <scrim/base/letter_case.h>

#include <array>
#include <string>
#include <string_view>

namespace scrim {

struct ForeignFormat {
    std::string_view ending;  ///< ".mnc", in lower case
    std::string_view what;    ///< "VTK ImageData"
    std::string_view advice;
};

/// The format of a file name; null where its ending is not in the table.
inline const ForeignFormat* foreignFormat(std::string_view path) {
    constexpr std::string_view kToNrrd = "convert it to NRRD or NIfTI (3D Slicer, ITK and ParaView do)";
    constexpr std::string_view kToVdb = "convert it to .vdb";
    static constexpr std::array<ForeignFormat, 7> kFormats{{
        {".vtk", "a legacy VTK file", kToNrrd},
        {".vtu", "a VTK unstructured grid", kToVdb},
        {".mgz", "a FreeSurfer volume", "convert it to NIfTI (mri_convert does)"},
        {".mnc", "MINC", "convert it to NIfTI (mnc2nii does)"},
        {".bgeo", "Houdini geometry", "save its volumes as .vdb"},
        {".f3d", "Field3D", kToVdb},
        {".h5", "HDF5", kToNrrd},
    }};
    const auto matches = [path](std::string_view ending) {
        return path.size() >= ending.size() && equalIgnoringCase(path.substr(path.size() - ending.size()), ending);
    };
    for (const ForeignFormat& format : kFormats)
        if (matches(format.ending)) return &format;
    return nullptr;
}

/// "is MINC (.mnc), which is not read; convert it to ..."
inline std::string textOf(const ForeignFormat& format) {
    return "is " + std::string(format.what) + " (" + std::string(format.ending) + "), which is not read; " +
           std::string(format.advice);
}

}  // namespace scrim
