// SPDX-License-Identifier: Apache-2.0
// A study as data: a table for spreadsheets, and everything for programs.
#pragma once

#include <scrim/study/study.h>

#include <string>

namespace scrim {

/// A table with one line for each trial: setting, error with its 95 % interval, bias, worst pixel,
/// median, least and most seconds, repeats, counts of work, and every dial's value.
std::string studyAsCsv(const Study& study);

/// All of the study. `scene`: the name of the scene.
std::string studyAsJson(const Study& study, const std::string& scene);

}  // namespace scrim
