// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/scene.h>

#include <cmath>

namespace scrim {

namespace {

constexpr double kExact = 1e-6;  // of a file: numbers as near as this to a whole one are that file

}  // namespace

double FrameMap::numberAt(double frame) const {
    return (keys.keys.empty() ? frame * speed : keys.at(frame)) + offset;
}

double FrameMap::fileAt(double frame) const {
    const double number = numberAt(frame), nearest = std::round(number);
    const bool exact = between == BetweenFiles::nearest || std::abs(number - nearest) < kExact;
    return exact ? nearest : std::floor(number);
}

double FrameMap::beyondAt(double frame) const {
    const double number = numberAt(frame), file = fileAt(frame);
    return between == BetweenFiles::nearest || std::abs(number - file) < kExact ? 0 : number - file;
}

std::optional<int> FrameMap::frameOf(int file) const {
    const auto shows = [&](double frame) { return fileAt(frame) == file; };
    if (keys.keys.empty()) {
        // Several frames may show the file; the one at which its number is most nearly exact is among them.
        const double exact = speed == 0 ? 0 : (file - offset) / speed;
        for (const double frame : {std::round(exact), std::floor(exact), std::ceil(exact)})
            if (std::abs(frame) < 1e9 && shows(frame)) return static_cast<int>(frame);
        return std::nullopt;
    }
    for (std::size_t i = 0; i < keys.keys.size(); ++i) {
        const auto& [frame, value] = keys.keys[i];
        const auto& [next, nextValue] = keys.keys[std::min(i + 1, keys.keys.size() - 1)];
        const double slope = next == frame ? 0 : (nextValue - value) / (next - frame);
        for (const double at : {frame, slope == 0 ? frame : frame + (file - offset - value) / slope, next}) {
            for (const double whole : {std::round(at), std::floor(at), std::ceil(at)})
                if (whole >= frame - 1 && whole <= next + 1 && shows(whole)) return static_cast<int>(whole);
        }
    }
    return std::nullopt;
}

}  // namespace scrim
