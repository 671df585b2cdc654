// SPDX-License-Identifier: Apache-2.0
// Drawn scenes obey their laws. SCRIM_LAWS_SEED and SCRIM_LAWS_COUNT draw others (tests/tools/laws.sh).
// SCRIM_LAWS_SHRINK=0 shows what is broken as it was drawn.
#include "laws.h"

#include <scrim/base/error.h>
#include <scrim/scene/scene_keys.h>

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <iostream>
#include <mutex>
#include <set>
#include <thread>

namespace scrim::test {
namespace {

std::uint64_t numberOf(const char* name, std::uint64_t otherwise) {
    const char* text = std::getenv(name);
    return text ? std::strtoull(text, nullptr, 10) : otherwise;
}

// Three laws a scene. What is broken is made as plain as possible before it is shown.
TEST(DrawnScenes, ObeyTheirLaws) {
    const std::uint64_t first = numberOf("SCRIM_LAWS_SEED", 1), count = numberOf("SCRIM_LAWS_COUNT", 200);
    const bool shrink = numberOf("SCRIM_LAWS_SHRINK", 1) != 0;
    Coverage all;
    std::map<std::uint64_t, BrokenLaw> broken;
    std::atomic<std::uint64_t> next{0};
    std::mutex mutex;
    const auto work = [&] {
        Coverage own;
        for (std::uint64_t i = next++; i < count; i = next++) {
            if (const std::optional<BrokenLaw> found = checkSeed(first + i, 3, own)) {
                const BrokenLaw least = shrink ? shrunk(*found) : *found;
                const std::lock_guard lock(mutex);
                broken[found->seed] = least;
            }
        }
        const std::lock_guard lock(mutex);
        all += own;
    };
    std::vector<std::thread> threads(std::max(std::thread::hardware_concurrency(), 1u));
    for (std::thread& thread : threads) thread = std::thread(work);
    for (std::thread& thread : threads) thread.join();
    std::cout << all.text();
    for (const auto& [seed, least] : broken)
        ADD_FAILURE() << "seed " << seed << " breaks " << least.law << ": " << least.what << "\n" << least.toml;
}

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
