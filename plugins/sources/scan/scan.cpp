// SPDX-License-Identifier: Apache-2.0
// Volume source `scan`: measured or simulated volumes on a dense lattice (CT, MR, electron densities) as sparse grids.
//
//     scrim make scan file=bonsai_256.nrrd halve=z threshold=30 window=0,255 -o bonsai.vdb
//     scrim make scan file=teddybear.raw size=128,128,62 spacing=2.8,2.8,5 threshold=20 -o teddy.vdb
//
// The extension of the file decides its format:
//   .nrrd .nhdr   NRRD, with its samples inside or in one file of the same folder, in any encoding that Teem knows
//   .nii .nii.gz  NIfTI-1 or -2
//   .hdr          NIfTI in two files; the other one ends in .img
//   .mha .mhd     MetaImage, with its samples inside or in another file of the same folder or below, deflated or not
//   .npy          NumPy: an array (nx, ny, nz), as in scrim.Field
//   .mrc .map     MRC and CCP4 maps; a world unit is an angstrom
//   .ccp4 .rec    the same
//   .vti          VTK image data, as text or bytes, deflated by zlib or not
//   .tif .tiff    TIFF: a stack of pages; where the name has a '*', which stands for any characters, all files of such
//                 names, a page each, sorted by the number in their names
//   .dcm .dicom   DICOM: the series in the file's folder that the file belongs to, sorted by the slices' positions
//   a folder      DICOM: the only series in it; or TIFF: all files in it, as above
//   others        raw samples, x fastest; gzipped where the name ends in .gz
// A header states size, type, byte order and place itself, so the parameters marked raw must not be given then. Its
// place is kept: NRRD's space directions and origin (or spacings), NIfTI's sform, else its qform, else its spacings, in
// the unit and handedness of the file (NIfTI: millimetres, x to the right, y to the front, z up; DICOM: millimetres, x
// to the left, y to the back, z up; values of both by slope and intercept). A scene's `transform` turns it.
//
// Parameters:
//   file         path; in a scene it is relative to the scene, with ${NAME} and frames as in other paths
//   size         raw: samples along x, y, z
//   type         raw: uint8, int8, uint16, int16, uint32, int32, float, double, uint64, int64 or half
//   endian       raw: little or big
//   header       raw: bytes before the first sample
//   component    NRRD and NIfTI of four dimensions, TIFF of several channels and frames: which volume, from 0 on; -1:
//                the file must hold one only
//   space        LPS (x to the patient's left, y to the back, z up: DICOM's) or RAS (right, front, up: NIfTI's): turns
//                what the file places in the other one, so that scans of one patient lie together; file: as the file
//                has it
//   spacing      distance between samples along x, y, z, in world units; 0, 0, 0: that of the file, or 1
//   orientation  true: axes as the file turns them; false: along the world's, with the file's spacings
//   center       true: moves the middle of the volume to the origin; false: keeps it where the file says
//   crop_from    first sample that is kept, along x, y, z
//   crop_to      first sample after those that are kept; 0, 0, 0: up to the end
//   halve        axes, such as z or xyz, along which each two samples become their mean
//   rescale      "slope, intercept": samples become slope * sample + intercept, before all that follows; for files that
//                hold no Hounsfield units but whole numbers that stand for them
//   threshold    samples up to this (as the file has them) are empty
//   window       "lo, hi": these become 0 and 1, values beyond are clamped; "full": least and largest sample; empty:
//                no window
//   scale        factor that is applied last
//   units        scan: values stay as the scan has them (Hounsfield, say), for a transfer function in its units; values
//                beyond a window are clamped, and values that are not above its begin are empty
//                hounsfield: the same for Hounsfield units, plus 1024, so that those below 0 can be seen, as the
//                windows of [volume.classified] expect them; a threshold of 0 is then that of the scale, -1024
//   describe     true: makes two small grids in place of the samples, a histogram of their values and the two ends of
//                the lattice (describe.h)
//
// The grid is called "density". Files of colours (NRRD of kind RGB-color, or whose first axis has 3 samples; NumPy
// arrays (nx, ny, nz, 3); TIFF in RGB) make it of their luma, in the units of the file, and "color.r", "color.g",
// "color.b" beside it, linear and from 0 to 1: `albedo = { grid = "color" }` takes these. Values that are not above 0
// are empty: values below 0 can be seen through a window only. Files that are shorter or (raw) longer than declared,
// sizes beyond 2^31 samples, and compressed files too small to hold what they declare are refused before anything is
// allocated for them.
#include "describe.h"
#include "edit.h"
#include "scan.h"
#include "slice_files.h"

#include <scrim/volume/scrim_source.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <exception>
#include <new>
#include <functional>
#include <optional>
#include <string_view>

#include <fmt/format.h>
#include <glm/geometric.hpp>

namespace scan {
namespace {

enum {
    kFile,
    kSize,
    kType,
    kEndian,
    kHeader,
    kComponent,
    kSpace,
    kSpacing,
    kOrientation,
    kCenter,
    kCropFrom,
    kCropTo,
    kHalve,
    kRescale,
    kThreshold,
    kWindow,
    kScale,
    kUnits,
    kDescribe,
    kCount
};
// 'auto' means what a header says, and for raw files the first of the other words.
constexpr scrim_parameter kParameters[kCount] = {
    {"file", SCRIM_STRING, "", 0, 0, nullptr,
     "path of a .nrrd, .nhdr, .nii, .nii.gz, .hdr, .mha, .mhd, .npy, .mrc, .vti, .tif, .dcm or raw file, or of a "
     "folder of DICOM or TIFF slices"},
    {"size", SCRIM_VEC3, "0, 0, 0", 0, 1e6, nullptr, "raw: samples along x, y, z"},
    {"type", SCRIM_STRING, "auto", 0, 0, "auto|uint8|int8|uint16|int16|uint32|int32|float|double|uint64|int64|half",
     "raw: type of samples; auto: uint8"},
    {"endian", SCRIM_STRING, "auto", 0, 0, "auto|little|big", "raw: order of bytes; auto: little"},
    {"header", SCRIM_INTEGER, "0", 0, 1e12, nullptr, "raw: bytes before the first sample"},
    {"component", SCRIM_INTEGER, "-1", -1, 1e9, nullptr,
     "which of several volumes in a file, from 0 on; -1: the only one"},
    {"space", SCRIM_STRING, "file", 0, 0, "file|LPS|RAS",
     "directions of x, y and z: the file's, or those of a patient"},
    {"spacing", SCRIM_VEC3, "0, 0, 0", 0, 1e9, nullptr, "between samples, in world units; 0, 0, 0: the file's, or 1"},
    {"orientation", SCRIM_BOOL, "true", 0, 0, nullptr, "use the file's rotation and position"},
    {"center", SCRIM_BOOL, "false", 0, 0, nullptr, "move the centre to the origin"},
    {"crop_from", SCRIM_VEC3, "0, 0, 0", 0, 1e6, nullptr, "first sample that is kept"},
    {"crop_to", SCRIM_VEC3, "0, 0, 0", 0, 1e6, nullptr,
     "end of the samples that are kept, exclusive; 0, 0, 0: up to the end"},
    {"halve", SCRIM_STRING, "", 0, 0, nullptr, "axes along which each two samples become one: z, xy, xyz, ..."},
    {"rescale", SCRIM_STRING, "", 0, 0, nullptr, "'slope, intercept' that make Hounsfield units, say, of samples"},
    {"threshold", SCRIM_NUMBER, "0", 0, 0, nullptr, "samples up to this value are empty"},
    {"window", SCRIM_STRING, "", 0, 0, nullptr, "'lo, hi' that become 0 and 1, or 'full'; empty: values as they are"},
    {"scale", SCRIM_NUMBER, "1", 0, 1e30, nullptr, "factor on values"},
    {"units", SCRIM_STRING, "window", 0, 0, "window|scan|hounsfield",
     "window: values become 0 to 1; scan: they stay as they are; hounsfield: they get 1024 added, for windows"},
    {"describe", SCRIM_BOOL, "false", 0, 0, nullptr, "a histogram and the lattice's ends in place of the samples"},
};

glm::dvec3 vec3(const scrim_value& value) {
    return {value.number[0], value.number[1], value.number[2]};
}

bool isZero(const scrim_value& value) {
    return vec3(value) == glm::dvec3(0);
}

Size wholeNumbers(const scrim_value& value, const char* name) {
    Size out{};
    for (std::size_t k = 0; k < 3; ++k) {
        if (value.number[k] != std::floor(value.number[k]))
            throw std::runtime_error(fmt::format("'{}' is {}, {}, {}, expected whole numbers", name, value.number[0],
                                                 value.number[1], value.number[2]));
        out[k] = static_cast<std::int64_t>(value.number[k]);
    }
    return out;
}

Scan readRawFile(const std::string& path, const scrim_value* values) {
    if (isZero(values[kSize])) refuse(path, "a raw file has no header with its size: give 'size', such as 128,128,64");
    RawLayout layout;
    layout.size = wholeNumbers(values[kSize], "size");
    const std::string type = values[kType].text;
    for (int i = 0; i < kSampleTypes; ++i)
        if (const auto t = static_cast<SampleType>(i); nameOf(t) == type) layout.type = t;
    layout.bigEndian = std::string_view(values[kEndian].text) == "big";
    layout.header = values[kHeader].integer;
    Scan scan;
    scan.type = nameOf(layout.type);
    scan.size = layout.size;
    scan.values = readRaw(path, layout);
    return scan;
}

Scan readFile(const scrim_value* values) {
    const std::string path = values[kFile].text, name = lowerCase(path);
    if (path.empty())
        throw std::runtime_error(
            "expected 'file', a .nrrd, .nhdr, .nii, .nii.gz, .hdr, .mha, .mhd, .npy, .mrc, .vti, .tif, .dcm or raw "
            "file, "
            "or a folder");
    const bool nrrd = name.ends_with(".nrrd") || name.ends_with(".nhdr");
    const bool nifti = name.ends_with(".nii") || name.ends_with(".nii.gz") || name.ends_with(".hdr");
    using Reader = std::function<Scan(const std::string&)>;
    const std::int64_t component = values[kComponent].integer;
    Reader reader;
    if (nrrd) reader = [&](const std::string& file) { return readNrrd(file, component); };
    if (nifti) reader = [&](const std::string& file) { return readNifti(file, component); };
    if (name.ends_with(".mha") || name.ends_with(".mhd")) reader = readMetaImage;
    if (name.ends_with(".npy")) reader = readNumpy;
    if (name.ends_with(".vti")) reader = readVti;
    for (const char* ending : {".mrc", ".map", ".ccp4", ".rec"})
        if (name.ends_with(ending)) reader = readMrc;
    const bool isMany = isFolder(path), isNamed = isPattern(path), isTiff = isTiffFile(path) && !isMany && !isNamed;
    if (isTiff) reader = [&](const std::string& file) { return readTiff(file, component); };
    if (isDicomFile(path) || isMany) reader = readDicom;
    if (isNamed || (isMany && holdsTiffSlices(path))) reader = readTiffSlices;
    if (component >= 0 && !nrrd && !nifti && !isTiff)
        refuse(path, "'component' is for NRRD, NIfTI and TIFF files only");
    if (!reader) return readRawFile(path, values);
    const std::string_view automatic = "auto";
    const char* given = !isZero(values[kSize])              ? "size"
                        : values[kType].text != automatic   ? "type"
                        : values[kEndian].text != automatic ? "endian"
                        : values[kHeader].integer != 0      ? "header"
                                                            : nullptr;
    if (given != nullptr) refuse(path, fmt::format("has its own '{}'; that parameter is for raw files only", given));
    return reader(path);
}

void place(Scan& scan, const scrim_value* values) {
    for (int k = 0; k < 3; ++k) {
        double step = glm::length(scan.axes[k]);
        if (!(step > 0) || !std::isfinite(step))
            throw std::runtime_error("the file's axes are damaged: give 'orientation=false' and 'spacing'");
        const double wanted = isZero(values[kSpacing]) ? step : values[kSpacing].number[k];
        if (!(wanted > 0)) throw std::runtime_error("'spacing' has a 0, expected three numbers above 0");
        if (values[kOrientation].boolean != 0) {
            scan.axes[k] *= wanted / step;
        } else {
            scan.axes[k] = glm::dvec3(0);
            scan.axes[k][k] = wanted;
        }
    }
    if (values[kOrientation].boolean == 0) scan.origin = glm::dvec3(0);
}

/// Turns the scan into a patient's space: where a direction is the opposite one, its coordinates change their sign.
void turn(Scan& scan, const std::string& space) {
    if (space == "file") return;
    constexpr std::string_view kOpposites = "rlapsi";  // in pairs
    std::string letters;
    for (std::size_t at = 0; at < scan.space.size(); at = scan.space.find('-', at) + 1) {
        letters += scan.space[at];
        if (scan.space.find('-', at) == std::string::npos) break;
    }
    const std::string wanted = lowerCase(space);
    for (int k = 0; k < 3; ++k) {
        const auto i = static_cast<std::size_t>(k);
        const std::size_t have = letters.size() == 3 ? kOpposites.find(letters[i]) : kOpposites.npos;
        if (have == kOpposites.npos || have / 2 != i)
            throw std::runtime_error(
                fmt::format("'space' is {}, but the file does not say where left and front are", space));
        if (letters[i] == wanted[i]) continue;
        for (int axis = 0; axis < 3; ++axis) scan.axes[axis][k] = -scan.axes[axis][k];
        scan.origin[k] = -scan.origin[k];
    }
    scan.space = space == "LPS" ? "left-posterior-superior" : "right-anterior-superior";
}

Scan edited(Scan scan, const scrim_value* values) {
    const Size from = wholeNumbers(values[kCropFrom], "crop_from");
    const Size to = isZero(values[kCropTo]) ? scan.size : wholeNumbers(values[kCropTo], "crop_to");
    for (std::size_t k = 0; k < 3; ++k)
        if (from[k] >= to[k] || to[k] > scan.size[k])
            throw std::runtime_error(
                fmt::format("a crop from {}, {}, {} to {}, {}, {} is empty or outside of the {} samples", from[0],
                            from[1], from[2], to[0], to[1], to[2], textOf(scan.size)));
    if (from != Size{} || to != scan.size) scan = cropped(scan, from, to);

    const std::string_view axes = values[kHalve].text;
    for (std::size_t i = 0; i < axes.size(); ++i)
        if (axes[i] < 'x' || axes[i] > 'z' || axes.find(axes[i], i + 1) != std::string_view::npos)
            throw std::runtime_error(fmt::format("'halve' is '{}', expected some of x, y and z, each once", axes));
    for (const char axis : axes) scan = halved(scan, axis - 'x');
    return scan;
}

/// The two numbers of "a, b"; none where the text is anything else.
std::optional<std::array<double, 2>> pairIn(std::string text) {
    std::erase(text, ' ');
    std::array<double, 2> pair{};
    const char *end = text.data() + text.size(), *at = text.data();
    const auto first = std::from_chars(at, end, pair[0]);
    if (first.ec != std::errc() || first.ptr == end || *first.ptr != ',') return {};
    const auto second = std::from_chars(first.ptr + 1, end, pair[1]);
    if (second.ec != std::errc() || second.ptr != end || !std::isfinite(pair[0]) || !std::isfinite(pair[1])) return {};
    return pair;
}

void rescale(Scan& scan, const std::string& text) {
    if (text.empty()) return;
    const auto line = pairIn(text);
    if (!line || (*line)[0] == 0)
        throw std::runtime_error(
            fmt::format("'rescale' is '{}', expected a slope that is not 0 and an intercept, such "
                        "as 1, -1024",
                        text.substr(0, 80)));
    for (float& v : scan.values) v = static_cast<float>((*line)[0] * double(v) + (*line)[1]);
}

Mapping mappingOf(const Scan& scan, const scrim_value* values) {
    constexpr double kHounsfieldZero = 1024;
    Mapping mapping;
    mapping.threshold = values[kThreshold].number[0];
    mapping.scale = values[kScale].number[0];
    const std::string_view units = values[kUnits].text;
    mapping.keepsUnits = units != "window";
    if (units == "hounsfield") {
        mapping.offset = kHounsfieldZero;
        if (mapping.threshold == 0) mapping.threshold = -kHounsfieldZero;
    }
    std::string text = values[kWindow].text;
    if (text.empty()) return mapping;
    std::array<double, 2> window{};
    if (text == "full") {
        window = range(scan);
        if (!(window[0] < window[1])) throw std::runtime_error("'window' is 'full', but all samples are equal");
    } else {
        const auto pair = pairIn(text);
        if (pair) window = *pair;
        if (!pair || !(window[0] < window[1]) || !std::isfinite(window[1] - window[0]))
            throw std::runtime_error(
                fmt::format("'window' is '{}', expected two ascending numbers such as 0, 255, or 'full'",
                            std::string_view(values[kWindow].text).substr(0, 80)));
    }
    if (mapping.keepsUnits && window[0] < -mapping.offset)
        throw std::runtime_error(fmt::format(
            "'window' begins at {}, but units={} keeps values as they are, and values below {:g} are empty; "
            "without it a window maps them to 0 to 1",
            window[0], units, 0 - mapping.offset));
    mapping.window = window;
    return mapping;
}

void moveToOrigin(Scan& scan) {
    scan.origin = -0.5 * (scan.axes * glm::dvec3(scan.size[0] - 1, scan.size[1] - 1, scan.size[2] - 1));
}

/// True if there is density in the samples `from` .. `from` + 7, or within one sample of them.
bool hasDensityNear(const Scan& scan, const Size& from) {
    const auto begin = [&](std::size_t k) { return std::max<std::int64_t>(from[k] - 1, 0); };
    const auto end = [&](std::size_t k) { return std::min(from[k] + 9, scan.size[k]); };
    for (std::int64_t z = begin(2); z < end(2); ++z)
        for (std::int64_t y = begin(1); y < end(1); ++y)
            for (std::int64_t x = begin(0); x < end(0); ++x)
                if (scan.values[scan.indexOf(x, y, z)] != 0) return true;
    return false;
}

/// Adds the block of a grid that begins at sample `from`, unless it is empty.
int addBlock(const scrim_host* host, int grid, const Scan& scan, const std::vector<float>& all, const Size& from) {
    std::array<float, 512> values{};
    bool any = false;
    for (std::int64_t z = from[2]; z < std::min(from[2] + 8, scan.size[2]); ++z)
        for (std::int64_t y = from[1]; y < std::min(from[1] + 8, scan.size[1]); ++y)
            for (std::int64_t x = from[0]; x < std::min(from[0] + 8, scan.size[0]); ++x) {
                const float v = all[scan.indexOf(x, y, z)];
                values[static_cast<std::size_t>(((x - from[0]) * 8 + y - from[1]) * 8 + z - from[2])] = v;
                any = any || v != 0;
            }
    if (!any) return 0;
    const std::int32_t origin[3] = {static_cast<std::int32_t>(from[0]), static_cast<std::int32_t>(from[1]),
                                    static_cast<std::int32_t>(from[2])};
    const bool constant = std::all_of(values.begin(), values.end(), [&](float v) { return v == values[0]; });
    return constant ? host->add_tile(host, grid, origin, 8, values[0])
                    : host->add_block(host, grid, origin, values.data());
}

/// The grid "density", and of colours "color.r", "color.g" and "color.b" where there is density, or next to it: a
/// colour is interpolated from all voxels around.
int emit(const scrim_host* host, const Scan& scan) {
    constexpr std::array<const char*, 4> kNames{"density", "color.r", "color.g", "color.b"};
    const std::size_t grids = scan.colours[0].empty() ? 1 : 4;
    double worldFromIndex[16];
    worldFromIndexOf(scan, worldFromIndex);
    for (std::size_t n = 0; n < grids; ++n) {
        const int grid = host->add_grid(host, kNames[n], worldFromIndex);
        if (grid < 0) return grid;
        const std::vector<float>& all = n == 0 ? scan.values : scan.colours[n - 1];
        for (std::int64_t z = 0; z < scan.size[2]; z += 8) {
            for (std::int64_t y = 0; y < scan.size[1]; y += 8)
                for (std::int64_t x = 0; x < scan.size[0]; x += 8)
                    if (n == 0 || hasDensityNear(scan, {x, y, z}))
                        if (const int error = addBlock(host, grid, scan, all, {x, y, z}); error != 0) return error;
            const double done = double(n) + std::min(double(z + 8) / double(scan.size[2]), 1.0);
            if (const int stop = host->progress(host, done / double(grids)); stop != 0) return stop;
        }
    }
    return 0;
}

int generate(const scrim_host* host, const scrim_value* values) {
    try {
        Scan scan = readFile(values);
        if (!scan.isSpaced && isZero(values[kSpacing]))
            scan.notes.push_back(fmt::format("{}: does not say how far its samples are apart: 1; 'spacing' sets it",
                                             values[kFile].text));
        for (const std::string& note : scan.notes) host->warn(host, note.c_str());
        turn(scan, values[kSpace].text);
        rescale(scan, values[kRescale].text);
        place(scan, values);
        scan = edited(std::move(scan), values);
        if (values[kCenter].boolean != 0) moveToOrigin(scan);
        if (values[kDescribe].boolean != 0) return describe(host, scan);
        map(scan, mappingOf(scan, values));
        return emit(host, scan);
    } catch (const std::bad_alloc&) {
        host->fail(host, "not enough memory for the scan");
    } catch (const std::exception& error) {
        host->fail(host, error.what());
    } catch (...) {
        host->fail(host, "unknown exception");
    }
    return 1;
}

constexpr scrim_source kSource = {SCRIM_SOURCE_ABI,
                                  sizeof(scrim_source),
                                  "scan",
                                  "scans and other dense volumes: NRRD, NIfTI, DICOM, TIFF or raw samples",
                                  kParameters,
                                  kCount,
                                  sizeof(scrim_parameter),
                                  generate};

}  // namespace
}  // namespace scan

extern "C" SCRIM_SOURCE_EXPORT const scrim_source* scrim_source_v1(void) {
    return &scan::kSource;
}
