// SPDX-License-Identifier: Apache-2.0
// Drawn scenes obey their laws. SCRIM_LAWS_SEED and SCRIM_LAWS_COUNT draw others (tests/tools/laws.sh).
#include "laws.h"

#include <scrim/base/error.h>
#include <scrim/scene/scene_keys.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <iostream>

namespace scrim::test {
namespace {

std::uint64_t numberOf(const char* name, std::uint64_t otherwise) {
    const char* text = std::getenv(name);
    return text ? std::strtoull(text, nullptr, 10) : otherwise;
}

// Two laws a scene; several tests, so that a part of them can be run alone.
class Laws : public testing::TestWithParam<int> {};
constexpr int kParts = 10;

TEST_P(Laws, HoldInDrawnScenes) {
    const std::uint64_t first = numberOf("SCRIM_LAWS_SEED", 1), count = numberOf("SCRIM_LAWS_COUNT", 200);
    Coverage coverage;
    for (std::uint64_t i = std::uint64_t(GetParam()); i < count; i += kParts) {
        const std::optional<BrokenLaw> broken = checkSeed(first + i, 2, coverage);
        if (!broken) continue;
        const BrokenLaw least = shrunk(*broken);
        ADD_FAILURE() << "seed " << least.seed << " breaks " << least.law << ": " << least.what << "\n" << least.toml;
    }
    if (std::getenv("SCRIM_LAWS_COUNT")) std::cout << coverage.text();
}
INSTANTIATE_TEST_SUITE_P(Drawn, Laws, testing::Range(0, kParts));

// A key that nobody draws is a key whose combinations nobody tests.
TEST(DrawnScenes, StateEveryKeyOfTheSchemaOrSayWhyNot) {
    std::set<std::string> drawn;
    for (std::uint64_t seed = 1; seed <= 600; ++seed) {
        try {
            drawn.merge(drawnScene(Draws::numbersOf(seed, kSections + 1)).parts);
        } catch (const Error&) {
        }
    }
    const auto states = [&](const std::string& key) {
        return std::ranges::any_of(drawn, [&](const std::string& part) {
            return part == key || part.starts_with(key + ".") || part.ends_with("." + key);
        });
    };
    std::string missing;
    for (const Section* section : sceneSections())
        for (const Key& key : section->keys()) {
            const std::string name = section->topic() + "." + key.name;
            const bool exempt = std::ranges::any_of(undrawnKeys(), [&](const auto& of) {
                return of.first == name || (of.first.ends_with(".") && name.starts_with(of.first));
            });
            if (!exempt && !states(name)) missing += name + " ";
        }
    EXPECT_EQ(missing, "");
}

}  // namespace
}  // namespace scrim::test
