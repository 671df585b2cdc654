// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/frame_range.h>

#include <scrim/base/error.h>

#include <fmt/format.h>

#include <charconv>
#include <string_view>
#include <unordered_set>

namespace scrim {
namespace {

constexpr std::size_t kMostFrames = 1'000'000;
/// The largest frame. It keeps every sum of a frame, a step and an offset within an int.
constexpr int kLargestFrame = 1'000'000'000;

/// Parses one part of a range from left to right.
class Reader {
  public:
    Reader(const std::string& whole, std::string_view part) : m_whole(whole), m_part(part), m_rest(part) {}

    int number(const char* what) {
        int value = 0;
        const auto [stop, error] = std::from_chars(m_rest.data(), m_rest.data() + m_rest.size(), value);
        if (error == std::errc::result_out_of_range || value > kLargestFrame || value < -kLargestFrame)
            fail(fmt::format("{} is beyond {}", what, kLargestFrame));
        if (error != std::errc()) fail(fmt::format("{} is not a whole number", what));
        m_rest.remove_prefix(std::size_t(stop - m_rest.data()));
        return value;
    }
    bool skip(char c) {
        if (m_rest.empty() || m_rest.front() != c) return false;
        m_rest.remove_prefix(1);
        return true;
    }
    bool atEnd() const { return m_rest.empty(); }

    [[noreturn]] void fail(const std::string& problem) const {
        throw Error(ErrorKind::usage,
                    fmt::format("frame range '{}': in '{}' {}; expected frames and ranges such as 1-48x2,60",
                                shortened(m_whole, 80), shortened(m_part, 40), problem));
    }

  private:
    const std::string& m_whole;
    std::string_view m_part, m_rest;
};

std::string_view trimmed(std::string_view text) {
    while (!text.empty() && text.front() == ' ') text.remove_prefix(1);
    while (!text.empty() && text.back() == ' ') text.remove_suffix(1);
    return text;
}

}  // namespace

std::vector<int> parseFrameRange(const std::string& text) {
    if (text.find(':') != std::string::npos)
        throw Error(ErrorKind::usage, fmt::format("frame range '{}': ':' is not supported, because farm managers "
                                                  "interpret it differently; write 1-48x2 for every second frame",
                                                  shortened(text, 80)));
    std::vector<int> frames;
    std::unordered_set<int> seen;
    std::string_view rest = text;
    for (bool more = true; more;) {
        const std::size_t comma = rest.find(',');
        more = comma != std::string_view::npos;
        Reader part(text, trimmed(rest.substr(0, comma)));
        if (more) rest.remove_prefix(comma + 1);

        const int first = part.number("the first frame");
        int last = first, step = 1;
        if (part.skip('-')) {
            last = part.number("the last frame");
            if (part.skip('x')) step = part.number("the step");
        }
        if (!part.atEnd()) part.fail("there is unexpected text after the frames");
        if (step < 1) part.fail("the step is not at least 1");
        if (last < first) part.fail("the last frame comes before the first");
        for (int frame = first; frame <= last; frame += step) {
            if (!seen.insert(frame).second) continue;
            if (frames.size() == kMostFrames) part.fail(fmt::format("there are more than {} frames", kMostFrames));
            frames.push_back(frame);
        }
    }
    return frames;
}

}  // namespace scrim
