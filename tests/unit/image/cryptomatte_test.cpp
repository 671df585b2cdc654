// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/cryptomatte.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <bit>
#include <cmath>

namespace scrim {
namespace {

TEST(Cryptomatte, HashesNamesAsItsSpecificationDoes) {
    // Known values of MurmurHash3 (32 bits, seed 0).
    EXPECT_EQ(cryptomatteId("hello"), 0x248bfa47u);
    EXPECT_EQ(cryptomatteId("hello, world"), 0x149bbb7fu);
    // Whatever the name is, its id is a number that programs keep.
    for (int i = 0; i < 5000; ++i) {
        const float id = std::bit_cast<float>(cryptomatteId("volume" + std::to_string(i)));
        ASSERT_TRUE(std::isnormal(id)) << i;
    }
}

TEST(Cryptomatte, RanksObjectsByTheirPartOfThePixel) {
    const auto id = [](const char* name) { return std::bit_cast<float>(cryptomatteId(name)); };
    const auto levels = cryptomatteLevels({{"a", {0.1f, 0, 0.5f}}, {"b", {0.6f, 0, 0.5f}}, {"c", {0.3f, 0, 0}}});
    ASSERT_EQ(levels.size(), 2u);
    EXPECT_EQ(levels[0].channels, (std::vector<std::string>{"CryptoObject00.R", "CryptoObject00.G", "CryptoObject00.B",
                                                            "CryptoObject00.A"}));
    EXPECT_EQ(levels[0].data,
              (std::vector<float>{id("b"), 0.6f, id("c"), 0.3f, 0, 0, 0, 0, id("a"), 0.5f, id("b"), 0.5f}));
    EXPECT_EQ(levels[1].data, (std::vector<float>{id("a"), 0.1f, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}));
    EXPECT_EQ(cryptomatteLevels(std::vector<MatteObject>(20, {"a", {1}})).size(), 3u);
}

TEST(Cryptomatte, ManifestNamesTheIds) {
    const auto attributes = cryptomatteAttributes({"smoke", "a \"b\""});
    ASSERT_EQ(attributes.size(), 4u);
    EXPECT_EQ(attributes[0], (std::pair<std::string, std::string>{"cryptomatte/3ae39a5/name", "CryptoObject"}));
    const auto manifest = nlohmann::json::parse(attributes[3].second);
    for (const auto& [name, id] : manifest.items())
        EXPECT_EQ(std::stoul(id.get<std::string>(), nullptr, 16), cryptomatteId(name)) << name;
    EXPECT_EQ(manifest.size(), 2u);
}

}  // namespace
}  // namespace scrim
