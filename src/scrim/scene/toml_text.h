// SPDX-License-Identifier: Apache-2.0
// Values as TOML text, for whoever writes a scene instead of reading one.
#pragma once

#include <scrim/geometry/spaces.h>

#include <cstddef>
#include <string>

namespace scrim {

/// `text` as a string of TOML, in quotes; as `asUtf8`.
std::string tomlString(const std::string& text);

/// `v` rounded to a multiple of 10^exponent, in as few characters as tell that.
std::string tomlRounded(double v, int exponent);
std::string tomlRounded(const Vec3& v, int exponent);

/// `v` with so many significant digits.
std::string tomlSignificant(double v, int digits);
/// Bytes at the start of `text` that are UTF-8, as all TOML is: all of them, or those before the first that is not.
std::size_t utf8Length(const std::string& text);
bool isUtf8(const std::string& text);

/// `text` with '?' for each byte that is no part of UTF-8.
std::string asUtf8(std::string text);

/// TOML that a formatter wrote, with every number as short as it can be said: 1.6 for 1.6000000000000001.
std::string withShortNumbers(const std::string& toml);

}  // namespace scrim
