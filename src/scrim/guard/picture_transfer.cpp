// SPDX-License-Identifier: Apache-2.0
#include <scrim/guard/picture_transfer.h>

#include <scrim/guard/transfer_file.h>

#include <algorithm>
#include <cstdint>
#include <cstring>

namespace scrim {
namespace {

struct Pixels {
    std::int32_t width = 0, height = 0;
    std::uint32_t integers = 0, alphaApart = 0;
    double pixelAspect = 1;
};

// Takes over the size and pixel aspect of a picture or a header. Throws where they are impossible.
template <typename Picture>
void takeSize(const Pixels& pixels, Picture& out) {
    constexpr double kLeastAspect = 1e-3, kMostAspect = 1e3;
    out.width = pixels.width;
    out.height = pixels.height;
    out.pixelAspect = pixels.pixelAspect;
    if (out.width < 1 || out.height < 1) incompleteTransfer("its picture has no pixels");
    if (!(out.pixelAspect >= kLeastAspect && out.pixelAspect <= kMostAspect))
        incompleteTransfer("its pixel aspect ratio is invalid");
}

struct DepthWindows {
    std::int32_t x0 = 0, y0 = 0, width = 0, height = 0, fullWidth = 0, fullHeight = 0;
    std::uint32_t deep = 0;
};

struct AngleCounts {
    std::uint64_t vertical = 0, horizontal = 0;
};

template <typename T>
void takeInto(std::vector<T>& to, std::uint64_t count, TransferReader& reader) {
    const char* values = reader.take(count, sizeof(T));
    to.resize(count);
    if (count > 0) std::memcpy(to.data(), values, count * sizeof(T));
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
    takeInto(out.rgba, 4 * pixels, reader);
    if (!reader.done()) incompleteTransfer("it is longer than its header says");
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
        if (count != 0 && count != 16) incompleteTransfer("a matrix does not have 16 numbers");
        matrix->resize(count);
        const char* numbers = reader.take(count, sizeof(float));
        if (count > 0) std::memcpy(matrix->data(), numbers, count * sizeof(float));
    }
    if (!reader.done()) incompleteTransfer("it is longer than its header says");
    if (out.problem.empty()) takeSize(pixels, out);
    return out;
}

void sendPictureDepth(int fd, const FileDepth& depth) {
    TransferWriter writer(fd);
    writer.value(
        DepthWindows{depth.x0, depth.y0, depth.width, depth.height, depth.fullWidth, depth.fullHeight, depth.deep});
    writer.text(depth.problem);
    writer.align();
    writer.bytes(depth.depths.data(), depth.depths.size() * sizeof(float));
    writer.bytes(depth.counts.data(), depth.counts.size() * sizeof(std::uint32_t));
    writer.bytes(depth.samples.data(), depth.samples.size() * sizeof(float));
    writer.finish({}, TransferKind::pictureDepth);
}

FileDepth receivePictureDepth(int fd) {
    const TransferMapping mapping(fd);
    TransferReader reader(mapping);
    reader.header(TransferKind::pictureDepth);
    const auto windows = reader.value<DepthWindows>();
    FileDepth out;
    out.problem = shortened(reader.text(), 2000);
    if (!out.problem.empty()) return out;
    // Largest coordinate of a window's corner; sums of such numbers are far from any limit.
    constexpr int kFarthest = 1 << 24;
    const auto isPlace = [](int v) { return v > -kFarthest && v < kFarthest; };
    for (const int v : {windows.x0, windows.y0, windows.width, windows.height, windows.fullWidth, windows.fullHeight})
        if (!isPlace(v)) incompleteTransfer("its picture's windows are out of range");
    if (windows.width < 1 || windows.height < 1) incompleteTransfer("its picture has no pixels");
    out.x0 = windows.x0;
    out.y0 = windows.y0;
    out.width = windows.width;
    out.height = windows.height;
    out.fullWidth = windows.fullWidth;
    out.fullHeight = windows.fullHeight;
    out.deep = windows.deep != 0;
    const std::uint64_t pixels = static_cast<std::uint64_t>(out.width) * static_cast<std::uint64_t>(out.height);
    if (pixels > kMostTexturePixels) incompleteTransfer("its picture has too many pixels");
    reader.align();
    if (out.deep) {
        takeInto(out.counts, pixels, reader);
        std::uint64_t samples = 0;
        for (const std::uint32_t count : out.counts) samples += count;
        if (samples > kMostDepthSamples) incompleteTransfer("its picture has too many samples");
        takeInto(out.samples, 3 * samples, reader);
    } else {
        takeInto(out.depths, pixels, reader);
    }
    if (!reader.done()) incompleteTransfer("it is longer than its header says");
    return out;
}

void sendPhotometry(int fd, const FilePhotometry& file) {
    TransferWriter writer(fd);
    writer.value(AngleCounts{file.vertical.size(), file.horizontal.size()});
    writer.text(file.problem);
    writer.align();
    for (const std::vector<float>* values : {&file.vertical, &file.horizontal, &file.candela})
        writer.bytes(values->data(), values->size() * sizeof(float));
    writer.finish({}, TransferKind::photometry);
}

FilePhotometry receivePhotometry(int fd) {
    const TransferMapping mapping(fd);
    TransferReader reader(mapping);
    reader.header(TransferKind::photometry);
    const auto counts = reader.value<AngleCounts>();
    FilePhotometry out;
    out.problem = shortened(reader.text(), 2000);
    if (!out.problem.empty()) return out;
    if (counts.vertical < 2 || counts.vertical > kMostProfileAngles || counts.horizontal < 1 ||
        counts.horizontal > kMostProfileAngles || counts.vertical * counts.horizontal > kMostCandelas)
        incompleteTransfer("its angles are too few or too many");
    reader.align();
    takeInto(out.vertical, counts.vertical, reader);
    takeInto(out.horizontal, counts.horizontal, reader);
    takeInto(out.candela, counts.vertical * counts.horizontal, reader);
    if (!reader.done()) incompleteTransfer("it is longer than its header says");
    for (const std::vector<float>* angles : {&out.vertical, &out.horizontal})
        for (std::size_t i = 0; i < angles->size(); ++i)
            if (!((*angles)[i] >= 0 && (*angles)[i] <= 360 && (i == 0 || (*angles)[i] > (*angles)[i - 1])))
                incompleteTransfer("its angles do not ascend");
    float most = 0;
    for (const float candela : out.candela) {
        if (!(candela >= 0 && candela <= kMostCandela)) incompleteTransfer("a candela value is out of range");
        most = std::max(most, candela);
    }
    if (most == 0) incompleteTransfer("its candela values are all 0");
    return out;
}

}  // namespace scrim
