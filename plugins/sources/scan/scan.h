// SPDX-License-Identifier: Apache-2.0
// A scan in memory, whatever file it came from, and what all readers share: sample types, limits, how errors begin.
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
    std::vector<float> values;  ///< x fastest, then y, then z
    glm::dmat3 axes{1};         ///< columns: the step from one sample to the next along x, y, z, in world units
    glm::dvec3 origin{0};       ///< where the first sample is
    std::string type;           ///< of the samples in the file: "uint8", "float", ...
    std::string space;          ///< where x, y and z lead: "right-anterior-superior"; "": the file does not say
    std::size_t indexOf(std::int64_t x, std::int64_t y, std::int64_t z) const {
        return static_cast<std::size_t>((z * size[1] + y) * size[0] + x);
    }
};

enum class SampleType { uint8, int8, uint16, int16, uint32, int32, float32, float64 };
std::int64_t bytesOf(SampleType type);
std::string nameOf(SampleType type);

/// Row by row, as `add_grid` takes it.
void worldFromIndexOf(const Scan& scan, double matrix[16]);

/// "nx x ny x nz".
std::string textOf(const Size& size);

/// The number of samples. Throws "`path`: ..." where one of the sizes is below 1 or the product is more than Scrim
/// takes (2^31), before anybody allocates.
std::int64_t sampleCount(const Size& size, const std::string& path);

/// "PATH: reason".
[[noreturn]] void refuse(const std::string& path, const std::string& reason);

/// Bytes of a regular file; throws where it is missing or something else (a pipe would never end).
std::int64_t fileBytes(const std::string& path);

/// Whether `compressed` bytes of deflate or the like can become `bytes`: deflate gains 1032 at most. Throws where not,
/// so that a small damaged or malicious file cannot fill the memory.
void checkRatio(std::int64_t compressed, std::int64_t bytes, const std::string& path);

/// How samples lie in a file.
struct RawLayout {
    Size size{};
    SampleType type = SampleType::uint8;
    bool bigEndian = false;
    std::int64_t header = 0;  ///< bytes before the first sample, after decompression
    bool exact = true;        ///< whether more bytes than declared are an error; less always are
};

/// The samples of `path`, decompressed where its name ends in ".gz".
std::vector<float> readRaw(const std::string& path, const RawLayout& layout);

/// A whole file with what its header says of type, size and place. NRRD through Teem, NIfTI-1 and -2 through the
/// NIfTI library.
Scan readNrrd(const std::string& path);
Scan readNifti(const std::string& path);

}  // namespace scan
