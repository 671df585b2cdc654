// SPDX-License-Identifier: Apache-2.0
// Internal: what the module `scrim_images` does. OpenImageIO comes with 260 shared libraries (video codecs, GDAL,
// OpenCV), and takes longer to start than many a picture takes to render. So nothing of Scrim is linked to it but this
// module, which is loaded where a picture file is read or written. The module uses nothing of Scrim but this header.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace scrim {

/// Pixels a picture may have: as a texture 1 GB with its pyramid.
constexpr std::size_t kMostTexturePixels = std::size_t{48} << 20;

/// Samples of a deep picture: 3 GB as they come, and more than a frame of film has.
constexpr std::size_t kMostDepthSamples = std::size_t{256} << 20;

/// A picture file over its full (display) window, turned as its orientation tag says, 4 floats a pixel in rows from top
/// to bottom. The file's values: nothing is converted, and alpha is as the file has it.
struct FilePicture {
    int width = 0, height = 0;
    std::vector<float> rgba;
    bool integers = false;    ///< as the file has them
    bool alphaApart = false;  ///< colour is not multiplied by alpha
    double pixelAspect = 1;
    std::string problem;  ///< why there is no picture; "": there is one
};

/// What a picture file says of itself, and of the camera that made it.
struct PictureHeader {
    int width = 0, height = 0;  ///< of the full (display) window
    double pixelAspect = 1;
    std::string camera;                            ///< scrim:camera, as Scrim writes it; ""
    std::vector<float> worldToCamera, worldToNdc;  ///< 16 numbers that act on row vectors, or none
    std::string problem;                           ///< why there is no header; "": there is one
};

/// What a picture file says of where things are: one depth a pixel, or, where it is deep, any number of samples.
struct FileDepth {
    int x0 = 0, y0 = 0, width = 0, height = 0;  ///< the data window, from the corner of the full (display) window
    int fullWidth = 0, fullHeight = 0;
    bool deep = false;
    std::vector<float> depths;          ///< flat: of each pixel, in rows from top to bottom
    std::vector<std::uint32_t> counts;  ///< deep: samples of each pixel
    std::vector<float> samples;         ///< deep: Z, ZBack and alpha of each, pixel by pixel
    std::string problem;                ///< why there is none; "": there is one
};

/// A file in memory.
struct FileBytes {
    std::vector<unsigned char> bytes;
    std::string problem;  ///< why there are none; "": there are
};

/// An 8-bit RGB picture, rows from top to bottom.
struct RgbPicture {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;
};

struct PictureModule {
    /// For a process that forks others which read, behind a filter (src/load/confine.h), and do nothing else: starts no
    /// threads from then on, and does once what opens files.
    void (*prepare)();
    /// Reads a regular file.
    FilePicture (*read)(const std::string& path);
    /// Reads no pixels.
    PictureHeader (*header)(const std::string& path);
    /// Reads a channel of depths; "": the one that must be it.
    FileDepth (*depth)(const std::string& path, const std::string& channel);
    /// The bytes of a file in the format that the extension of `name` stands for.
    FileBytes (*encode)(const std::string& name, const RgbPicture& picture);
};

/// The one function that the module exports. Its name changes with whatever stands above.
#define SCRIM_PICTURE_MODULE_SYMBOL "scrim_picture_module_4"
using PictureModuleFunction = const PictureModule* (*)();

/// Where the module is, which an installation may do without. Throws Error(render) where it does.
std::string pictureModulePath();

/// Loads the module, for good. May be called from any thread. Throws Error(render) where it cannot be loaded.
const PictureModule& pictureModule();

}  // namespace scrim
