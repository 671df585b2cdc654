// SPDX-License-Identifier: Apache-2.0
// Reads NIfTI. The library reads and checks the header; samples are read like those of a raw file, with the same
// checks.
#include "scan.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <fstream>
#include <memory>

#include <fmt/format.h>
#include <nifti2_io.h>

namespace scan {
namespace {

struct Free {
    void operator()(nifti_image* image) const { nifti_image_free(image); }
};

SampleType typeOf(const nifti_image& image, const std::string& path) {
    switch (image.datatype) {
        case DT_UINT8:
            return SampleType::uint8;
        case DT_INT8:
            return SampleType::int8;
        case DT_UINT16:
            return SampleType::uint16;
        case DT_INT16:
            return SampleType::int16;
        case DT_UINT32:
            return SampleType::uint32;
        case DT_INT32:
            return SampleType::int32;
        case DT_FLOAT32:
            return SampleType::float32;
        case DT_FLOAT64:
            return SampleType::float64;
        default:
            refuse(path, fmt::format("holds {} samples, expected whole or real numbers of up to 32 bits or double",
                                     nifti_datatype_to_string(image.datatype)));
    }
}

/// Sets the place of the samples: the standard one (sform) if there is one, else that of the scanner (qform), else
/// spacings along the axes.
void place(const nifti_image& image, Scan& scan) {
    const nifti_dmat44& m = image.sform_code > 0 ? image.sto_xyz : image.qto_xyz;
    const bool placed = image.sform_code > 0 || image.qform_code > 0;
    const double spacing[3] = {image.dx, image.dy, image.dz};
    for (int column = 0; column < 3; ++column)
        for (int row = 0; row < 3; ++row)
            scan.axes[column][row] = placed                              ? m.m[row][column]
                                     : row == column && spacing[row] > 0 ? spacing[row]
                                                                         : row == column;
    if (!placed) return;
    scan.origin = {m.m[0][3], m.m[1][3], m.m[2][3]};
    scan.space = "right-anterior-superior";
}

/// Refuses a header without NIfTI's mark, for which the library would look up the sides of the head in the spirit of
/// SPM.
void checkPair(const std::string& path) {
    constexpr std::size_t kMarkAt = 344, kMarkAtOf2 = 4;
    std::string start(kMarkAt + 4, '\0');
    std::ifstream file(path, std::ios::binary);
    file.read(start.data(), static_cast<std::streamsize>(start.size()));
    const bool is1 = file.gcount() == static_cast<std::streamsize>(start.size()) && start.substr(kMarkAt, 2) == "ni";
    if (!is1 && start.substr(kMarkAtOf2, 2) != "ni")
        refuse(path,
               "is no NIfTI header; if it is one of Analyze 7.5, which does not say where left is, convert it to "
               "NIfTI (fslchfiletype NIFTI, or 3D Slicer)");
}

}  // namespace

Scan readNifti(const std::string& path, std::int64_t component) {
    fileBytes(path);
    nifti_set_debug_level(0);  // the library would print messages
    if (lowerCase(path).ends_with(".hdr")) checkPair(path);
    const std::unique_ptr<nifti_image, Free> image(nifti_image_read(path.c_str(), 0));
    if (!image) refuse(path, "is not a NIfTI file, or its header is damaged");
    Size size{image->nx, std::max<std::int64_t>(image->ny, 1), std::max<std::int64_t>(image->nz, 1)};
    const std::int64_t samples = sampleCount(size, path), all = static_cast<std::int64_t>(image->nvox);
    checkComponent(component, all / samples, path);
    if (all % samples != 0) refuse(path, "its header is damaged");

    Scan scan;
    RawLayout layout;
    layout.size = scan.size = size;
    layout.type = typeOf(*image, path);
    scan.type = nameOf(layout.type);
    const bool swapped = image->byteorder != nifti_short_order();
    layout.bigEndian = swapped == (std::endian::native == std::endian::little);
    layout.header = image->iname_offset;
    layout.exact = false;
    if (layout.header < 0) refuse(path, "the offset of its samples is negative");
    layout.header += std::max<std::int64_t>(component, 0) * samples * bytesOf(layout.type);
    place(*image, scan);
    scan.values = readRaw(image->iname, layout);
    if (image->scl_slope != 0 && std::isfinite(image->scl_slope) && std::isfinite(image->scl_inter))
        for (float& v : scan.values) v = static_cast<float>(v * image->scl_slope + image->scl_inter);
    return scan;
}

}  // namespace scan
