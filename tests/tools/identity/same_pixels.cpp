// SPDX-License-Identifier: Apache-2.0
// Are the pixels of two OpenEXR files the same, bit by bit, in all channels? Prints what differs, and how much.
//
//     scrim_same_pixels [--within RELATIVE] A.exr B.exr      RELATIVE: to the brightest value of A's channel
//     scrim_same_pixels --list A.exr B.exr                   prints each channel and its largest relative difference
#include <OpenImageIO/imagebuf.h>

#include <bit>
#include <cmath>
#include <cstdint>
#include <string>
#include <vector>

#include <fmt/format.h>

namespace {

struct Pixels {
    OIIO::ImageSpec spec;
    std::vector<float> values;  // channels interleaved
};

Pixels read(const std::string& path) {
    OIIO::ImageBuf image(path);
    if (!image.read(0, 0, true, OIIO::TypeDesc::FLOAT)) throw std::runtime_error(path + ": " + image.geterror());
    Pixels pixels{image.spec(), {}};
    pixels.values.resize(image.spec().image_pixels() * static_cast<std::size_t>(image.spec().nchannels));
    image.get_pixels(image.roi(), OIIO::TypeDesc::FLOAT, pixels.values.data());
    return pixels;
}

struct Difference {
    std::size_t pixels = 0;
    double largest = 0, brightest = 0;

    double relative() const { return brightest > 0 ? largest / brightest : largest; }
};

Difference compare(const Pixels& a, const Pixels& b, std::size_t channel) {
    Difference found;
    for (std::size_t i = channel; i < a.values.size(); i += static_cast<std::size_t>(a.spec.nchannels)) {
        const float x = a.values[i], y = b.values[i];
        if (std::isfinite(x)) found.brightest = std::fmax(found.brightest, std::fabs(x));
        if (std::bit_cast<std::uint32_t>(x) == std::bit_cast<std::uint32_t>(y)) continue;
        ++found.pixels;
        const double apart = std::fabs(double(x) - double(y));
        found.largest = std::isnan(apart) ? INFINITY : std::fmax(found.largest, apart);
    }
    return found;
}

bool samePixels(const std::string& first, const std::string& second, double within) {
    const Pixels a = read(first), b = read(second);
    if (a.spec.channelnames != b.spec.channelnames || !(a.spec.roi() == b.spec.roi())) {
        fmt::print("{}: another window or other channels\n", second);
        return false;
    }
    bool same = true;
    for (std::size_t c = 0; c < a.spec.channelnames.size(); ++c) {
        const Difference d = compare(a, b, c);
        if (d.pixels == 0 || (within > 0 && d.relative() <= within)) continue;
        fmt::print("{}: channel {}: {} pixels differ, by up to {:.3g} of the brightest\n", second,
                   a.spec.channelnames[c], d.pixels, d.relative());
        same = false;
    }
    return same;
}

void listDifferences(const std::string& first, const std::string& second) {
    const Pixels a = read(first), b = read(second);
    if (a.spec.channelnames != b.spec.channelnames || !(a.spec.roi() == b.spec.roi()))
        throw std::runtime_error(second + ": another window or other channels");
    for (std::size_t c = 0; c < a.spec.channelnames.size(); ++c)
        fmt::print("{} {:.3g}\n", a.spec.channelnames[c], compare(a, b, c).relative());
}

}  // namespace

int main(int argc, char** argv) {
    std::vector<std::string> files;
    double within = 0;
    bool list = false;
    for (int i = 1; i < argc; ++i) {
        if (std::string(argv[i]) == "--within" && i + 1 < argc)
            within = std::stod(argv[++i]);
        else if (std::string(argv[i]) == "--list")
            list = true;
        else
            files.emplace_back(argv[i]);
    }
    if (files.size() != 2) {
        fmt::print(stderr, "usage: scrim_same_pixels [--within RELATIVE | --list] A.exr B.exr\n");
        return 2;
    }
    try {
        if (!list) return samePixels(files[0], files[1], within) ? 0 : 1;
        listDifferences(files[0], files[1]);
        return 0;
    } catch (const std::exception& error) {
        fmt::print(stderr, "scrim_same_pixels: {}\n", error.what());
        return 2;
    }
}
