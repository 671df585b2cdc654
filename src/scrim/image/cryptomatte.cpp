// SPDX-License-Identifier: Apache-2.0
#include <scrim/image/cryptomatte.h>

#include <fmt/format.h>
#include <murmurhash.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <bit>
#include <cstddef>

namespace scrim {
namespace {

const std::string kLayer = "CryptoObject";

std::uint32_t hashOf(const std::string& text) {
    std::uint32_t hash = 0;
    lmmh_x86_32(text.data(), static_cast<unsigned>(text.size()), 0, &hash);
    return hash;
}

}  // namespace

std::uint32_t cryptomatteId(const std::string& name) {
    const std::uint32_t hash = hashOf(name), exponent = hash >> 23 & 255;
    return exponent == 0 || exponent == 255 ? hash ^ 1u << 23 : hash;
}

std::vector<MatteLevel> cryptomatteLevels(const std::vector<MatteObject>& objects) {
    constexpr std::size_t kMost = 3, kPerLevel = 2;
    const std::size_t pixels = objects.empty() ? 0 : objects.front().coverage.size();
    const std::size_t count = std::clamp((objects.size() + kPerLevel - 1) / kPerLevel, std::size_t(1), kMost);
    std::vector<MatteLevel> levels(count);
    for (std::size_t l = 0; l < count; ++l) {
        levels[l].name = fmt::format("{}{:02}", kLayer, l);
        for (const char channel : {'R', 'G', 'B', 'A'})
            levels[l].channels.push_back(fmt::format("{}.{}", levels[l].name, channel));
        levels[l].data.resize(2 * kPerLevel * pixels);
    }
    std::vector<float> ids;
    for (const MatteObject& object : objects) ids.push_back(std::bit_cast<float>(cryptomatteId(object.name)));
    std::vector<std::size_t> order;
    for (std::size_t p = 0; p < pixels; ++p) {
        order.clear();
        for (std::size_t i = 0; i < objects.size(); ++i)
            if (objects[i].coverage[p] > 0) order.push_back(i);
        std::stable_sort(order.begin(), order.end(),
                         [&](std::size_t a, std::size_t b) { return objects[a].coverage[p] > objects[b].coverage[p]; });
        for (std::size_t rank = 0; rank < std::min(order.size(), kPerLevel * count); ++rank) {
            float* const to = levels[rank / kPerLevel].data.data() + 4 * p + 2 * (rank % kPerLevel);
            to[0] = ids[order[rank]];
            to[1] = std::min(objects[order[rank]].coverage[p], 1.0f);
        }
    }
    return levels;
}

std::vector<std::pair<std::string, std::string>> cryptomatteAttributes(const std::vector<std::string>& names) {
    nlohmann::json manifest = nlohmann::json::object();
    for (const std::string& name : names) manifest[name] = fmt::format("{:08x}", cryptomatteId(name));
    const std::string prefix = fmt::format("cryptomatte/{}/", fmt::format("{:08x}", hashOf(kLayer)).substr(0, 7));
    return {{prefix + "name", kLayer},
            {prefix + "hash", "MurmurHash3_32"},
            {prefix + "conversion", "uint32_to_float32"},
            {prefix + "manifest", manifest.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)}};
}

}  // namespace scrim
