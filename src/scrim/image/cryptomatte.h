// SPDX-License-Identifier: Apache-2.0
// Cryptomatte: mattes of objects by their names, as compositing programs read them (Friedman and
// Jones 2015, and its specification, version 1.2.0).
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace scrim {

/// An object's name and its part of each pixel, 0 to 1.
struct MatteObject {
    std::string name;
    std::vector<float> coverage;
};

/// Channels of an EXR: RGBA is the id and the coverage of one object, and those of the next one.
struct MatteLevel {
    std::string name;                   ///< "CryptoObject00"
    std::vector<std::string> channels;  ///< four names
    std::vector<float> data;            ///< four floats per pixel, which must be written as 32-bit floats, losslessly
};

/// The number whose bits, as a float, stand for the name: its MurmurHash3 (32 bits, seed 0),
/// without those that would be NaN, infinite or denormal.
std::uint32_t cryptomatteId(const std::string& name);

/// Ranks the objects of each pixel by coverage, the largest first. There are levels for all
/// objects, but at most three, for six of them.
std::vector<MatteLevel> cryptomatteLevels(const std::vector<MatteObject>& objects);

/// The attributes of the EXR's header: names and values. The manifest lists `names`.
std::vector<std::pair<std::string, std::string>> cryptomatteAttributes(const std::vector<std::string>& names);

}  // namespace scrim
