// SPDX-License-Identifier: Apache-2.0
// A whole study of a small scene.
#include "support/expect_error.h"
#include "support/fields.h"

#include <scrim/study/study.h>
#include <scrim/study/study_data.h>
#include <scrim/study/study_page.h>

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>

namespace scrim::test {
namespace {

ViewScene sceneWith(const Dials& dials) {
    ViewScene scene = orthographicScene(smokeField(8), {0.15, Rgb(0.9), {}}, 20, 24);
    scene.lights = {distantLight({1, -0.5, -0.6})};
    scene.dials = dials;
    return scene;
}

const Study& study() {
    static const Study made = [] {
        StudyOptions options;
        options.mostPixels = 48;
        options.repeats = 2;
        return runStudy(sceneWith, Dials(), options);
    }();
    return made;
}

TEST(Study, RunsEverySettingWithoutABudget) {
    for (const Trial& trial : study().trials) {
        EXPECT_TRUE(trial.run) << trial.name << ": " << trial.skipped;
        EXPECT_EQ(trial.seconds.size() % 2, 0u) << trial.name;
        EXPECT_GT(trial.error.error, 0) << trial.name;
        EXPECT_LE(trial.error.lower, trial.error.error) << trial.name;
        EXPECT_GE(trial.error.upper, trial.error.error) << trial.name;
    }
    EXPECT_FALSE(study().outOfTime);
    EXPECT_EQ(study().presets.size(), 4u);
}

TEST(Study, FindsFinerSettingsMoreAccurate) {
    const auto errorAt = [&](const std::string& preset) {
        for (const auto& [name, trial] : study().presets)
            if (name == preset) return study().trials[trial].error.error;
        return -1.0;
    };
    EXPECT_LT(errorAt("standard"), errorAt("draft"));
    EXPECT_LT(errorAt("high"), errorAt("standard"));
    EXPECT_LT(errorAt("ultra"), errorAt("high"));
    // An order near two, of texels and of sheets.
    for (const DialSweep& sweep : study().sweeps)
        if (sweep.dial == "texel" || sweep.dial == "sheet_thickness") {
            EXPECT_GT(sweep.order.value_or(0), 1.2) << sweep.dial;
            EXPECT_LT(sweep.order.value_or(9), 2.6) << sweep.dial;
        }
}

TEST(Study, RecommendsNothingThatExceedsTheTolerance) {
    int found = 0;
    for (const Recommendation& r : recommendations(study())) {
        if (!r.trial) continue;
        ++found;
        EXPECT_LE(study().trials[*r.trial].error.error, r.tolerance);
    }
    EXPECT_GE(found, 3);
}

TEST(Study, AsDataHoldsEveryTrial) {
    const auto json = nlohmann::json::parse(studyAsJson(study(), "a \"scene\""));
    EXPECT_EQ(json.at("scene"), "a \"scene\"");
    EXPECT_EQ(json.at("trials").size(), study().trials.size());
    EXPECT_EQ(json.at("front").size(), study().front.size());
    const std::string csv = studyAsCsv(study());
    EXPECT_EQ(static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n')), study().trials.size() + 1);
}

TEST(Study, AsAPageNeedsNothingElse) {
    const std::string html = studyAsHtml(study(), "<scene>", ColourConfig::open(""));
    EXPECT_NE(html.find("&lt;scene&gt;"), std::string::npos);
    for (const char* outside : {"<script", "src=\"http", "href=", "url(", "@import"})
        EXPECT_EQ(html.find(outside), std::string::npos) << outside;
    EXPECT_NE(html.find("data:image/png;base64,iVBOR"), std::string::npos);
    EXPECT_EQ(html.find("nan"), std::string::npos);
}

TEST(Study, EndsWithItsBudgetAndKeepsWhatItHas) {
    StudyOptions options;
    options.budget = 1e-6;  // seconds: over before it began
    options.mostPixels = 48;
    const Study made = runStudy(sceneWith, Dials(), options);
    EXPECT_TRUE(made.outOfTime);
    EXPECT_TRUE(made.trials.front().run);
    EXPECT_EQ(made.front.size(), 1u);
    for (std::size_t i = 1; i < made.trials.size(); ++i) {
        EXPECT_FALSE(made.trials[i].run);
        EXPECT_FALSE(made.trials[i].skipped.empty());
    }
    EXPECT_FALSE(studyAsHtml(made, "s", ColourConfig::open("")).empty());
}

TEST(Study, OfAnEmptyPictureIsAnError) {
    const auto empty = [](const Dials& dials) {
        ViewScene scene = sceneWith(dials);
        scene.camera.wsPosition.x += 1000;
        return scene;
    };
    EXPECT_EQ(errorOf(ErrorKind::render, [&] { runStudy(empty, Dials(), {}); }),
              "there is nothing to study: the picture is empty");
}

TEST(Study, CanBeInterrupted) {
    EXPECT_EQ(errorOf(ErrorKind::interrupted, [] { runStudy(sceneWith, Dials(), {}, [](double) { return false; }); }),
              "the study was interrupted");
}

}  // namespace
}  // namespace scrim::test
