// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/frame_path.h>

#include <scrim/base/error.h>

#include <fmt/format.h>
#include <fmt/printf.h>

#include <algorithm>
#include <cctype>
#include <charconv>
#include <filesystem>
#include <string_view>
#include <system_error>

namespace scrim {
namespace {

/// The most digits that a frame is padded to. More than any frame has would only make names longer
/// than file systems allow.
constexpr int kMostDigits = 20;
/// Characters with a meaning in patterns; a '$' before one of them stands for the character itself.
constexpr std::string_view kSpecial = "$#%";

/// One part of a pattern, which is a sequence of literal texts and places for the frame.
struct Piece {
    std::string literal;
    int digits = 0;  ///< 0: a literal; otherwise the frame with at least so many digits
};

bool isDigit(char c) {
    return c >= '0' && c <= '9';
}

std::size_t digitsAt(const std::string& text, std::size_t i) {
    std::size_t end = i;
    while (end < text.size() && isDigit(text[end])) ++end;
    return end - i;
}

int widthOf(std::string_view digits) {
    int width = 1;
    std::from_chars(digits.data(), digits.data() + digits.size(), width);
    return std::clamp(width, 1, kMostDigits);
}

/// The place for the frame that starts at `i`, and its length in bytes; no value where none starts.
std::optional<std::pair<Piece, std::size_t>> placeAt(const std::string& pattern, std::size_t i) {
    if (pattern[i] == '#') {
        const std::size_t end = std::min(pattern.find_first_not_of('#', i), pattern.size());
        return {{Piece{"", std::min(static_cast<int>(end - i), kMostDigits)}, end - i}};
    }
    if (pattern[i] == '$' && i + 1 < pattern.size() && pattern[i + 1] == 'F') {
        const std::size_t digits = digitsAt(pattern, i + 2);
        return {{Piece{"", widthOf(std::string_view(pattern).substr(i + 2, digits))}, 2 + digits}};
    }
    if (pattern[i] == '%') {
        // "%d" and "%04d" are places for the frame; "%4d", which pads with blanks, is literal text.
        const std::size_t digits = digitsAt(pattern, i + 1), end = i + 1 + digits;
        if (end < pattern.size() && pattern[end] == 'd' && (digits == 0 || (pattern[i + 1] == '0' && digits > 1)))
            return {{Piece{"", widthOf(std::string_view(pattern).substr(i + 1, digits))}, end + 1 - i}};
    }
    return std::nullopt;
}

/// The number of bytes of the character at `i`: 2 for "$$", "$#" and "$%", else 1.
std::size_t characterAt(const std::string& pattern, std::size_t i) {
    return pattern[i] == '$' && i + 1 < pattern.size() && kSpecial.find(pattern[i + 1]) != kSpecial.npos ? 2 : 1;
}

std::vector<Piece> piecesOf(const std::string& pattern) {
    std::vector<Piece> pieces;
    const auto literal = [&](char c) {
        if (pieces.empty() || pieces.back().digits > 0) pieces.emplace_back();
        pieces.back().literal += c;
    };
    for (std::size_t i = 0; i < pattern.size();) {
        if (const auto place = placeAt(pattern, i)) {
            pieces.push_back(place->first);
            i += place->second;
        } else {
            i += characterAt(pattern, i);
            literal(pattern[i - 1]);
        }
    }
    return pieces;
}

std::string frameText(int frame, int digits) {
    return fmt::sprintf("%0*d", digits, frame);
}

std::string expanded(const std::vector<Piece>& pieces, int frame) {
    std::string path;
    for (const Piece& piece : pieces) path += piece.digits > 0 ? frameText(frame, piece.digits) : piece.literal;
    return path;
}

bool isNameCharacter(char c, bool first) {
    return c == '_' || std::isalpha(static_cast<unsigned char>(c)) || (!first && isDigit(c));
}

[[noreturn]] void refuse(const std::string& where, const std::string& pattern, const std::string& problem) {
    throw Error(ErrorKind::input, fmt::format("{}: the path '{}' {}", where, shortened(pattern, 120), problem));
}

/// The frame number in `name`; no value where `name` does not match the pattern.
std::optional<int> frameIn(const std::string& name, const std::vector<Piece>& pieces) {
    std::size_t start = 0;
    for (const Piece& piece : pieces) {
        if (piece.digits > 0) break;
        start += piece.literal.size();
    }
    if (start >= name.size()) return std::nullopt;
    int frame = 0;
    if (std::from_chars(name.data() + start, name.data() + name.size(), frame).ec != std::errc()) return std::nullopt;
    return expanded(pieces, frame) == name ? std::optional<int>(frame) : std::nullopt;
}

/// The name that `pattern` stands for if its places for the frame are taken literally.
std::string nameOf(const std::string& pattern) {
    std::string name;
    for (std::size_t i = 0; i < pattern.size();) {
        i += characterAt(pattern, i);
        name += pattern[i - 1];
    }
    return name;
}

}  // namespace

std::string expandVariables(const std::string& pattern, const VariableLookup& lookup, const std::string& where) {
    std::string out;
    for (std::size_t i = 0; i < pattern.size(); ++i) {
        if (pattern[i] != '$') {
            out += pattern[i];
            continue;
        }
        const char next = i + 1 < pattern.size() ? pattern[i + 1] : '\0';
        if (characterAt(pattern, i) == 2) {
            out += {'$', next};
            ++i;
        } else if (next == '{') {
            const std::size_t end = pattern.find('}', i);
            if (end == std::string::npos) refuse(where, pattern, "has '${' without '}'");
            const std::string name = pattern.substr(i + 2, end - i - 2);
            bool good = !name.empty();
            for (std::size_t k = 0; k < name.size(); ++k) good = good && isNameCharacter(name[k], k == 0);
            if (!good)
                refuse(where, pattern,
                       fmt::format("has '${{{}}}'; a variable's name is letters, digits and '_'", shortened(name, 40)));
            const auto value = lookup(name);
            if (!value)
                refuse(where, pattern,
                       fmt::format("names the variable '{}', which is neither in [variables] nor in the environment",
                                   name));
            out += *value;
            i = end;
        } else if (next == 'F' && (i + 2 >= pattern.size() || !isNameCharacter(pattern[i + 2], true))) {
            out += '$';
        } else {
            refuse(where, pattern, "has an invalid '$'; expected ${NAME}, $F, $F4, $$ (a dollar sign), $# or $%");
        }
    }
    return out;
}

std::string patternOf(const std::string& path) {
    std::string pattern;
    for (const char c : path) {
        if (kSpecial.find(c) != kSpecial.npos) pattern += '$';
        pattern += c;
    }
    return pattern;
}

std::string absolutePattern(const std::string& folder, const std::string& pattern) {
    const std::filesystem::path whole = std::filesystem::absolute(folder.empty() ? "." : folder);
    return pathIn(patternOf(whole.lexically_normal().string()), pattern);
}

bool hasFrame(const std::string& pattern) {
    const std::vector<Piece> pieces = piecesOf(pattern);
    return std::any_of(pieces.begin(), pieces.end(), [](const Piece& piece) { return piece.digits > 0; });
}

std::string withoutFrame(const std::string& pattern) {
    std::string rest;
    for (const Piece& piece : piecesOf(pattern)) rest += piece.literal;
    return rest;
}

std::string expandFrame(const std::string& pattern, int frame) {
    return expanded(piecesOf(pattern), frame);
}

std::string pathIn(const std::string& folder, const std::string& path) {
    if (folder.empty() || path.empty() || path.front() == '/') return path;
    return (std::filesystem::path(folder) / path).string();
}

bool FramePath::hasFrame() const {
    if (!outputHasFrame()) return false;
    std::error_code ignored;
    return !std::filesystem::exists(pathIn(folder, nameOf(pattern)), ignored);
}

std::string FramePath::at(int frame) const {
    if (outputHasFrame() && !hasFrame()) return pathIn(folder, nameOf(pattern));
    return outputAt(frame);
}

std::string FramePath::outputAt(int frame) const {
    return pathIn(folder, expandFrame(pattern, frame));
}

std::vector<int> existingFrames(const FramePath& path) {
    if (!path.hasFrame()) return {};
    const std::size_t slash = path.pattern.rfind('/');
    const std::string folder = slash == std::string::npos ? "" : path.pattern.substr(0, slash + 1);
    const std::string name = slash == std::string::npos ? path.pattern : path.pattern.substr(slash + 1);
    if (!hasFrame(name) || hasFrame(folder)) return {};

    std::vector<int> frames;
    const std::vector<Piece> pieces = piecesOf(name);
    const std::string place = folder.empty() ? path.folder : pathIn(path.folder, expandFrame(folder, 0));
    std::error_code error;
    std::filesystem::directory_iterator entry(place.empty() ? "." : place, error);
    for (; !error && entry != std::filesystem::directory_iterator(); entry.increment(error))
        if (const auto frame = frameIn(entry->path().filename().string(), pieces)) frames.push_back(*frame);
    std::sort(frames.begin(), frames.end());
    return frames;
}

}  // namespace scrim
