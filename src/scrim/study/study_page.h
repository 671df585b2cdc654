// SPDX-License-Identifier: Apache-2.0
// A study as one self-contained page: charts, tables and pictures, nothing to fetch, no script.
#pragma once

#include <scrim/image/colour.h>
#include <scrim/study/study.h>

#include <string>

namespace scrim {

/// `scene`: what was studied, as a name. `colour` shows the picture on its default display.
std::string studyAsHtml(const Study& study, const std::string& scene, const ColourConfig& colour);

}  // namespace scrim
