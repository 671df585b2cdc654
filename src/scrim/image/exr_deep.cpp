// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/exr_deep.h>

#include <scrim/base/parallel.h>
#include <scrim/image/exr_header.h>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDeepFrameBuffer.h>
#include <OpenEXR/ImfDeepImageStateAttribute.h>
#include <OpenEXR/ImfDeepScanLineOutputFile.h>
#include <OpenEXR/ImfPartType.h>
#include <OpenEXR/ImfStandardAttributes.h>

#include <algorithm>
#include <limits>

namespace scrim {

namespace {

constexpr int kRowsAtATime = 32;

// Transmittance below which samples are merged into the one in front: half floats have no alpha
// between 1 - 2^-11 and 1.
constexpr double kOpaqueHalf = 1.0 / 2048, kOpaqueFloat = 1e-6;

PixelWindow windowOfSamples(const DeepImage& image) {
    PixelWindow box{};
    for (int y = image.window.y0; y < image.window.y1; ++y) {
        const auto& first = image.rows[std::size_t(y - image.window.y0)].first;
        for (int x = image.window.x0; x < image.window.x1; ++x) {
            const auto at = std::size_t(x - image.window.x0);
            if (first[at] < first[at + 1]) box.include(PixelWindow{x, y, x + 1, y + 1});
        }
    }
    if (!box.empty()) return box;
    return {image.window.x0, image.window.y0, image.window.x0 + 1, image.window.y0 + 1};
}

/// Some rows of the data window in OpenEXR's form.
class Rows {
  public:
    Rows(const PixelWindow& window, bool asHalf) : m_window(window), m_half(asHalf) {
        const std::size_t pixels = std::size_t(window.width()) * kRowsAtATime;
        m_counts.resize(pixels);
        for (std::vector<const char*>& pointers : m_pointers) pointers.resize(pixels);
        m_samples.resize(pixels);
        m_halves.resize(pixels);
    }

    void fill(const DeepImage& image, int y0, int rows) {
        std::vector<std::size_t> clamped(std::size_t(rows), 0);
        parallelFor(std::size_t(rows), [&](std::size_t row) {
            for (int x = m_window.x0; x < m_window.x1; ++x)
                fillPixel(image.curve(x, y0 + static_cast<int>(row)),
                          row * std::size_t(m_window.width()) + std::size_t(x - m_window.x0), clamped[row]);
        });
        for (const std::size_t count : clamped) m_clamped += count;
    }

    /// The frame buffer for the rows from y0 on.
    Imf::DeepFrameBuffer frame(int y0) const {
        Imf::DeepFrameBuffer frame;
        const auto width = std::size_t(m_window.width());
        const auto first = static_cast<std::ptrdiff_t>(y0) * m_window.width() + m_window.x0;
        const auto base = [&](const auto& values) {
            using Value = std::remove_cvref_t<decltype(values[0])>;
            const auto address =
                reinterpret_cast<std::uintptr_t>(values.data()) - static_cast<std::uintptr_t>(first) * sizeof(Value);
            return reinterpret_cast<char*>(address);  // address of pixel (0, 0), which need not exist
        };
        frame.insertSampleCountSlice(Imf::Slice(Imf::UINT, base(m_counts), sizeof(unsigned), sizeof(unsigned) * width));
        for (std::size_t c = 0; c < kNames.size(); ++c) {
            const bool colour = c < kColours;
            frame.insert(kNames[c],
                         Imf::DeepSlice(colour && m_half ? Imf::HALF : Imf::FLOAT, base(m_pointers[c]), sizeof(char*),
                                        sizeof(char*) * width, colour && m_half ? sizeof(Halves) : sizeof(DeepSample)));
        }
        return frame;
    }

    static void describe(Imf::Header& header, bool asHalf) {
        for (std::size_t c = 0; c < kNames.size(); ++c)
            header.channels().insert(kNames[c], Imf::Channel(c < kColours && asHalf ? Imf::HALF : Imf::FLOAT));
    }

    std::size_t clampedCount() const { return m_clamped; }

  private:
    static constexpr std::array<const char*, 6> kNames{"R", "G", "B", "A", "Z", "ZBack"};
    static constexpr std::size_t kColours = 4;
    using Halves = std::array<half, kColours>;

    void fillPixel(std::span<const DeepPiece> curve, std::size_t at, std::size_t& clamped) {
        std::vector<DeepSample>& samples = m_samples[at];
        samples = deepSamples(curve, m_half, clamped);
        m_counts[at] = static_cast<unsigned>(samples.size());
        std::vector<Halves>& halves = m_halves[at];
        halves.clear();
        if (m_half)
            for (const DeepSample& sample : samples) {
                Halves& rgba = halves.emplace_back();
                std::transform(sample.rgba.begin(), sample.rgba.end(), rgba.begin(), [](float v) { return half(v); });
            }
        const auto address = [](const void* value) { return static_cast<const char*>(value); };
        for (std::size_t c = 0; c < kNames.size(); ++c) {
            if (samples.empty())
                m_pointers[c][at] = nullptr;
            else if (c < kColours)
                m_pointers[c][at] = m_half ? address(&halves[0][c]) : address(&samples[0].rgba[c]);
            else
                m_pointers[c][at] = address(c == kColours ? &samples[0].z : &samples[0].zBack);
        }
    }

    PixelWindow m_window;
    bool m_half;
    std::vector<unsigned> m_counts;
    std::array<std::vector<const char*>, 6> m_pointers;
    std::vector<std::vector<DeepSample>> m_samples;
    std::vector<std::vector<Halves>> m_halves;
    std::size_t m_clamped = 0;
};

}  // namespace

std::vector<DeepSample> deepSamples(std::span<const DeepPiece> curve, bool asHalf, std::size_t& clamped) {
    const auto rounded = [&](double value) {
        const auto single = static_cast<float>(value);
        return asHalf ? static_cast<float>(clampedHalf(single, clamped)) : single;
    };
    const double opaque = asHalf ? kOpaqueHalf : kOpaqueFloat;
    std::vector<DeepSample> samples;
    std::array<double, 3> shown{};
    double left = 1;
    for (std::size_t i = 0; i < curve.size() && left > 0; ++i) {
        DeepSample& sample = samples.emplace_back(DeepSample{curve[i].begin, curve[i].end, {}});
        // A sample that leaves less transmittance than can be distinguished takes over everything behind it, too.
        const bool last = i + 1 == curve.size() || 1 - double(curve[i].shown[3]) <= opaque * left;
        const std::array<float, 4>& to = last ? curve.back().shown : curve[i].shown;
        for (std::size_t c = 0; c < 3; ++c) {
            const double colour = (to[c] - shown[c]) / left;
            // Where the preceding sample was rounded up by more than this one adds, this one adds
            // nothing, and the next one less.
            const bool grows = to[c] >= (i > 0 ? curve[i - 1].shown[c] : 0);
            sample.rgba[c] = rounded(grows ? std::max(0.0, colour) : colour);
            shown[c] += left * sample.rgba[c];
        }
        sample.rgba[3] = rounded(std::clamp(1 - (1 - double(to[3])) / left, 0.0, 1.0));
        left *= 1 - double(sample.rgba[3]);
        if (last) break;
    }
    return samples;
}

std::size_t writeDeepExr(const std::string& path, const DeepImage& image, const ExrOptions& options,
                         const ExrAttributes& attributes) {
    if (image.window.empty() || image.rows.size() != std::size_t(image.window.height()))
        throw Error(ErrorKind::usage, fmt::format("cannot write '{}': the deep picture has no pixels", path));
    const PixelWindow window = windowOfSamples(image);
    ExrOptions deep = options;
    deep.compression = "zips";
    deep.acesContainer = false;
    return writingExr(path, [&](AtomicFile& file) {
        Imf::Header header = makeExrHeader(window, deep, attributes);
        header.setType(Imf::DEEPSCANLINE);
        Imf::addDeepImageState(header, Imf::DIS_TIDY);
        Rows::describe(header, deep.half);
        Rows rows(window, deep.half);
        CheckedStream stream(file.tempPath());
        {
            Imf::DeepScanLineOutputFile out(stream, header, threadCount());
            for (int y = window.y0; y < window.y1; y += kRowsAtATime) {
                const int count = std::min(kRowsAtATime, window.y1 - y);
                rows.fill(image, y, count);
                out.setFrameBuffer(rows.frame(y));
                out.writePixels(count);
            }
        }
        stream.close();
        return rows.clampedCount();
    });
}

}  // namespace scrim
