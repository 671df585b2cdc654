// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/exr.h>

#include <scrim/base/atomic_file.h>
#include <scrim/base/parallel.h>
#include <scrim/base/system_error.h>

#include <Imath/half.h>
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfFramesPerSecond.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfIO.h>
#include <OpenEXR/ImfIntAttribute.h>
#include <OpenEXR/ImfMatrixAttribute.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfRationalAttribute.h>
#include <OpenEXR/ImfStandardAttributes.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <OpenEXR/ImfThreading.h>
#include <fmt/format.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <deque>
#include <fstream>
#include <set>

namespace scrim {

namespace {

constexpr float kLargestHalf = 65504.0f;
constexpr float kDwaLevel = 45.0f;  // OpenEXR's own default, written down since it decides what is lost

/// AP0: SMPTE ST 2065-1, table 1, with the white point of ACES (about D60).
const Imf::Chromaticities kAp0({0.73470f, 0.26530f}, {0.0f, 1.0f}, {0.00010f, -0.07700f}, {0.32168f, 0.33767f});

/// An output stream that remembers its first failure. OpenEXR swallows exceptions while it closes a file, so
/// that a full disk would go unnoticed there; `close` says it.
class CheckedStream : public Imf::OStream {
  public:
    explicit CheckedStream(const std::string& path) : Imf::OStream(path.c_str()) {
        errno = 0;  // so that `check` sees no older one
        m_file.open(path, std::ios::binary | std::ios::trunc);
        check();
    }
    void write(const char bytes[], int count) override {
        errno = 0;
        m_file.write(bytes, count);
        check();
    }
    uint64_t tellp() override { return static_cast<uint64_t>(std::streamoff(m_file.tellp())); }
    void seekp(uint64_t position) override {
        errno = 0;
        m_file.seekp(static_cast<std::streamoff>(position));
        check();
    }
    void close() {
        errno = 0;
        m_file.close();
        check();
    }

  private:
    void check() {
        if (m_error == 0 && !m_file) m_error = errno != 0 ? errno : EIO;
        if (m_error != 0) throw std::runtime_error(systemErrorText(m_error));
    }

    std::ofstream m_file;
    int m_error = 0;
};

Imf::Compression compressionNamed(const std::string& name) {
    if (name == "zip") return Imf::ZIP_COMPRESSION;
    if (name == "zips") return Imf::ZIPS_COMPRESSION;
    if (name == "piz") return Imf::PIZ_COMPRESSION;
    if (name == "dwaa") return Imf::DWAA_COMPRESSION;
    if (name == "none") return Imf::NO_COMPRESSION;
    throw Error(ErrorKind::usage,
                fmt::format("unknown EXR compression '{}'; expected {}", shortened(name), choices(exrCompressions())));
}

Imath::Box2i closedBox(const PixelWindow& window) {
    return {{window.x0, window.y0}, {window.x1 - 1, window.y1 - 1}};
}

/// All that can be wrong with the arguments of writeExr, before anything is written.
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

struct InsertAttribute {
    Imf::Header& header;
    const std::string& name;

    void operator()(const std::string& text) const { header.insert(name, Imf::StringAttribute(text)); }
    void operator()(double value) const { header.insert(name, Imf::FloatAttribute(static_cast<float>(value))); }
    void operator()(int value) const { header.insert(name, Imf::IntAttribute(value)); }
    void operator()(const glm::dmat4& matrix) const {
        // GLM's [column][row] of a matrix for column vectors is EXR's [row][column] of one for row vectors.
        Imath::M44f rows;
        for (int i = 0; i < 4; ++i)
            for (int j = 0; j < 4; ++j) rows[i][j] = static_cast<float>(matrix[i][j]);
        header.insert(name, Imf::M44fAttribute(rows));
    }
    void operator()(const FrameRate& rate) const {
        header.insert(name, Imf::RationalAttribute(Imf::Rational(rate.numerator, static_cast<int>(rate.denominator))));
    }
};

Imf::Header makeHeader(const PixelWindow& dataWindow, const ExrOptions& options, const ExrAttributes& attributes) {
    const Imf::Compression compression = compressionNamed(options.compression);
    Imf::Header header(closedBox(options.displayWindow), closedBox(dataWindow), static_cast<float>(options.pixelAspect),
                       Imath::V2f(0, 0), 1, Imf::INCREASING_Y,
                       options.acesContainer ? Imf::NO_COMPRESSION : compression);
    if (compression == Imf::DWAA_COMPRESSION) header.dwaCompressionLevel() = kDwaLevel;
    if (!options.colorInteropId.empty()) header.insert("colorInteropID", Imf::StringAttribute(options.colorInteropId));
    if (options.acesContainer) {
        header.insert("acesImageContainerFlag", Imf::IntAttribute(1));
        Imf::addChromaticities(header, kAp0);
    }
    for (const auto& [name, value] : attributes) std::visit(InsertAttribute{header, name}, value);
    return header;
}

/// The channels of one file: float channels are read where the caller has them, half ones from converted
/// copies that live here.
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
    /// Pixels from the image window's first one to the data window's.
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
            for (std::size_t i = 0; i < count; ++i) out.push_back(clampedHalf(row[i]));
        }
        return out;
    }

    half clampedHalf(float value) {
        if (std::fabs(value) > kLargestHalf) {
            ++m_clamped;
            value = std::copysign(kLargestHalf, value);
        }
        return half(value);
    }

    PixelWindow m_imageWindow;
    PixelWindow m_dataWindow;
    Imf::FrameBuffer m_frame;
    std::deque<std::vector<half>> m_halves;  // a deque: growing must not move what the frame points to
    std::size_t m_clamped = 0;
};

}  // namespace

const std::vector<std::string>& exrCompressions() {
    static const std::vector<std::string> names = {"zip", "zips", "piz", "dwaa", "none"};
    return names;
}

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
    AtomicFile file(path);
    try {
        Imf::Header header = makeHeader(dataWindow, options, attributes);
        ChannelSet channels(image.window, dataWindow);
        channels.add(header, {"R", "G", "B", "A"}, image.rgba, options.half);
        for (const ExrLayer& layer : layers)
            channels.add(header, layer.channels, layer.data, options.half && !layer.always32bit);

        CheckedStream stream(file.tempPath());
        {
            Imf::OutputFile out(stream, header, threadCount());
            out.setFrameBuffer(channels.frame());
            out.writePixels(dataWindow.height());
        }
        stream.close();
        file.commit();
        return channels.clampedCount();
    } catch (const Error&) {
        throw;
    } catch (const std::bad_alloc&) {
        throw Error(ErrorKind::memory, fmt::format("cannot write '{}': out of memory", path));
    } catch (const std::exception& exception) {
        throw Error(ErrorKind::output, fmt::format("cannot write '{}': {}", path, shortened(exception.what())));
    }
}

}  // namespace scrim
