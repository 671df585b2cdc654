// SPDX-License-Identifier: Apache-2.0
// A study as one self-contained page of charts, tables and pictures, with nothing to download and no script.
#pragma once

#include <scrim/image/colour.h>
#include <scrim/study/study.h>

#include <string>

namespace scrim {

/// `scene`: the name of the scene. `colour` converts the picture to its default display.
std::string studyAsHtml(const Study& study, const std::string& scene, const ColourConfig& colour);

}  // namespace scrim
