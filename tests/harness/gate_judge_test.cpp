#include "harness/gate/judge.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "core/error.hpp"
#include "harness/gate/reference_noise.hpp"
#include "tests/core/scene_files.hpp"
#include "tests/support/gate_rows.hpp"

namespace penumbra::gate {
namespace {

using test::baselineOf;
using test::gateOf;
using test::gateRow;
using test::runOf;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

Verdict judged(const Row& before, const Row& after, const Thresholds& thresholds = {}) {
    return judge(baselineOf({before}), runOf({after}), thresholds);
}

/// What failed, as "metric change".
std::vector<std::string> findings(const Verdict& verdict) {
    std::vector<std::string> list;
    for (const Gate& gate : verdict.gates)
        if (gate.fails())
            for (const Finding& f : gate.findings) list.push_back(f.metric + " " + f.change);
    return list;
}

TEST(Judge, TheSameRowPassesEveryKind) {
    const Row row = gateRow("fence", "pcss");
    const Verdict verdict = judged(row, row);
    EXPECT_FALSE(verdict.fails());
    EXPECT_EQ(verdict.count(State::passed), 5u);
    for (const Kind kind : {Kind::row, Kind::accuracy, Kind::time, Kind::work, Kind::effects})
        EXPECT_TRUE(gateOf(verdict, row, kind)) << nameOf(kind);
    EXPECT_THAT(verdict.notes, IsEmpty());
}

// ---- time ------------------------------------------------------------------------------------

Row timed(double ms, double low, double high) {
    Row row = gateRow("fence", "pcss");
    row.frameMs = ms;
    row.frameMsLow = low;
    row.frameMsHigh = high;
    return row;
}

TEST(Judge, ASlowDownNeedsSignificanceAndMagnitude) {
    const Row before = timed(10, 9, 11);
    EXPECT_THAT(findings(judged(before, timed(12, 11.5, 12.5))),
                ElementsAre("frame_ms 10 [9, 11] -> 12 [11.5, 12.5] ms (+20 %)"));
    EXPECT_FALSE(judged(before, timed(20, 10.9, 40)).fails()) << "the intervals overlap";
    EXPECT_FALSE(judged(timed(10, 9.9, 10.1), timed(10.9, 10.8, 11)).fails()) << "9 %";
    EXPECT_TRUE(judged(timed(10, 9.9, 10.1), timed(11.1, 11, 11.2)).fails()) << "11 %";
    const Verdict faster = judged(before, timed(5, 4.9, 5.1));
    EXPECT_FALSE(faster.fails());
    EXPECT_EQ(faster.improvements, 1u);
}

TEST(Judge, TimesOfOtherMachinesAreNotComparedAndThatIsSaidOnce) {
    const Row a = gateRow("fence", "pcss"), b = gateRow("fence", "hard");
    Row slowA = a, slowB = b;
    for (Row* row : {&slowA, &slowB}) row->frameMs = row->frameMsLow = row->frameMsHigh = 100;
    const auto notesOf = [&](const Baseline& baseline, const JudgedRun& run) {
        const Verdict verdict = judge(baseline, run, {});
        EXPECT_FALSE(verdict.fails());
        EXPECT_FALSE(gateOf(verdict, a, Kind::time));
        return verdict.notes;
    };
    Baseline other = baselineOf({a, b});
    other.machines = {"another, Release", "another, Release"};
    EXPECT_THAT(notesOf(other, runOf({slowA, slowB})),
                ElementsAre("2 rows: time is not compared: the baseline's machine is another, "
                            "Release, the run's a processor, Release"));
    other.machines = {"", ""};
    EXPECT_THAT(notesOf(other, runOf({slowA, slowB})),
                ElementsAre(HasSubstr("does not say on which machine")));
    slowA.threads = slowB.threads = 8;
    EXPECT_THAT(notesOf(baselineOf({a, b}), runOf({slowA, slowB})),
                ElementsAre(HasSubstr("the baseline used 2 threads, the run 8")));
    slowA.renderer = slowB.renderer = "a GPU";
    EXPECT_THAT(notesOf(baselineOf({a, b}), runOf({slowA, slowB})),
                ElementsAre(HasSubstr("the baseline's renderer is llvmpipe, the run's a GPU"),
                            HasSubstr("work is not compared between different renderers")));
}

// ---- accuracy --------------------------------------------------------------------------------

TEST(Judge, ALightLeakFailsWithTheGravestFirst) {
    const Row before = gateRow("fence", "pcss");
    Row leaks = before;
    leaks.metrics.bias = 0.04;
    leaks.metrics.leakRate = 0.3;
    leaks.metrics.rmse = 0.055;
    EXPECT_THAT(findings(judged(before, leaks)),
                ElementsAre("bias 0.001 -> 0.04 (+0.039)", "leak_rate 0 -> 0.3 (+0.3)",
                            "rmse 0.05 -> 0.055 (+10 %)"));
    EXPECT_FALSE(judged(leaks, before).fails()) << "the other way round it is better";
}

TEST(Judge, WhatTheReferencesNoiseExplainsPasses) {
    Row before = gateRow("fence", "pcss"), after = before;
    before.metrics.referenceSe = after.metrics.referenceSe = 0.05;
    before.metrics.scoredPixels = after.metrics.scoredPixels = 10000;
    // Standard error of either rmse: 0.05 / 100; of the difference: sqrt(2) times that; five of
    // them are 0.00354.
    after.metrics.rmse = *before.metrics.rmse + 0.0035;
    EXPECT_THAT(findings(judged(before, after)), IsEmpty());
    after.metrics.rmse = *before.metrics.rmse + 0.0036;
    EXPECT_THAT(findings(judged(before, after)), ElementsAre(HasSubstr("rmse 0.05 -> 0.0536")));
}

TEST(Judge, ANoisierReferenceIsARegressionOfTheFrameSaidOnce) {
    const Row pcf = gateRow("fence", "pcf"), hard = gateRow("fence", "hard");
    Row noisyPcf = pcf, noisyHard = hard;
    noisyPcf.metrics.referenceSe = noisyHard.metrics.referenceSe = 0.01;
    EXPECT_THAT(findings(judge(baselineOf({pcf, hard}), runOf({noisyPcf, noisyHard}), {})),
                ElementsAre(HasSubstr("reference_se 0.0008 -> 0.01")));
}

TEST(Judge, MetricsBestAtZeroOrOneAreJudgedTowardsThat) {
    const Row before = gateRow("fence", "pcss");
    Row after = before;
    after.metrics.bias = -0.0011;
    EXPECT_FALSE(judged(before, after).fails());
    after.metrics.bias = -0.01;
    EXPECT_THAT(findings(judged(before, after)), ElementsAre("bias 0.001 -> -0.01 (-0.011)"));
    after = before;
    after.metrics.ssim = 0.95;
    EXPECT_FALSE(judged(before, after).fails());
    after.metrics.ssim = 0.85;
    EXPECT_THAT(findings(judged(before, after)), ElementsAre(HasSubstr("ssim 0.9 -> 0.85")));
}

TEST(Judge, WrongPixelsAndLostValuesFail) {
    const Row before = gateRow("fence", "pcss");
    Row after = before;
    after.metrics.nonfinite = 1;
    EXPECT_THAT(findings(judged(before, after)), ElementsAre("nonfinite 0 -> 1 (+1)"));
    after = before;
    after.metrics.rmse.reset();
    EXPECT_THAT(findings(judged(before, after)), ElementsAre("rmse 0.05 -> none"));
    EXPECT_FALSE(judged(after, before).fails()) << "a new value has nothing to be worse than";
    after = before;
    after.metrics.scoredPixels = 240000;
    EXPECT_THAT(findings(judged(before, after)), ElementsAre(HasSubstr("scored_pixels")));
}

// ---- work and effects ------------------------------------------------------------------------

TEST(Judge, CountersMayNotGrowByOne) {
    const Row before = gateRow("fence", "pcss");
    Row after = before;
    after.maps = 2;
    after.textureMib = 4.25;
    after.drawCalls = 21;
    EXPECT_THAT(findings(judged(before, after)),
                ElementsAre("draw_calls 20 -> 21 (+5 %)", "maps 1 -> 2 (+100 %)",
                            "texture_mib 4 -> 4.25 (+6.25 %)"));
    const Verdict less = judged(after, before);
    EXPECT_FALSE(less.fails());
    EXPECT_EQ(less.improvements, 3u);
}

TEST(Judge, EffectsThatGoMissingAreNamed) {
    Row before = gateRow("foliage", "pcss"), after = before;
    before.effectsMissing = "layered_casters";
    after.effectsMissing = "alpha_mask layered_casters";
    EXPECT_THAT(findings(judged(before, after)),
                ElementsAre("effects_missing no longer simulated: alpha_mask"));
    EXPECT_FALSE(judged(after, before).fails());
}

// ---- rows ------------------------------------------------------------------------------------

TEST(Judge, MissingAndNewRowsAreStatesOfTheirOwn) {
    const Row old = gateRow("fence", "pcss"), kept = gateRow("fence", "hard"),
              fresh = gateRow("fence", "vsm");
    const Verdict verdict = judge(baselineOf({old, kept}), runOf({kept, fresh}), {});
    EXPECT_EQ(gateOf(verdict, old, Kind::row)->state, State::missing);
    EXPECT_EQ(gateOf(verdict, fresh, Kind::row)->state, State::added);
    EXPECT_FALSE(gateOf(verdict, fresh, Kind::accuracy)) << "there is nothing to compare it with";
    EXPECT_TRUE(verdict.fails()) << "a vanished row fails";
    EXPECT_FALSE(judge(baselineOf({kept}), runOf({kept, fresh}), {}).fails());
}

TEST(Judge, ARuleLetsRowsVanish) {
    const testing::TempFolder folder;
    const Thresholds thresholds = Thresholds::read(folder.write("gates.toml", R"(
[[gate]]
scene = "engine"
metric = "row"
ignore = true
reason = "its package is not installed everywhere"
)"));
    const Row kept = gateRow("fence", "pcss"), engine = gateRow("engine", "pcss");
    JudgedRun run = runOf({kept});
    run.record.skippedScenes = {{"engine", "install assimp-testmodels"}};
    const Verdict verdict = judge(baselineOf({kept, engine}), run, thresholds);
    EXPECT_FALSE(verdict.fails());
    EXPECT_EQ(gateOf(verdict, engine, Kind::row)->state, State::missingKnown);
    EXPECT_EQ(gateOf(verdict, engine, Kind::row)->note,
              "the run skipped the scene: install assimp-testmodels (may vanish: its package is "
              "not installed everywhere)");
    EXPECT_TRUE(judge(baselineOf({kept, gateRow("bunny", "pcss")}), run, thresholds).fails());
}

TEST(Judge, ACellThatFailsNowFails) {
    const Row before = gateRow("fence", "pcss");
    Row after = before;
    after.status = "failed";
    after.message = "out of memory";
    EXPECT_THAT(findings(judged(before, after)), ElementsAre("status ok -> failed: out of memory"));
    after.status = "unsupported";
    EXPECT_TRUE(judged(before, after).fails());
    EXPECT_FALSE(judged(after, before).fails());
    EXPECT_FALSE(judged(after, after).fails()) << "unsupported as before";
    Row fresh = gateRow("fence", "vsm");
    fresh.status = "failed";
    EXPECT_TRUE(judge(baselineOf({before}), runOf({before, fresh}), {}).fails())
        << "new and failed";
}

TEST(Judge, AnotherSizeIsRefusedByLine) {
    const Row before = gateRow("fence", "pcss");
    Row after = before;
    after.width = 256;
    try {
        judged(before, after);
        FAIL() << "not refused";
    } catch (const InputError& e) {
        EXPECT_STREQ(e.what(),
                     "no_such_run/results.csv:2: the image is 256x512, that of baseline.csv:2 is "
                     "512x512; make the run with --size 512x512");
    }
}

TEST(Judge, ColumnsThatOneSideLacksAreNotComparedAndSaid) {
    const Row before = gateRow("fence", "pcss");
    Row after = before;
    after.metrics.rmse = 0.5;
    Baseline old = baselineOf({before});
    old.table.absent = {"rmse", "effects_missing"};
    old.table.unknown["colour"] = {"red"};
    const Verdict verdict = judge(old, runOf({after}), {});
    EXPECT_FALSE(verdict.fails());
    EXPECT_THAT(verdict.notes,
                ElementsAre("baseline.csv lacks columns of this version, which are not compared: "
                            "rmse, effects_missing",
                            "baseline.csv has columns that this version does not know, which are "
                            "ignored: colour"));
}

TEST(Judge, RulesReplaceThresholds) {
    const testing::TempFolder folder;
    const Thresholds thresholds = Thresholds::read(folder.write("gates.toml", R"(
[[gate]]
metric = "frame_ms"
relative = 0.5
reason = "a machine of many users"

[[gate]]
scene = "fence"
method = "pcss-*"
metric = "frame_ms"
ignore = true
reason = "never mind"
)"));
    EXPECT_FALSE(judged(timed(10, 9, 11), timed(14, 13, 15), thresholds).fails());
    const Verdict verdict = judged(timed(10, 9, 11), timed(16, 15, 17), thresholds);
    ASSERT_TRUE(verdict.fails());
    EXPECT_THAT(gateOf(verdict, timed(10, 9, 11), Kind::time)->findings.front().limit,
                HasSubstr("a machine of many users"));
    Row before = timed(10, 9, 11), after = timed(100, 90, 110);
    before.setting = after.setting = "pcss-0a1b2c3d";
    EXPECT_FALSE(judged(before, after, thresholds).fails()) << "the last rule that matches wins";
}

// ---- what noise explains -----------------------------------------------------------------------

TEST(ReferenceNoise, StandardErrorsOfMetrics) {
    const ReferenceNoise noise{0.01, 40000, 10000};
    EXPECT_DOUBLE_EQ(standardErrorOf(Noise::none, noise), 0.0);
    EXPECT_DOUBLE_EQ(standardErrorOf(Noise::meanOfAll, noise), 0.01 / 200);
    EXPECT_DOUBLE_EQ(standardErrorOf(Noise::meanOfPenumbra, noise), 0.01 / 100);
    EXPECT_DOUBLE_EQ(standardErrorOf(Noise::onePixel, noise), 0.01);
    EXPECT_DOUBLE_EQ(standardErrorOf(Noise::worstPixel, noise),
                     0.01 * std::sqrt(2 * std::log(40000.0)));
    EXPECT_DOUBLE_EQ(standardErrorOf(Noise::meanOfPenumbra, {0.01, 40000, 0}), 0.01)
        << "an unknown number of pixels divides by one";
}

TEST(ReferenceNoise, TheFloorOfAnotherStandardErrorIsExplained) {
    // An image that is right has the reference's noise as its rmse, whatever the number of pixels.
    const ReferenceNoise fine{0.001, 1 << 30, 1 << 30}, rough{0.01, 1 << 30, 1 << 30};
    const double rmseOfRough = std::hypot(0.0, 0.01);
    EXPECT_GE(explainedByNoise(Noise::meanOfAll, 0.001, fine, rough), rmseOfRough - 0.001 - 1e-12);
    EXPECT_LT(explainedByNoise(Noise::meanOfAll, 0.1, fine, rough), 0.0006)
        << "beside an error of 0.1 that noise hardly shows: 0.01^2 / (2 * 0.1) and the spread";
}

}  // namespace
}  // namespace penumbra::gate
