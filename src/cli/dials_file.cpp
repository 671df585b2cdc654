// SPDX-License-Identifier: Apache-2.0
#include "dials_file.h"

#include "text_file.h"

#include <scrim/base/atomic_file.h>
#include <scrim/base/error.h>
#include <scrim/scene/toml_document.h>

#include <fmt/format.h>

#include <array>
#include <fstream>
#include <sstream>
#include <string_view>

namespace scrim::cli {
namespace {

// Those that the promise of a preset chooses (verify/promise.h). A smaller value is more exact, but for directions.
constexpr std::array<std::string_view, 7> kChosen{"texel", "sheet_thickness", "opacity_cutoff",    "light_error",
                                                  "lod",   "scatter_cell",    "scatter_directions"};

}  // namespace

void ShotDials::add(const nlohmann::ordered_json& render) {
    ++m_frames;
    for (const std::string_view name : kChosen) {
        const std::string key(name);
        if (!render.contains(key) || !render[key].is_number()) continue;
        const bool known = m_dials.contains(key);
        const bool more = known && render[key] > m_dials[key];
        if (!known || more == (name == "scatter_directions")) m_dials[key] = render[key];
    }
}

void ShotDials::write(const std::string& path) const {
    std::string text =
        fmt::format("# The dials that scrim chose for {} frame{}.\n[render]\n", m_frames, m_frames == 1 ? "" : "s");
    for (const auto& [key, value] : m_dials.items()) text += fmt::format("{} = {}\n", key, value.dump());
    AtomicFile file(path);
    std::ofstream out(file.tempPath());
    if (!out.write(text.data(), static_cast<std::streamsize>(text.size())) || !out.flush())
        throw Error(ErrorKind::output, fmt::format("cannot write '{}'", path));
    out.close();
    file.commit();
}

std::vector<std::string> dialsOf(const std::string& path) {
    const toml::table table = parseToml(textOf(path), path);
    const toml::table* render = table["render"].as_table();
    if (render == nullptr || table.size() != 1)
        throw Error(ErrorKind::input, fmt::format("{}: expected one table, [render], as scrim plan --write-dials "
                                                  "writes it",
                                                  path));
    std::vector<std::string> overrides;
    for (const auto& [key, value] : *render) {
        std::ostringstream text;
        value.visit([&](const auto& node) { text << node; });
        overrides.push_back(fmt::format("render.{}={}", key.str(), text.str()));
    }
    return overrides;
}

}  // namespace scrim::cli
