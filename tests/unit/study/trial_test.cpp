// SPDX-License-Identifier: Apache-2.0
#include <scrim/scene/quality.h>
#include <scrim/study/dial_sweep.h>
#include <scrim/scene/quality.h>
#include <scrim/study/study.h>
#include <scrim/study/trial.h>

#include <gtest/gtest.h>

#include <set>

namespace scrim::test {
namespace {

Trial trialOf(double seconds, double error, Kernel kernel = Kernel::linear) {
    Trial trial;
    trial.run = true;
    trial.seconds = {seconds};
    trial.error.error = error;
    trial.dials.kernel = kernel;
    return trial;
}

TEST(Trial, TimeIsTheMedianOfItsRepeats) {
    Trial trial;
    EXPECT_EQ(trial.time(), 0);
    trial.seconds = {3, 1, 100};
    EXPECT_EQ(trial.time(), 3);
    trial.seconds = {3, 1, 100, 2};
    EXPECT_EQ(trial.time(), 2.5);
}

TEST(Front, HoldsWhatNothingFasterIsMoreAccurateThan) {
    std::vector<Trial> trials{trialOf(3, 0.1), trialOf(1, 0.5), trialOf(2, 0.6), trialOf(4, 0.1), trialOf(2.5, 0.2)};
    EXPECT_EQ(markFront(trials, Kernel::linear), (std::vector<std::size_t>{1, 4, 0}));
    EXPECT_FALSE(trials[2].onFront);  // slower and worse than [1]
    EXPECT_FALSE(trials[3].onFront);  // slower than [0], and no better
}

TEST(Front, KnowsNothingOfOtherKernelsAndOfWhatWasNotRun) {
    std::vector<Trial> trials{trialOf(3, 0.1), trialOf(1, 0.01, Kernel::gaussian), trialOf(1, 0.01)};
    trials[2].run = false;
    EXPECT_EQ(markFront(trials, Kernel::linear), (std::vector<std::size_t>{0}));
    EXPECT_EQ(cheapestWithin(trials, Kernel::linear, 0.05), std::nullopt);
    EXPECT_EQ(cheapestWithin(trials, Kernel::linear, 0.1), 0u);
}

TEST(DialSweeps, TurnEveryDialThatTradesAccuracyAndKeepTheOthers) {
    const Dials base;
    std::vector<Trial> trials;
    addTrial(trials, "base", base);
    std::vector<DialSweep> sweeps = dialSweeps(false);
    addSweeps(trials, sweeps, base);
    for (const DialSweep& sweep : sweeps) {
        ASSERT_EQ(sweep.trials.size(), sweep.values.size());
        for (std::size_t i = 0; i < sweep.trials.size(); ++i)
            for (const DialInfo& dial : dialTable())
                EXPECT_EQ(dialText(trials[sweep.trials[i]].dials, dial.name),
                          dial.name == sweep.dial ? sweep.values[i] : dialText(base, dial.name))
                    << sweep.dial << " " << sweep.values[i];
        for (std::size_t i = 1; i < sweep.sizes.size(); ++i)
            EXPECT_GT(sweep.sizes[i], sweep.sizes[i - 1]) << sweep.dial;
    }
}

TEST(DialSweeps, TryNoSettingTwice) {
    std::vector<Trial> trials;
    std::vector<DialSweep> sweeps = dialSweeps(false);
    addTrial(trials, "base", Dials());
    addSweeps(trials, sweeps, Dials());
    addJoint(trials, Dials());
    addNeighbours(trials, sweeps, {0, 5});
    std::set<std::string> settings;
    for (const Trial& trial : trials) {
        std::string setting;
        for (const DialInfo& dial : dialTable()) setting += dialText(trial.dials, dial.name) + " ";
        EXPECT_TRUE(settings.insert(setting).second) << setting;
    }
}

Trial timed(std::uint64_t footprints, const std::vector<double>& seconds) {
    Trial trial;
    trial.run = true;
    trial.work.footprints = footprints;
    trial.seconds = seconds;
    return trial;
}

// A dial that changed no work was once said to halve the time: of that only clocks knew.
TEST(Times, OfEqualWorkAreShared) {
    std::vector<Trial> trials{timed(7, {1, 2, 3}), timed(8, {1}), timed(7, {5}), timed(7, {})};
    shareTimes(trials);
    for (const std::size_t i : {0u, 2u, 3u}) EXPECT_EQ(trials[i].seconds, (std::vector<double>{1, 2, 3, 5})) << i;
    EXPECT_EQ(trials[1].seconds, std::vector<double>{1});
    EXPECT_FALSE(isSlower(timed(7, {9, 9}), timed(7, {1, 1})));
}

TEST(Times, DifferWhereNoRepeatOverlapsAndATenthLiesBetween) {
    EXPECT_TRUE(isSlower(timed(2, {1.3, 1.4}), timed(1, {1.0, 1.2})));
    EXPECT_FALSE(isSlower(timed(2, {1.1, 1.9}), timed(1, {1.0, 1.2})));
    EXPECT_FALSE(isSlower(timed(2, {1.05, 1.06}), timed(1, {1.0, 1.01})));
    EXPECT_FALSE(isSlower(timed(1, {1.0}), timed(2, {1.3})));
}

TEST(RenderBlock, IsAPresetAndWhatDiffersFromIt) {
    EXPECT_EQ(renderBlock(*presetDials("high")), "[render]\nquality = \"high\"\nsheet_thickness = 1\ntexel = 0.5\n");
    Dials dials = *presetDials("draft");
    dials.texel = 0.9;
    dials.kernel = Kernel::gaussian;
    const std::string block = renderBlock(dials);
    EXPECT_EQ(block, "[render]\nquality = \"draft\"\nsheet_thickness = 3\ntexel = 0.9\nkernel = \"gaussian\"\n");
}

}  // namespace
}  // namespace scrim::test
