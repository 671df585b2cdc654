// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/scene.h>

#include <cmath>

namespace scrim {

double FrameMap::fileAt(double frame) const {
    return std::round((keys.keys.empty() ? frame * speed : keys.at(frame)) + offset);
}

std::optional<int> FrameMap::frameOf(int file) const {
    const auto shows = [&](double frame) { return fileAt(frame) == file; };
    if (keys.keys.empty()) {
        // Several frames may show the file; the one at which its number is most nearly exact is among them.
        const double frame = speed == 0 ? 0 : std::round((file - offset) / speed);
        if (std::abs(frame) < 1e9 && shows(frame)) return static_cast<int>(frame);
        return std::nullopt;
    }
    for (std::size_t i = 0; i < keys.keys.size(); ++i) {
        const auto& [frame, value] = keys.keys[i];
        const auto& [next, nextValue] = keys.keys[std::min(i + 1, keys.keys.size() - 1)];
        const double slope = next == frame ? 0 : (nextValue - value) / (next - frame);
        for (const double at : {frame, slope == 0 ? frame : frame + (file - offset - value) / slope, next}) {
            const double whole = std::round(at);
            if (whole >= frame - 1 && whole <= next + 1 && shows(whole)) return static_cast<int>(whole);
        }
    }
    return std::nullopt;
}

}  // namespace scrim
