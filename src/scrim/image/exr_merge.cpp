// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/exr_merge.h>

#include <scrim/base/finite.h>
#include <scrim/base/parallel.h>
#include <scrim/image/exr_header.h>
#include <scrim/image/exr_tile.h>

#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfDeepFrameBuffer.h>
#include <OpenEXR/ImfDeepScanLineInputFile.h>
#include <OpenEXR/ImfDeepScanLineOutputFile.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfPartType.h>

#include <algorithm>
#include <cstdint>
#include <cstring>
#include <memory>

namespace scrim {
namespace {

// A multiple of the rows that ZIP compresses together, so that few blocks are read twice.
constexpr int kRowsAtATime = 64;

struct Channel {
    std::string name;
    Imf::PixelType type;
    std::size_t bytes;  // of one value
};

std::vector<Channel> channelsOf(const Imf::Header& header) {
    std::vector<Channel> channels;
    for (auto it = header.channels().begin(); it != header.channels().end(); ++it)
        channels.push_back(
            {it.name(), it.channel().type, it.channel().type == Imf::HALF ? sizeof(half) : sizeof(float)});
    return channels;
}

/// The address that pixel (0, 0) would have, as OpenEXR needs it.
char* baseOf(const void* first, const PixelWindow& window, std::size_t bytes) {
    const auto offset =
        (static_cast<std::ptrdiff_t>(window.y0) * window.width() + window.x0) * static_cast<std::ptrdiff_t>(bytes);
    return reinterpret_cast<char*>(reinterpret_cast<std::uintptr_t>(first) - static_cast<std::uintptr_t>(offset));
}

/// A stripe of a picture or a tile. In a flat picture each pixel has one sample, in a deep one as
/// many as `counts` says.
struct Stripe {
    PixelWindow window;
    std::vector<unsigned> counts;             // number of samples of each pixel; rows from top to bottom
    std::vector<std::vector<char*>> samples;  // for each channel and pixel, the first of its values
    // Memory that `samples` points to; empty for a stripe of the picture, which points to its tiles'.
    std::vector<std::vector<char>> storage;

    Stripe(const PixelWindow& box, std::size_t channels)
        : window(box), counts(box.pixelCount()), samples(channels, std::vector<char*>(box.pixelCount())) {}

    std::size_t at(int x, int y) const {
        return std::size_t(y - window.y0) * std::size_t(window.width()) + std::size_t(x - window.x0);
    }
};

bool isFiniteHalf(std::uint16_t bits) {
    constexpr std::uint16_t kExponent = 0x7c00;
    return (bits & kExponent) != kExponent;
}

template <typename Value, typename Check>
bool allOf(const std::vector<char>& bytes, const Check& check) {
    bool all = true;
    for (std::size_t i = 0; i + sizeof(Value) <= bytes.size(); i += sizeof(Value)) {
        Value value{};
        std::memcpy(&value, bytes.data() + i, sizeof value);
        all &= check(value);
    }
    return all;
}

bool holdsFinite(const Stripe& part, const std::vector<Channel>& channels) {
    for (std::size_t c = 0; c < part.storage.size(); ++c) {
        const std::vector<char>& bytes = part.storage[c];
        if (channels[c].type == Imf::HALF && !allOf<std::uint16_t>(bytes, isFiniteHalf)) return false;
        if (channels[c].type == Imf::FLOAT && !allOf<float>(bytes, isFinite)) return false;
    }
    return true;
}

/// An open tile, flat or deep.
class OpenTile {
  public:
    explicit OpenTile(const ExrTile& tile) : m_tile(tile), m_channels(channelsOf(tile.header)) {
        if (tile.data.empty()) return;
        if (tile.deep)
            m_deep = std::make_unique<Imf::DeepScanLineInputFile>(tile.path.c_str(), threadCount());
        else
            m_flat = std::make_unique<Imf::InputFile>(tile.path.c_str(), threadCount());
    }

    const ExrTile& tile() const { return m_tile; }

    /// The part of `rows` within the crop; 0 where the file has no pixels. Throws Error(input).
    Stripe read(const PixelWindow& rows) {
        try {
            return m_tile.deep ? readDeep(rows) : readFlat(rows);
        } catch (const std::bad_alloc&) {
            throw;
        } catch (const std::exception& exception) {
            throw Error(ErrorKind::input,
                        fmt::format("cannot read '{}': {}", m_tile.path, shortened(exception.what())));
        }
    }

  private:
    Stripe readFlat(const PixelWindow& rows) {
        Stripe part(intersection(m_tile.crop, rows), m_channels.size());
        const PixelWindow inside = intersection(m_tile.data, part.window);
        Imf::FrameBuffer frame;
        for (std::size_t c = 0; c < m_channels.size(); ++c) {
            const std::size_t bytes = m_channels[c].bytes;
            std::vector<char>& values = part.storage.emplace_back(part.window.pixelCount() * bytes);
            for (std::size_t i = 0; i < part.counts.size(); ++i) part.samples[c][i] = values.data() + i * bytes;
            frame.insert(m_channels[c].name, Imf::Slice(m_channels[c].type, baseOf(values.data(), part.window, bytes),
                                                        bytes, bytes * std::size_t(part.window.width())));
        }
        std::fill(part.counts.begin(), part.counts.end(), 1u);
        if (inside.empty()) return part;
        m_flat->setFrameBuffer(frame);
        m_flat->readPixels(inside.y0, inside.y1 - 1);
        return part;
    }

    Stripe readDeep(const PixelWindow& rows) {
        Stripe part(intersection(m_tile.crop, rows), m_channels.size());
        const PixelWindow inside = intersection(m_tile.data, part.window);
        if (inside.empty()) return part;
        const auto width = std::size_t(part.window.width());
        Imf::DeepFrameBuffer frame;
        frame.insertSampleCountSlice(Imf::Slice(Imf::UINT, baseOf(part.counts.data(), part.window, sizeof(unsigned)),
                                                sizeof(unsigned), sizeof(unsigned) * width));
        for (std::size_t c = 0; c < m_channels.size(); ++c)
            frame.insert(m_channels[c].name,
                         Imf::DeepSlice(m_channels[c].type, baseOf(part.samples[c].data(), part.window, sizeof(char*)),
                                        sizeof(char*), sizeof(char*) * width, m_channels[c].bytes));
        m_deep->setFrameBuffer(frame);
        m_deep->readPixelSampleCounts(inside.y0, inside.y1 - 1);
        std::size_t total = 0;
        for (const unsigned count : part.counts) total += count;
        for (std::size_t c = 0; c < m_channels.size(); ++c) {
            char* next = part.storage.emplace_back(total * m_channels[c].bytes).data();
            for (std::size_t i = 0; i < part.counts.size(); ++i) {
                part.samples[c][i] = next;
                next += part.counts[i] * m_channels[c].bytes;
            }
        }
        m_deep->readPixels(inside.y0, inside.y1 - 1);
        return part;
    }

    const ExrTile& m_tile;
    std::vector<Channel> m_channels;
    std::unique_ptr<Imf::InputFile> m_flat;
    std::unique_ptr<Imf::DeepScanLineInputFile> m_deep;
};

/// Joins stripes of the picture from those of its tiles.
class Joiner {
  public:
    explicit Joiner(const std::vector<ExrTile>& tiles) : m_channels(channelsOf(tiles.front().header)) {
        for (const ExrTile& tile : tiles) m_tiles.emplace_back(tile);
    }

    const std::vector<Channel>& channels() const { return m_channels; }
    const std::string& notFinite() const { return m_notFinite; }

    /// The result is valid until the next call.
    const Stripe& stripe(const PixelWindow& rows) {
        m_parts.clear();
        m_whole = std::make_unique<Stripe>(rows, m_channels.size());
        std::vector<const OpenTile*> before;
        for (OpenTile& tile : m_tiles) {
            if (intersection(tile.tile().crop, rows).empty()) continue;
            m_parts.push_back(std::make_unique<Stripe>(tile.read(rows)));
            if (m_notFinite.empty() && !holdsFinite(*m_parts.back(), m_channels)) m_notFinite = tile.tile().path;
            for (const OpenTile* other : before) compare(tile.tile(), other->tile(), *m_parts.back());
            paste(*m_parts.back());
            before.push_back(&tile);
        }
        return *m_whole;
    }

  private:
    void compare(const ExrTile& tile, const ExrTile& before, const Stripe& part) const {
        const PixelWindow shared = intersection(before.crop, part.window);
        for (int y = shared.y0; y < shared.y1; ++y)
            for (int x = shared.x0; x < shared.x1; ++x) {
                const std::size_t here = part.at(x, y), there = m_whole->at(x, y);
                const unsigned count = part.counts[here];
                if (count != m_whole->counts[there]) differ(tile, before, x, y, "number of samples");
                for (std::size_t c = 0; c < m_channels.size() && count > 0; ++c)
                    if (std::memcmp(part.samples[c][here], m_whole->samples[c][there], count * m_channels[c].bytes) !=
                        0)
                        differ(tile, before, x, y, fmt::format("channel '{}'", m_channels[c].name));
            }
    }

    [[noreturn]] static void differ(const ExrTile& tile, const ExrTile& before, int x, int y, const std::string& what) {
        throw Error(ErrorKind::input,
                    fmt::format("cannot merge '{}': it overlaps '{}', and at the pixel {},{} their {} "
                                "differs",
                                tile.path, before.path, x, y, what));
    }

    void paste(const Stripe& part) {
        for (int y = part.window.y0; y < part.window.y1; ++y) {
            const std::size_t from = part.at(part.window.x0, y), to = m_whole->at(part.window.x0, y);
            const auto width = std::size_t(part.window.width());
            std::copy_n(part.counts.data() + from, width, m_whole->counts.data() + to);
            for (std::size_t c = 0; c < m_channels.size(); ++c)
                std::copy_n(part.samples[c].data() + from, width, m_whole->samples[c].data() + to);
        }
    }

    std::vector<Channel> m_channels;
    std::vector<OpenTile> m_tiles;
    std::vector<std::unique_ptr<Stripe>> m_parts;
    std::unique_ptr<Stripe> m_whole;
    std::string m_notFinite;  // the first tile with infinite or NaN values
};

/// Calls `write` with the stripes of `window`, one after the other.
template <typename Write>
void forStripes(Joiner& joiner, const PixelWindow& window, const std::function<void()>& checkpoint,
                const Write& write) {
    for (int y = window.y0; y < window.y1; y += kRowsAtATime) {
        if (checkpoint) checkpoint();
        write(joiner.stripe({window.x0, y, window.x1, std::min(y + kRowsAtATime, window.y1)}));
    }
}

void writeFlat(CheckedStream& stream, const Imf::Header& header, const PixelWindow& window, Joiner& joiner,
               const std::function<void()>& checkpoint) {
    Imf::OutputFile out(stream, header, threadCount());
    const std::vector<Channel>& channels = joiner.channels();
    forStripes(joiner, window, checkpoint, [&](const Stripe& stripe) {
        Imf::FrameBuffer frame;
        std::vector<std::vector<char>> planes;
        for (std::size_t c = 0; c < channels.size(); ++c) {
            const std::size_t bytes = channels[c].bytes;
            std::vector<char>& plane = planes.emplace_back(stripe.counts.size() * bytes);
            for (std::size_t i = 0; i < stripe.counts.size(); ++i)
                if (stripe.counts[i] > 0) std::memcpy(plane.data() + i * bytes, stripe.samples[c][i], bytes);
            frame.insert(channels[c].name, Imf::Slice(channels[c].type, baseOf(plane.data(), stripe.window, bytes),
                                                      bytes, bytes * std::size_t(window.width())));
        }
        out.setFrameBuffer(frame);
        out.writePixels(stripe.window.height());
    });
}

void writeDeep(CheckedStream& stream, const Imf::Header& header, const PixelWindow& window, Joiner& joiner,
               const std::function<void()>& checkpoint) {
    Imf::DeepScanLineOutputFile out(stream, header, threadCount());
    const std::vector<Channel>& channels = joiner.channels();
    const auto width = std::size_t(window.width());
    forStripes(joiner, window, checkpoint, [&](const Stripe& stripe) {
        Imf::DeepFrameBuffer frame;
        frame.insertSampleCountSlice(Imf::Slice(Imf::UINT,
                                                baseOf(stripe.counts.data(), stripe.window, sizeof(unsigned)),
                                                sizeof(unsigned), sizeof(unsigned) * width));
        for (std::size_t c = 0; c < channels.size(); ++c)
            frame.insert(
                channels[c].name,
                Imf::DeepSlice(channels[c].type, baseOf(stripe.samples[c].data(), stripe.window, sizeof(char*)),
                               sizeof(char*), sizeof(char*) * width, channels[c].bytes));
        out.setFrameBuffer(frame);
        out.writePixels(stripe.window.height());
    });
}

/// The data window that a render of the whole would choose: around everything that is not empty, or
/// else the pixel at the corner.
PixelWindow windowOf(const std::vector<ExrTile>& tiles) {
    PixelWindow window, crops;
    for (const ExrTile& tile : tiles) {
        window.include(tile.data);
        crops.include(tile.crop);
    }
    return window.empty() ? PixelWindow{crops.x0, crops.y0, crops.x0 + 1, crops.y0 + 1} : window;
}

}  // namespace

MergedExr mergeExr(const std::vector<std::string>& paths, const std::string& path, const std::string& compression,
                   const std::function<void()>& checkpoint) {
    if (paths.empty()) throw Error(ErrorKind::usage, "there are no tiles to merge");
    std::vector<ExrTile> tiles;
    for (const std::string& tile : paths) tiles.push_back(readExrTile(tile));
    checkExrTiles(tiles);
    MergedExr merged;
    Imf::Header header = mergedExrHeader(tiles, merged.leftOut);
    merged.window = windowOf(tiles);
    merged.deep = tiles.front().deep;
    if (!compression.empty() && !merged.deep) header.compression() = exrCompressionNamed(compression);
    merged.lossyTwice = tiles.size() > 1 && header.compression() == Imf::DWAA_COMPRESSION &&
                        tiles.front().header.compression() == Imf::DWAA_COMPRESSION;
    if (merged.deep) header.setType(Imf::DEEPSCANLINE);
    header.dataWindow() = closedBox(merged.window);
    Joiner joiner(tiles);
    return writingExr(path, [&](AtomicFile& file) {
        CheckedStream stream(file.tempPath());
        if (merged.deep)
            writeDeep(stream, header, merged.window, joiner, checkpoint);
        else
            writeFlat(stream, header, merged.window, joiner, checkpoint);
        stream.close();
        merged.notFinite = joiner.notFinite();
        return merged;
    });
}

}  // namespace scrim
