// SPDX-License-Identifier: Apache-2.0
// Fuzz target: what the process that reads a damaged file hands over may be anything, since its memory may have been
// overwritten. The receiver takes whole and plausible fields and pictures, or refuses in one line.
#include "require.h"

#include <scrim/base/error.h>
#include <scrim/guard/field_transfer.h>
#include <scrim/guard/picture_transfer.h>

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>

#include <unistd.h>

namespace scrim::fuzz {
namespace {

void checkFields(const ReceivedFields& received, std::size_t size) {
    for (const SparseField& field : received.fields) {
        require(field.blockCount() * kBlockVoxels * sizeof(float) <= size, "{} blocks in {} bytes", field.blockCount(),
                size);
        for (const Int3& origin : field.blockOrigins)
            require(origin.x % 8 == 0 && origin.y % 8 == 0 && origin.z % 8 == 0, "a block at {}", origin.x);
        for (std::size_t b = 0; b < field.blockCount(); ++b)
            for (int i = 0; i < kBlockVoxels; ++i)
                // Loops of the engine take denormals for 0, whatever their sign.
                require(std::isfinite(field.block(b)[i]) && field.block(b)[i] > -std::numeric_limits<float>::min(),
                        "a voxel of {}", field.block(b)[i]);
        for (const ConstantTile& tile : field.tiles)
            require(tile.edge > 0 && std::isfinite(tile.value) && tile.value >= 0, "a tile of edge {}", tile.edge);
        for (int c = 0; c < 4; ++c)
            for (int r = 0; r < 4; ++r) require(std::isfinite(field.wsFromIs[c][r]), "a map that is not finite");
    }
}

void checkPicture(const FilePicture& picture, std::size_t size) {
    if (!picture.problem.empty()) return require(picture.rgba.empty(), "a problem, and pixels");
    require(picture.width > 0 && picture.height > 0, "{} x {} pixels", picture.width, picture.height);
    require(picture.rgba.size() / 4 == std::size_t(picture.width) * std::size_t(picture.height), "{} values",
            picture.rgba.size());
    require(picture.rgba.size() * sizeof(float) <= size, "{} values in {} bytes", picture.rgba.size(), size);
    require(picture.pixelAspect > 0 && std::isfinite(picture.pixelAspect), "pixels {} wide", picture.pixelAspect);
}

/// What was sent instead of a result, by a sender that met an error, is an Error of any text.
void mayThrowError(const std::function<void()>& receive) {
    try {
        receive();
    } catch (const BesideError& error) {
        require(error.name().find('/') == std::string::npos && error.name() != "..", "a wish for '{}'", error.name());
    } catch (const Error& error) {
        require(
            error.kind() == ErrorKind::input || error.kind() == ErrorKind::memory || error.kind() == ErrorKind::render,
            "an error of kind {}", static_cast<int>(error.kind()));
    }
}

}  // namespace
}  // namespace scrim::fuzz

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    using namespace scrim;
    using namespace scrim::fuzz;
    const int transfer = createTransfer();
    const bool written = ::write(transfer, data, size) == static_cast<ssize_t>(size);
    mayThrowError([&] { checkFields(receiveFields(transfer), size); });
    mayThrowError([&] { receiveInfo(transfer); });
    mayThrowError([&] { checkPicture(receivePicture(transfer), size); });
    ::close(transfer);
    require(written, "no memory for {} bytes", size);
    return 0;
}
