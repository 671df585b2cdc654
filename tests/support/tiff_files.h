// SPDX-License-Identifier: Apache-2.0
// TIFF files of a few pages, written by hand: one strip a page, not compressed.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace scrim::test {

/// A file whose pages have the same header. Its members are what the header says.
struct TiffPages {
    std::uint32_t columns = 2, rows = 3;
    std::uint16_t bits = 8, format = 1, parts = 1, colours = 1, compression = 1, planar = 1;
    std::string description{};      ///< of the first page; "": none
    std::uint32_t isThumbnail = 0;  ///< 1 for the last page
    bool bigEndian = false;
    std::vector<std::string> pages{};  ///< the samples of each, in the file's order of bytes

    std::string bytes() const {
        std::string all = (bigEndian ? "MM" : "II") + word(42) + number(8);
        for (std::size_t k = 0; k < pages.size(); ++k) {
            const std::string text = k == 0 && !description.empty() ? description + '\0' : std::string();
            const bool isLast = k + 1 == pages.size();
            const auto data = static_cast<std::uint32_t>(all.size() + 2 + 12 * kTags + 4);
            const std::string bitsEach = parts == 1 ? "" : word(bits) + word(bits) + word(bits) + word(bits);
            const auto bitsAt = static_cast<std::uint32_t>(data + pages[k].size()),
                       textAt = static_cast<std::uint32_t>(bitsAt + bitsEach.size());
            std::string end = pages[k] + bitsEach + text;
            if (end.size() % 2 == 1) end += '\0';
            all += word(kTags) + entry(254, isLast ? isThumbnail : 0) + entry(256, columns) + entry(257, rows) +
                   (parts == 1 ? shortEntry(258, bits) : word(258) + word(3) + number(parts) + number(bitsAt)) +
                   shortEntry(259, compression) + shortEntry(262, colours) +
                   (text.empty() ? entry(65000, 0) : word(270) + word(2) + number(length(text)) + number(textAt)) +
                   entry(273, data) + shortEntry(277, parts) + entry(278, rows) + entry(279, length(pages[k])) +
                   shortEntry(284, planar) + shortEntry(339, format);
            all += number(isLast ? 0 : static_cast<std::uint32_t>(data + end.size())) + end;
        }
        return all;
    }

    std::string word(std::uint16_t value) const { return ordered({char(value & 0xff), char(value >> 8)}); }
    std::string number(std::uint32_t value) const {
        std::string out;
        for (int shift = 0; shift < 32; shift += 8) out += static_cast<char>(value >> shift & 0xff);
        return ordered(std::move(out));
    }

  private:
    static constexpr std::uint16_t kTags = 13;
    static std::uint32_t length(const std::string& text) { return static_cast<std::uint32_t>(text.size()); }
    std::string ordered(std::string bytes) const {
        if (bigEndian) std::reverse(bytes.begin(), bytes.end());
        return bytes;
    }
    std::string entry(std::uint16_t tag, std::uint32_t value) const {
        return word(tag) + word(4) + number(1) + number(value);
    }
    std::string shortEntry(std::uint16_t tag, std::uint16_t value) const {
        return word(tag) + word(3) + number(1) + word(value) + word(0);
    }
};

/// Pages of 2 x 3 samples of 8 bits whose value at (x, y) of page z is 1 + x + 2 y + 6 z.
inline TiffPages countingPages(int first = 0, int count = 4) {
    TiffPages file;
    for (int z = first; z < first + count; ++z) {
        file.pages.emplace_back();
        for (int i = 0; i < 6; ++i) file.pages.back() += static_cast<char>(1 + i + 6 * z);
    }
    return file;
}

/// A stack of 16 pages of 16 x 16 samples by ImageJ, 2 microns apart: a ball of 200 in one of 100, in noise.
inline TiffPages ballPages() {
    TiffPages file;
    file.columns = file.rows = 16;
    file.description = "ImageJ=1.54\nimages=16\nslices=16\nunit=um\nspacing=2\n";
    for (int z = 0; z < 16; ++z) {
        file.pages.emplace_back();
        for (int i = 0; i < 256; ++i) {
            const double r = std::hypot(i % 16 - 7.5, i / 16 - 7.5, z - 7.5);
            file.pages.back() += static_cast<char>(r < 3 ? 200 : r < 6 ? 100 : i % 3);
        }
    }
    return file;
}

/// Page `z` of ballPages() as a file of its own, which does not say how far samples are apart.
inline TiffPages ballSlice(std::size_t z) {
    TiffPages file = ballPages();
    file.description = "";
    file.pages = {file.pages[z]};
    return file;
}

}  // namespace scrim::test
