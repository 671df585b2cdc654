// SPDX-License-Identifier: Apache-2.0
// Internal: the interface of the module `scrim_images`. OpenImageIO comes with 260 shared libraries (video codecs,
// GDAL, OpenCV), and takes longer to start than many a picture takes to render. Therefore only this module is linked to
// it, and it is loaded where a picture file is read or written. The module uses nothing of Scrim but this header.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace scrim {

/// Most pixels of a picture; as a texture with its pyramid they take 1 GB.
constexpr std::size_t kMostTexturePixels = std::size_t{48} << 20;

/// Most samples of a deep picture: 3 GB in memory, and more than a frame of film has.
constexpr std::size_t kMostDepthSamples = std::size_t{256} << 20;

/// A picture file over its full (display) window, rotated as its orientation tag says, with 4 floats per pixel in rows
/// from top to bottom. The values are the file's: nothing is converted, and alpha is as in the file.
struct FilePicture {
    int width = 0, height = 0;
    std::vector<float> rgba;
    bool integers = false;    ///< the file holds integers
    bool alphaApart = false;  ///< colour is not multiplied by alpha
    double pixelAspect = 1;
    std::string problem;  ///< why there is no picture; "": there is one
};

/// The header of a picture file, with data about the camera that made it.
struct PictureHeader {
    int width = 0, height = 0;  ///< of the full (display) window
    double pixelAspect = 1;
    std::string camera;                            ///< the attribute scrim:camera, as Scrim writes it, or ""
    std::vector<float> worldToCamera, worldToNdc;  ///< 16 numbers that act on row vectors, or none
    std::string problem;                           ///< why there is no header; "": there is one
};

/// The depths in a picture file: one for each pixel or, in a deep file, any number of samples.
struct FileDepth {
    /// The data window, relative to the corner of the full (display) window.
    int x0 = 0, y0 = 0, width = 0, height = 0;
    int fullWidth = 0, fullHeight = 0;
    bool deep = false;
    std::vector<float> depths;          ///< flat: one for each pixel, in rows from top to bottom
    std::vector<std::uint32_t> counts;  ///< deep: number of samples of each pixel
    std::vector<float> samples;         ///< deep: Z, ZBack and alpha of each sample, pixel by pixel
    std::string problem;                ///< why there are no depths; "": there are
};

/// A file in memory.
struct FileBytes {
    std::vector<unsigned char> bytes;
    std::string problem;  ///< why there are no bytes; "": there are
};

/// An 8-bit RGB picture, rows from top to bottom.
struct RgbPicture {
    int width = 0, height = 0;
    std::vector<std::uint8_t> rgb;
};

struct PictureModule {
    /// For a process that forks children which read behind a filter (src/load/confine.h), and does nothing else: from
    /// then on the module starts no threads, and whatever needs to open files is done now.
    void (*prepare)();
    /// Reads a regular file.
    FilePicture (*read)(const std::string& path);
    /// Reads the header only, no pixels.
    PictureHeader (*header)(const std::string& path);
    /// Reads a channel of depths; "" stands for the only channel that can hold them.
    FileDepth (*depth)(const std::string& path, const std::string& channel);
    /// The bytes of a picture file in the format of the extension of `name`.
    FileBytes (*encode)(const std::string& name, const RgbPicture& picture);
};

/// The single function that the module exports. The name must change whenever anything above changes.
#define SCRIM_PICTURE_MODULE_SYMBOL "scrim_picture_module_4"
using PictureModuleFunction = const PictureModule* (*)();

/// The path of the module, which is an optional part of an installation. Throws Error(render) where it is missing.
std::string pictureModulePath();

/// Loads the module and never unloads it. May be called from any thread. Throws Error(render) where
/// it cannot be loaded.
const PictureModule& pictureModule();

}  // namespace scrim
