// SPDX-License-Identifier: Apache-2.0
// A scan in memory, independent of its file format, and what all readers share: sample types, limits, and the form of
// errors.
#pragma once

#include <array>
#include <cstdint>
#include <stdexcept>
#include <string>
#include <vector>

#include <glm/mat3x3.hpp>
#include <glm/vec3.hpp>

namespace scan {

using Size = std::array<std::int64_t, 3>;  ///< samples along x, y, z

struct Scan {
    Size size{};
    std::vector<float> values;  ///< x fastest, then y, then z; of colours their luma
    /// Red, green and blue of each sample as linear light from 0 to 1; empty unless the file holds colours.
    std::array<std::vector<float>, 3> colours;
    glm::dmat3 axes{1};    ///< columns: the steps from one sample to the next along x, y and z, in world units
    glm::dvec3 origin{0};  ///< position of the first sample
    std::string type;      ///< type of the samples in the file: "uint8", "float", ...
    std::string space;     ///< directions of x, y and z: "right-anterior-superior"; "": the file does not say
    std::string unit;      ///< of the world: "micron"; "": the file does not say, or its format has one
    bool isSpaced = true;  ///< the file says how far samples are apart
    std::vector<std::string> notes;  ///< what a user should know: "PATH: its slices are ... apart: resampled to ..."
    std::size_t indexOf(std::int64_t x, std::int64_t y, std::int64_t z) const {
        return static_cast<std::size_t>((z * size[1] + y) * size[0] + x);
    }
};

enum class SampleType { uint8, int8, uint16, int16, uint32, int32, float32, float64, uint64, int64, float16 };
constexpr int kSampleTypes = 11;
std::int64_t bytesOf(SampleType type);
std::string nameOf(SampleType type);
/// True for samples of floats.
bool isReal(SampleType type);

/// The transform row by row, as `add_grid` takes it.
void worldFromIndexOf(const Scan& scan, double matrix[16]);

/// "nx x ny x nz".
std::string textOf(const Size& size);

/// The number of samples. Throws "`path`: ..." where one of the sizes is below 1 or the product exceeds Scrim's limit
/// (2^31), before anything is allocated.
std::int64_t sampleCount(const Size& size, const std::string& path);

/// With the letters A to Z in lower case.
std::string lowerCase(std::string text);

/// Throws "PATH: reason".
[[noreturn]] void refuse(const std::string& path, const std::string& reason);

/// The size of a regular file, bytes; throws where it is missing or not a regular file (a pipe would never end).
std::int64_t fileBytes(const std::string& path);

/// Throws where `compressed` bytes of deflate or the like cannot become `bytes`, since deflate gains a factor of 1032
/// at most. Thus a small damaged or malicious file cannot fill the memory.
void checkRatio(std::int64_t compressed, std::int64_t bytes, const std::string& path);

/// The layout of samples in a file.
struct RawLayout {
    Size size{};
    SampleType type = SampleType::uint8;
    bool bigEndian = false;
    std::int64_t header = 0;  ///< bytes before the first sample, after decompression
    bool exact = true;        ///< more bytes than declared are an error, too; fewer always are
    bool deflated = false;    ///< the samples are a stream of zlib, behind a header that is not
};

/// The samples of `path`, decompressed where its name ends in ".gz".
std::vector<float> readRaw(const std::string& path, const RawLayout& layout);

/// The samples of `bytes`, which are as many as the layout says, without a header.
std::vector<float> samplesIn(const std::string& bytes, const RawLayout& layout);

/// Adds samples to `values` and `colours`, of which `parts` holds red, green and blue one behind the other. Values are
/// luma in the units of the file (BT.709: 0.2126 red + 0.7152 green + 0.0722 blue). Colours are light: whole numbers,
/// relative to the largest of their type, are taken for sRGB, and floats are light as they are.
void addColours(const std::vector<float>& parts, SampleType type, Scan& scan);
/// "RGB of uint8": the `type` of a scan of colours.
std::string colourTypeOf(SampleType type);

/// Refuses the name of a second file that is not in the folder of `path` or below it: an untrusted header must not
/// choose any file of the disk.
void checkWithin(const std::string& name, const std::string& path);

/// Read a whole file, with the type, size and place that its header states: NRRD through Teem, NIfTI-1 and -2, in
/// one file or a pair of them, through the NIfTI library. Of several volumes in a file
/// (for TIFF: channels, which change first, and frames), `component` is the number of the one that is read; -1: the
/// file must hold one only.
Scan readNrrd(const std::string& path, std::int64_t component);
Scan readNifti(const std::string& path, std::int64_t component);
Scan readTiff(const std::string& path, std::int64_t component);
Scan readMetaImage(const std::string& path);
Scan readNumpy(const std::string& path);
Scan readMrc(const std::string& path);
Scan readVti(const std::string& path);

/// Refuses `component` where the file holds `count` volumes and it is not one of theirs, or not given.
void checkComponent(std::int64_t component, std::int64_t count, const std::string& path);

/// Reads the DICOM series in a folder, or the one in its folder that a file belongs to, through GDCM. The path may also
/// be that of a file that holds those of the folder (scrim_source.h). Samples are by slope and intercept. Slices at
/// uneven distances are resampled, with a note; a missing slice is refused.
Scan readDicom(const std::string& path);
/// True for names that end in .dcm or .dicom.
bool isDicomFile(const std::string& path);

/// Reads TIFF files of one page each, sorted by the number in their names: all of a folder, or those that match a
/// pattern (slice_files.h). Files that differ in size, or among which one is missing, are refused.
Scan readTiffSlices(const std::string& path);
/// True for names that end in .tif or .tiff.
bool isTiffFile(const std::string& path);
/// True for a folder that holds TIFF files and no DICOM.
bool holdsTiffSlices(const std::string& folder);

}  // namespace scan
