// SPDX-License-Identifier: Apache-2.0
// DICOM files of one slice, written by hand: explicit VR, little endian.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace scrim::test {

/// A slice of CT. Its members are what headers say; `samples` are stored values, row by row.
struct DicomSlice {
    std::string position = "0\\0\\0", directions = "1\\0\\0\\0\\1\\0", spacing = "1\\1", thickness = "2";
    std::string series = "1.2.3.1", syntax = "1.2.840.10008.1.2.1";
    std::string slope = "1", intercept = "-1024";
    std::string between;  ///< SpacingBetweenSlices; "": none
    std::string modality = kCt;
    /// Of each frame, "x\\y\\z", in the groups of attributes of Enhanced CT, which then hold directions and spacing,
    /// too.
    std::vector<std::string> framePositions;
    std::vector<std::string> frameSlopes;  ///< of each frame, beside `framePositions`; empty: `slope` for all
    std::uint16_t rows = 3, columns = 2, samplesPerPixel = 1, bitsStored = 16, isSigned = 1;
    int highBit = -1;  ///< -1: the one below `bitsStored`
    int frames = 1;
    std::vector<std::int16_t> samples = std::vector<std::int16_t>(6);

    std::string bytes() const {
        const std::string meta = text(2, 2, "UI", modality) + text(2, 3, "UI", "1.2.3.4") + text(2, 0x10, "UI", syntax);
        std::string all(128, '\0');
        all += "DICM" + tag(2, 0) + "UL" + number<std::uint16_t>(4) +
               number<std::uint32_t>(static_cast<std::uint32_t>(meta.size())) + meta;
        all += text(8, 0x16, "UI", modality) + text(8, 0x18, "UI", "1.2.3.4") + text(8, 0x60, "CS", "CT") +
               text(0x18, 0x50, "DS", thickness) + (between.empty() ? "" : text(0x18, 0x88, "DS", between)) +
               text(0x20, 0xd, "UI", "1.2.3") + text(0x20, 0xe, "UI", series);
        if (!position.empty()) all += text(0x20, 0x32, "DS", position) + text(0x20, 0x37, "DS", directions);
        all += word(0x28, 2, samplesPerPixel) + text(0x28, 4, "CS", samplesPerPixel == 1 ? "MONOCHROME2" : "RGB") +
               (frames == 1 ? "" : text(0x28, 8, "IS", std::to_string(frames))) + word(0x28, 0x10, rows) +
               word(0x28, 0x11, columns) + text(0x28, 0x30, "DS", spacing) + word(0x28, 0x100, 16) +
               word(0x28, 0x101, bitsStored) +
               word(0x28, 0x102, static_cast<std::uint16_t>(highBit < 0 ? bitsStored - 1 : highBit)) +
               word(0x28, 0x103, isSigned) + text(0x28, 0x1052, "DS", intercept) + text(0x28, 0x1053, "DS", slope);
        if (!framePositions.empty()) all += groups();
        if (syntax == kRle) {  // one fragment behind an empty table of offsets
            const std::string item = tag(0xfffe, 0xe000), pixels = runLengths();
            return all + tag(0x7fe0, 0x10) + "OB" + std::string(2, '\0') + number<std::uint32_t>(0xffffffff) + item +
                   number<std::uint32_t>(0) + item + number(static_cast<std::uint32_t>(pixels.size())) + pixels +
                   tag(0xfffe, 0xe0dd) + number<std::uint32_t>(0);
        }
        std::string pixels;
        for (const std::int16_t sample : samples) pixels += number(static_cast<std::uint16_t>(sample));
        return all + tag(0x7fe0, 0x10) + "OW" + std::string(2, '\0') +
               number(static_cast<std::uint32_t>(pixels.size())) + pixels;
    }

    static constexpr const char* kRle = "1.2.840.10008.1.2.5";                 ///< a syntax: RLE Lossless
    static constexpr const char* kCt = "1.2.840.10008.5.1.4.1.1.2";            ///< a modality: CT
    static constexpr const char* kEnhancedCt = "1.2.840.10008.5.1.4.1.1.2.1";  ///< CT of many frames
    static constexpr const char* kNuclear = "1.2.840.10008.5.1.4.1.1.20";      ///< nuclear medicine

  private:
    /// The samples' high bytes, then their low ones, each as a segment of runs (DICOM PS3.5, annex G): literal ones.
    std::string runLengths() const {
        std::string segments, header = number<std::uint32_t>(2);
        for (const int shift : {8, 0}) {
            header += number(static_cast<std::uint32_t>(64 + segments.size()));
            for (std::size_t i = 0; i < samples.size(); ++i) {
                if (i % 128 == 0) segments += static_cast<char>(std::min<std::size_t>(128, samples.size() - i) - 1);
                segments += static_cast<char>(static_cast<std::uint16_t>(samples[i]) >> shift & 0xff);
            }
            if (segments.size() % 2 == 1) segments += '\0';
        }
        return header + std::string(64 - header.size(), '\0') + segments;
    }
    /// Items of a sequence, each of a length that is given.
    static std::string sequence(std::uint16_t group, std::uint16_t element, const std::vector<std::string>& items) {
        std::string all;
        for (const std::string& item : items)
            all += tag(0xfffe, 0xe000) + number(static_cast<std::uint32_t>(item.size())) + item;
        return tag(group, element) + "SQ" + std::string(2, '\0') + number(static_cast<std::uint32_t>(all.size())) + all;
    }
    std::string groups() const {
        const std::string measures = text(0x18, 0x50, "DS", thickness) + text(0x28, 0x30, "DS", spacing);
        const auto lineOf = [&](const std::string& factor) {
            return sequence(0x28, 0x9145, {text(0x28, 0x1052, "DS", intercept) + text(0x28, 0x1053, "DS", factor)});
        };
        std::vector<std::string> own;
        for (std::size_t k = 0; k < framePositions.size(); ++k)
            own.push_back(sequence(0x20, 0x9113, {text(0x20, 0x32, "DS", framePositions[k])}) +
                          (frameSlopes.empty() ? "" : lineOf(frameSlopes[k])));
        return sequence(0x5200, 0x9229,
                        {sequence(0x20, 0x9116, {text(0x20, 0x37, "DS", directions)}) +
                         sequence(0x28, 0x9110, {measures}) + (frameSlopes.empty() ? lineOf(slope) : "")}) +
               sequence(0x5200, 0x9230, own);
    }

    template <typename T>
    static std::string number(T value) {
        std::string out;
        for (std::size_t i = 0; i < sizeof(T); ++i) out += static_cast<char>(value >> (8 * i) & 0xff);
        return out;
    }
    static std::string tag(std::uint16_t group, std::uint16_t element) { return number(group) + number(element); }
    static std::string text(std::uint16_t group, std::uint16_t element, const std::string& type, std::string value) {
        if (value.size() % 2 == 1) value += type == "UI" ? '\0' : ' ';
        return tag(group, element) + type + number(static_cast<std::uint16_t>(value.size())) + value;
    }
    static std::string word(std::uint16_t group, std::uint16_t element, std::uint16_t value) {
        return tag(group, element) + "US" + number<std::uint16_t>(2) + number(value);
    }
};

/// Slice `z` of a stack of 2 x 3 samples whose value at (x, y, z) is 1 + x + 2 y + 6 z, stored with 1024 added.
inline DicomSlice countingSlice(int z) {
    DicomSlice slice;
    slice.position = fmt::format("10\\20\\{}", 30 + 2.5 * z);
    slice.spacing = "0.5\\0.25";  // from row to row, from column to column
    for (int i = 0; i < 6; ++i) slice.samples[std::size_t(i)] = static_cast<std::int16_t>(1024 + 1 + i + 6 * z);
    return slice;
}

/// The slices `z` of countingSlice(), 0 to 3 unless `order` says otherwise, as the frames of one file.
inline DicomSlice countingFrames(const std::vector<int>& order = {0, 1, 2, 3}) {
    DicomSlice file = countingSlice(0);
    file.samples.clear();
    file.frames = static_cast<int>(order.size());
    for (const int z : order)
        for (const std::int16_t sample : countingSlice(z).samples) file.samples.push_back(sample);
    return file;
}

/// Slice `z` of 16 through a ball of bone in one of flesh in air, 1 mm a sample.
inline DicomSlice bodySlice(int z) {
    DicomSlice slice;
    slice.rows = slice.columns = 16;
    slice.position = fmt::format("0\\0\\{}", z);
    slice.samples.clear();
    for (int y = 0; y < 16; ++y)
        for (int x = 0; x < 16; ++x) {
            const double r = std::hypot(x - 7.5, y - 7.5, z - 7.5);
            slice.samples.push_back(static_cast<std::int16_t>(1024 + (r < 3 ? 900 : r < 6 ? 50 : -1000)));
        }
    return slice;
}

}  // namespace scrim::test
