// SPDX-License-Identifier: Apache-2.0
// Values as TOML text, for code that writes a scene instead of reading one.
#pragma once

#include <scrim/geometry/spaces.h>

#include <cstddef>
#include <string>

namespace scrim {

/// `text` as a quoted TOML string; bytes that are not UTF-8 are replaced as by asUtf8.
std::string tomlString(const std::string& text);

/// `v` rounded to a multiple of 10^exponent, in as few characters as possible.
std::string tomlRounded(double v, int exponent);
std::string tomlRounded(const Vec3& v, int exponent);

/// `v` with `digits` significant digits.
std::string tomlSignificant(double v, int digits);
/// The number of bytes at the start of `text` that are valid UTF-8, which all TOML must be; all of
/// them if `text` is valid.
std::size_t utf8Length(const std::string& text);
bool isUtf8(const std::string& text);

/// `text` with '?' in place of each byte that is not part of valid UTF-8.
std::string asUtf8(std::string text);

}  // namespace scrim
