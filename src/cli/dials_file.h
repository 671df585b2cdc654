// SPDX-License-Identifier: Apache-2.0
// The dials of a shot: what `scrim plan --write-dials` chose for its frames, so that all of them, wherever they are
// rendered, have the same.
#pragma once

#include <nlohmann/json.hpp>

#include <string>
#include <vector>

namespace scrim::cli {

/// Collects the dials of frames; of each, the value that is the most exact in any of them.
class ShotDials {
  public:
    /// `render`: the dials of a plan (engine/plan/report.h).
    void add(const nlohmann::ordered_json& render);
    /// Writes a TOML file with the table [render]. Throws Error(output).
    void write(const std::string& path) const;

  private:
    int m_frames = 0;
    nlohmann::ordered_json m_dials;
};

/// The table [render] of such a file as overrides, "render.texel=0.4". Throws Error(input) where the file cannot be
/// read or has anything else.
std::vector<std::string> dialsOf(const std::string& path);

}  // namespace scrim::cli
