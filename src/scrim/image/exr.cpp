// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/exr.h>

#include <scrim/base/parallel.h>
#include <scrim/image/exr_header.h>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfFramesPerSecond.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfThreading.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <set>

namespace scrim {

namespace {

/// Checks all arguments of writeExr before anything is written.
void checkArguments(const std::string& path, const Image& image, const ExrOptions& options,
                    const std::vector<ExrLayer>& layers) {
    const auto refuse = [&path](const std::string& why) {
        throw Error(ErrorKind::usage, fmt::format("cannot write '{}': {}", path, why));
    };
    if (image.window.empty()) refuse("the picture has no pixels");
    if (image.rgba.size() != 4 * image.window.pixelCount())
        refuse(fmt::format("the picture has {} values, its window {} x {} x 4", image.rgba.size(), image.window.width(),
                           image.window.height()));
    if (options.displayWindow.empty()) refuse("the display window is empty");
    if (!(options.pixelAspect > 0.0) || !std::isfinite(options.pixelAspect))
        refuse(fmt::format("the pixel aspect is {}; expected a number above 0", options.pixelAspect));
    if (options.acesContainer && !options.half) refuse("an ACES container (SMPTE ST 2065-4) holds half values only");
    if (options.acesContainer && !layers.empty())
        refuse("an ACES container (SMPTE ST 2065-4) holds RGBA only; write layers in another colour space");
    std::set<std::string> names = {"R", "G", "B", "A"};
    for (const ExrLayer& layer : layers) {
        for (const std::string& channel : layer.channels)
            if (channel.empty() || !names.insert(channel).second)
                refuse(fmt::format("the channel name '{}' is empty or appears twice", shortened(channel)));
        if (layer.data.size() != layer.channels.size() * image.window.pixelCount())
            refuse(fmt::format("the layer with {} has {} values, expected {} x {} x {}", choices(layer.channels),
                               layer.data.size(), image.window.width(), image.window.height(), layer.channels.size()));
    }
}

/// The channels of one file. Float channels are written directly from the caller's memory, half
/// ones from converted copies that this object owns.
class ChannelSet {
  public:
    ChannelSet(const PixelWindow& imageWindow, const PixelWindow& dataWindow)
        : m_imageWindow(imageWindow), m_dataWindow(dataWindow) {}

    /// Adds interleaved channels that cover the image's window.
    void add(Imf::Header& header, const std::vector<std::string>& names, const std::vector<float>& values,
             bool asHalf) {
        const std::size_t channels = names.size();
        const auto imageWidth = std::size_t(m_imageWindow.width());
        const float* corner = values.data() + channels * cornerOffset();
        const auto* base = reinterpret_cast<const char*>(corner);
        std::size_t valueBytes = sizeof(float);
        std::size_t rowBytes = imageWidth * channels * sizeof(float);
        if (asHalf) {
            base = reinterpret_cast<const char*>(halves(corner, channels, imageWidth * channels).data());
            valueBytes = sizeof(half);
            rowBytes = std::size_t(m_dataWindow.width()) * channels * sizeof(half);
        }
        const Imf::PixelType type = asHalf ? Imf::HALF : Imf::FLOAT;
        for (std::size_t c = 0; c < channels; ++c) {
            header.channels().insert(names[c], Imf::Channel(type));
            m_frame.insert(names[c], Imf::Slice::Make(type, base + c * valueBytes, closedBox(m_dataWindow),
                                                      channels * valueBytes, rowBytes));
        }
    }

    const Imf::FrameBuffer& frame() const { return m_frame; }
    std::size_t clampedCount() const { return m_clamped; }

  private:
    /// The number of pixels from the first pixel of the image window to that of the data window.
    std::size_t cornerOffset() const {
        return std::size_t(m_dataWindow.y0 - m_imageWindow.y0) * std::size_t(m_imageWindow.width()) +
               std::size_t(m_dataWindow.x0 - m_imageWindow.x0);
    }

    const std::vector<half>& halves(const float* corner, std::size_t channels, std::size_t floatsPerRow) {
        const std::size_t count = std::size_t(m_dataWindow.width()) * channels;
        std::vector<half>& out = m_halves.emplace_back();
        out.reserve(count * std::size_t(m_dataWindow.height()));
        for (int y = 0; y < m_dataWindow.height(); ++y) {
            const float* row = corner + std::size_t(y) * floatsPerRow;
            for (std::size_t i = 0; i < count; ++i) out.push_back(clampedHalf(row[i], m_clamped));
        }
        return out;
    }

    PixelWindow m_imageWindow;
    PixelWindow m_dataWindow;
    Imf::FrameBuffer m_frame;
    // A deque, since growing must not move data that the frame buffer points to.
    std::deque<std::vector<half>> m_halves;
    std::size_t m_clamped = 0;
};

}  // namespace

FrameRate exactFrameRate(double framesPerSecond) {
    const Imf::Rational exact = Imf::guessExactFps(framesPerSecond);
    return {exact.n, exact.d};
}

void setExrThreads(int threads) {
    Imf::setGlobalThreadCount(threads);
}

std::size_t writeExr(const std::string& path, const Image& image, const ExrOptions& options,
                     const ExrAttributes& attributes, const std::vector<ExrLayer>& layers) {
    checkArguments(path, image, options, layers);
    const PixelWindow dataWindow = options.wholeWindow ? image.window : nonEmptyWindow(image);
    return writingExr(path, [&](AtomicFile& file) {
        Imf::Header header = makeExrHeader(dataWindow, options, attributes);
        ChannelSet channels(image.window, dataWindow);
        if (options.picture) channels.add(header, {"R", "G", "B", "A"}, image.rgba, options.half);
        for (const ExrLayer& layer : layers)
            channels.add(header, layer.channels, layer.data, options.half && !layer.always32bit);

        CheckedStream stream(file.tempPath());
        {
            Imf::OutputFile out(stream, header, threadCount());
            out.setFrameBuffer(channels.frame());
            out.writePixels(dataWindow.height());
        }
        stream.close();
        return channels.clampedCount();
    });
}

}  // namespace scrim
