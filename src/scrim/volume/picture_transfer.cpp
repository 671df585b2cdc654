// SPDX-License-Identifier: Apache-2.0
#include <scrim/volume/picture_transfer.h>

#include <scrim/volume/transfer_file.h>

#include <cstdint>
#include <cstring>

namespace scrim {
namespace {

struct Pixels {
    std::int32_t width = 0, height = 0;
    std::uint32_t integers = 0, alphaApart = 0;
    double pixelAspect = 1;
};

// Size and shape of a picture, or of what has a picture's header. Throws where it can be neither.
template <typename Picture>
void takeSize(const Pixels& pixels, Picture& out) {
    constexpr double kLeastAspect = 1e-3, kMostAspect = 1e3;
    out.width = pixels.width;
    out.height = pixels.height;
    out.pixelAspect = pixels.pixelAspect;
    if (out.width < 1 || out.height < 1) incompleteTransfer("its picture has no pixels");
    if (!(out.pixelAspect >= kLeastAspect && out.pixelAspect <= kMostAspect))
        incompleteTransfer("its pixels have no shape");
}

}  // namespace

void sendPicture(int fd, const FilePicture& picture) {
    TransferWriter writer(fd);
    writer.value(Pixels{picture.width, picture.height, picture.integers, picture.alphaApart, picture.pixelAspect});
    writer.text(picture.problem);
    writer.align();
    writer.bytes(picture.rgba.data(), picture.rgba.size() * sizeof(float));
    writer.finish({}, TransferKind::picture);
}

FilePicture receivePicture(int fd) {
    const TransferMapping mapping(fd);
    TransferReader reader(mapping);
    reader.header(TransferKind::picture);
    const auto header = reader.value<Pixels>();
    FilePicture out;
    out.problem = shortened(reader.text(), 2000);
    if (!out.problem.empty()) return out;
    takeSize(header, out);
    out.integers = header.integers != 0;
    out.alphaApart = header.alphaApart != 0;
    const std::uint64_t pixels = static_cast<std::uint64_t>(out.width) * static_cast<std::uint64_t>(out.height);
    if (pixels > kMostTexturePixels) incompleteTransfer("its picture has too many pixels");
    reader.align();
    const char* values = reader.take(4 * pixels, sizeof(float));
    out.rgba.resize(4 * pixels);
    std::memcpy(out.rgba.data(), values, 4 * pixels * sizeof(float));
    if (!reader.done()) incompleteTransfer("it is longer than it says");
    return out;
}

void sendPictureHeader(int fd, const PictureHeader& header) {
    TransferWriter writer(fd);
    writer.value(Pixels{header.width, header.height, 0, 0, header.pixelAspect});
    for (const std::string& text : {header.problem, header.camera}) writer.text(text);
    for (const std::vector<float>& matrix : {header.worldToCamera, header.worldToNdc}) {
        writer.value(static_cast<std::uint32_t>(matrix.size()));
        writer.bytes(matrix.data(), matrix.size() * sizeof(float));
    }
    writer.finish({}, TransferKind::pictureHeader);
}

PictureHeader receivePictureHeader(int fd) {
    const TransferMapping mapping(fd);
    TransferReader reader(mapping);
    reader.header(TransferKind::pictureHeader);
    const auto pixels = reader.value<Pixels>();
    PictureHeader out;
    out.problem = shortened(reader.text(), 2000);
    out.camera = reader.text();
    for (std::vector<float>* matrix : {&out.worldToCamera, &out.worldToNdc}) {
        const auto count = reader.value<std::uint32_t>();
        if (count != 0 && count != 16) incompleteTransfer("a matrix has not 16 numbers");
        matrix->resize(count);
        const char* numbers = reader.take(count, sizeof(float));
        if (count > 0) std::memcpy(matrix->data(), numbers, count * sizeof(float));
    }
    if (!reader.done()) incompleteTransfer("it is longer than it says");
    if (out.problem.empty()) takeSize(pixels, out);
    return out;
}

}  // namespace scrim
