// SPDX-License-Identifier: Apache-2.0
// Laws that every picture obeys, whatever is in the scene: light adds up, what is nothing changes nothing, the unit of
// length does not matter. They need no reference picture, so they can be asked of any combination of features.
#pragma once

#include "drawn_scene.h"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace scrim::test {

struct Law {
    std::string name;
    /// What is wrong, or nothing. Throws Skipped where the law says nothing about the scene, or would take too long.
    std::optional<std::string> (*check)(const DrawnScene& scene, Draws& draws);
    /// The share of drawn scenes that it says something about, about: a rare law is asked of most of them.
    double share = 1;
    /// Scenes with all of these are asked more often.
    std::vector<std::string> parts = {};
};
const std::vector<Law>& laws();

struct Skipped {};

/// A scene that breaks a law.
struct BrokenLaw {
    std::uint64_t seed = 0;
    std::string law, what, toml;
};

/// What was looked at.
struct Coverage {
    int scenes = 0, refused = 0, renders = 0;
    std::map<std::string, int> lawsChecked, lawsSkipped;
    std::map<std::pair<std::string, std::string>, int> pairs;  ///< of parts in one scene
    std::map<std::string, int> parts;

    Coverage& operator+=(const Coverage& o);
    /// Counts, and the pairs of frequent parts that no scene had.
    std::string text() const;
};

/// Draws a scene by `seed`, and checks `count` laws that apply, chosen by the seed, rare ones sooner.
std::optional<BrokenLaw> checkSeed(std::uint64_t seed, int count, Coverage& coverage);

/// The same with the scene made as plain as possible while it still breaks the law.
BrokenLaw shrunk(const BrokenLaw& broken);

}  // namespace scrim::test
