#include "harness/study/pareto.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "core/error.hpp"
#include "harness/run/provenance.hpp"
#include "harness/run/statistics.hpp"

namespace penumbra {
namespace {

/// A setting `name` of the method before the first '-'.
Row timed(const std::string& scene, int frame, const std::string& name, double error, double lowMs,
          double ms, double highMs) {
    Row row;
    row.scene = scene;
    row.frame = frame;
    row.setting = name;
    row.method = name.substr(0, name.find('-'));
    row.params = "p=" + name;
    row.frameMs = ms;
    row.frameMsLow = lowMs;
    row.frameMsHigh = highMs;
    row.metrics.rmse = error;
    row.renderer = "llvmpipe";
    return row;
}
Row timed(const std::string& name, double error, double lowMs, double ms, double highMs) {
    return timed("s", 0, name, error, lowMs, ms, highMs);
}

const CostStudy& studyOf(const std::vector<CostStudy>& studies, std::string_view scene) {
    return *std::ranges::find(studies, scene, &CostStudy::scene);
}
const CostPoint& pointOf(const CostStudy& study, const std::string& setting) {
    return *std::ranges::find(study.points, setting, &CostPoint::setting);
}
std::set<std::string> frontOf(const CostStudy& study) {
    std::set<std::string> front;
    for (const CostPoint& p : study.points)
        if (p.onFront) front.insert(p.setting);
    return front;
}
std::set<std::string> frontOf(const std::vector<Row>& rows) {
    return frontOf(costStudies(rows, "rmse").front());
}
using Names = std::set<std::string>;

TEST(Pareto, FasterOrMoreAccurateIsOnTheFront) {
    EXPECT_EQ(frontOf({timed("a", 0.3, 0.9, 1, 1.1), timed("b", 0.2, 1.9, 2, 2.1),
                       timed("c", 0.1, 3.9, 4, 4.1), timed("slower", 0.2, 2.9, 3, 3.1),
                       timed("worse", 0.4, 1.4, 1.5, 1.6)}),
              (Names{"a", "b", "c"}));
}

TEST(Pareto, AnAdvantageWithinTheNoiseOfTheDifferenceIsNone) {
    // 4 ms from 18 up and 3 ms from 23 down: differences of less than 5 ms may be noise, though
    // "hasty" has the lesser median.
    const Row hasty = timed("hasty", 0.2, 17.5, 18, 22);
    EXPECT_EQ(frontOf({hasty, timed("good", 0.1, 19.9, 22.9, 40)}), Names{"good"});
    EXPECT_EQ(frontOf({hasty, timed("good", 0.1, 20, 23, 40)}), Names{"good"})
        << "0 at the end of the interval is not outside";
    // Surely faster, although the intervals overlap.
    EXPECT_EQ(frontOf({hasty, timed("good", 0.1, 20.1, 23.1, 40)}), (Names{"hasty", "good"}));
}

TEST(Pareto, ManyFramesTellWhatOneCannot) {
    // 2 ms apart, 2 ms of noise at both: sqrt(8) in one frame; of four frames 8 ms against
    // sqrt(32). The intervals of the means overlap as those of one frame do.
    std::vector<Row> rows;
    for (int frame = 0; frame < 4; ++frame) {
        rows.push_back(timed("s", frame, "a", 0.3, 8, 10, 12));
        rows.push_back(timed("s", frame, "b", 0.2, 10, 12, 14));
    }
    EXPECT_EQ(frontOf(rows), (Names{"a", "b"}));
    EXPECT_EQ(frontOf({rows[0], rows[1]}), Names{"b"});
}

TEST(Pareto, AChainOfThoseThatCouldBeEquallyFastLeavesTheMostAccurate) {
    const Row a = timed("a", 0.3, 8, 9, 11), b = timed("b", 0.2, 8, 10.5, 12.5),
              c = timed("c", 0.1, 10, 12, 14);
    EXPECT_EQ(frontOf({a, b, c}), Names{"c"}) << "of a and b nobody knows which it would be";
    EXPECT_EQ(frontOf({a, c}), (Names{"a", "c"}));
}

TEST(Pareto, NoiseDoesNotEmptyTheFrontOfASuite) {
    std::mt19937 random(2);
    std::lognormal_distribution<double> noise(0.0, 0.3);
    constexpr int kSettings = 10, kFrames = 10;
    std::vector<Row> rows;
    for (int k = 0; k < kSettings; ++k)
        for (int frame = 0; frame < kFrames; ++frame) {
            std::vector<double> repeats(5);
            for (double& ms : repeats) ms = 10.0 * std::pow(1.3, k) * noise(random);
            const TimingSummary t = summarise(repeats, random());
            rows.push_back(timed("s", frame, "a-" + std::to_string(k), std::pow(0.7, k), t.low,
                                 t.median, t.high));
        }
    // All ten are on the true front. The median of five repeats with 30 % noise has 16 %, the mean
    // of ten of them 5 %: a factor of 1.3 is nearly four standard deviations of a ratio.
    EXPECT_GE(frontOf(rows).size(), 7u);
}

TEST(Pareto, EqualSettingsAreOnTheFrontTogetherOrNotAtAll) {
    const Row a = timed("a", 0.1, 9, 10, 11), b = timed("b", 0.1, 9, 10, 11);
    EXPECT_EQ(frontOf({a, b}), (Names{"a", "b"}));
    EXPECT_EQ(frontOf({a, b, timed("c", 0.05, 8, 9, 10)}), Names{"c"});
    EXPECT_EQ(frontOf({a, timed("b", 0.1, 10, 11.5, 13)}), (Names{"a", "b"})) << "who knows";
    EXPECT_EQ(frontOf({a, timed("b", 0.1, 11.5, 12, 13)}), Names{"a"}) << "surely slower";
}

/// Medians and intervals of repeats with 10 % noise, as a run has them.
Row measured(const std::string& name, double error, double trueMs, std::mt19937& random) {
    std::lognormal_distribution<double> noise(0.0, 0.1);
    std::vector<double> repeats(9);
    for (double& ms : repeats) ms = trueMs * noise(random);
    const TimingSummary t = summarise(repeats, random());
    return timed(name, error, t.low, t.median, t.high);
}

TEST(Pareto, NoisePutsNoSettingOnTheFront) {
    std::mt19937 random(1);
    constexpr int kTrials = 200;
    int equallyFast = 0, slower = 0, byMedians = 0;
    for (int trial = 0; trial < kTrials; ++trial) {
        const std::vector<Row> rows = {
            measured("good", 0.05, 10, random), measured("equally_fast", 0.06, 10, random),
            measured("slower", 0.07, 11, random), measured("cheap", 0.2, 5, random),
            measured("best", 0.01, 20, random)};
        const Names front = frontOf(rows);
        EXPECT_TRUE(front.contains("best"));
        EXPECT_TRUE(front.contains("good")) << "half of the time of what is better";
        EXPECT_TRUE(front.contains("cheap")) << "half of the time of what is better";
        equallyFast += front.contains("equally_fast");
        slower += front.contains("slower");
        byMedians += *rows[1].frameMs < *rows[0].frameMs;
    }
    // Two 95 % intervals around the same median are apart, the wrong one below, less often than one
    // of them fails to hold it at one end: 2.5 %. Twice that, for bootstrap intervals of nine
    // repeats are somewhat too short.
    EXPECT_LE(equallyFast, 0.05 * kTrials);
    EXPECT_LE(slower, 0.05 * kTrials);
    EXPECT_GE(byMedians, 0.3 * kTrials) << "the noise should matter to whoever goes by medians";
}

TEST(Pareto, ASceneTakesMeansAndTheSuiteRootMeanSquares) {
    const std::vector<CostStudy> studies =
        costStudies({timed("s", 0, "a", 0.3, 1, 2, 3), timed("s", 1, "a", 0.1, 3, 4, 5),
                     timed("t", 0, "a", 0.5, 8, 9, 10)},
                    "rmse");
    ASSERT_EQ(studies.size(), 3u);
    const CostPoint& s = studyOf(studies, "s").points.at(0);
    EXPECT_DOUBLE_EQ(s.error, 0.2);
    EXPECT_DOUBLE_EQ(s.ms, 3.0);
    EXPECT_DOUBLE_EQ(s.lowMs, 2.0);
    EXPECT_DOUBLE_EQ(s.highMs, 4.0);
    EXPECT_EQ(s.frames, 2u);
    const CostPoint& suite = studyOf(studies, kWholeSuite).points.at(0);
    EXPECT_DOUBLE_EQ(suite.error, std::sqrt((0.09 + 0.01 + 0.25) / 3));
    EXPECT_DOUBLE_EQ(suite.ms, 5.0);
    EXPECT_EQ(suite.frames, 3u);
    EXPECT_EQ(suite.scenes, 2u);
    EXPECT_EQ(costStudies({timed("a", 0.3, 1, 2, 3)}, "rmse").size(), 1u)
        << "of one scene the suite would be a copy";
}

TEST(Pareto, WhatLacksFramesCompetesOverThoseThatItHas) {
    Row refused = timed("t", 0, "half", 0.0, 1, 1, 1);
    refused.status = "unsupported";
    const std::vector<Row> rows = {
        timed("s", 0, "whole", 0.1, 9, 10, 11), timed("t", 0, "whole", 0.1, 99, 100, 101),
        // On s alone: dearer than `whole` there, though cheaper than its mean over both.
        timed("s", 0, "half", 0.2, 19, 20, 21), refused,
        // Better and cheaper on s: `whole` has a frame that it lacks, `half` has none.
        timed("s", 0, "best_half", 0.05, 4, 5, 6)};
    const std::vector<CostStudy> studies = costStudies(rows, "rmse");
    const CostStudy& suite = studyOf(studies, kWholeSuite);
    EXPECT_EQ(suite.frames, 2u);
    EXPECT_EQ(pointOf(suite, "half").frames, 1u);
    EXPECT_FALSE(suite.covers(pointOf(suite, "half")));
    EXPECT_EQ(frontOf(suite), (Names{"whole", "best_half"}));
    EXPECT_EQ(cheapestReaching(suite, 0.3)->setting, "whole");
    EXPECT_EQ(bestWithin(suite, 1000)->setting, "whole");
    EXPECT_EQ(cheapestReaching(studyOf(studies, "s"), 0.3)->setting, "best_half");
}

TEST(Pareto, OnlyWhatWasTimedHereCompetes) {
    Row external = timed("image", 0.001, 1, 1, 1), failed = timed("failed", 0.001, 1, 1, 1),
        separation = timed("separation", 0.001, 1, 1, 1), untimed = timed("b", 0.001, 1, 1, 1);
    external.renderer = kExternalRenderer;
    failed.status = "failed";
    separation.frameMs.reset();
    untimed.frameMs.reset();
    const Row a = timed("a", 0.1, 1, 2, 3);
    EXPECT_EQ(frontOf({external, failed, separation, untimed, a}), Names{"a"});
    EXPECT_FALSE(hasCurve({a, timed("b", 0.1, 1, 2, 3), external}));
    EXPECT_TRUE(hasCurve({a, timed("a-1", 0.1, 1, 2, 3)}));
    Row failedRung = timed("a-1", 0.1, 1, 2, 3);
    failedRung.status = "failed";
    EXPECT_FALSE(hasCurve({a, failedRung}));
}

TEST(Pareto, AnyErrorCanBeOnTheAxis) {
    Row a = timed("a", 0.1, 1, 2, 3), b = timed("b", 0.2, 1, 2, 3);
    a.metrics.ssim = 0.9;
    a.metrics.bias = -0.25;
    b.metrics.bias = 0.125;
    const auto errors = [&](const std::string& metric) {
        std::vector<double> list;
        for (const CostPoint& p : costStudies({a, b}, metric).front().points)
            list.push_back(p.error);
        return list;
    };
    EXPECT_EQ(errors("ssim"), (std::vector<double>{1.0 - 0.9})) << "b has none";
    EXPECT_EQ(errors("bias"), (std::vector<double>{0.25, 0.125}));
    EXPECT_EQ(errorName("ssim"), "1 - ssim");
    EXPECT_EQ(errorName("bias"), "|bias|");
    EXPECT_EQ(errorName("rmse"), "rmse");
    for (const char* none : {"frame_ms", "scored_pixels", "reference_se", "RMSE", ""})
        EXPECT_THROW(requireCostMetric(none), InputError) << none;
    try {
        requireCostMetric("speed");
        FAIL();
    } catch (const InputError& e) {
        EXPECT_NE(std::string(e.what()).find("rmse, mae, bias"), std::string::npos) << e.what();
    }
}

TEST(Pareto, TheFloorIsWhatTheReferenceAddsToRmse) {
    Row a = timed("s", 0, "a", 0.05, 1, 2, 3), b = timed("s", 0, "b", 0.5, 1, 2, 3);
    a.metrics.rmseCorrected = 0.04;
    a.metrics.referenceSe = 0.06;
    b.metrics.rmseCorrected = 0.0;  // says nothing
    EXPECT_DOUBLE_EQ(costStudies({a, b}, "rmse").front().floor.value(), 0.03);
    a.metrics.rmsePenumbra = b.metrics.rmsePenumbra = 0.2;
    EXPECT_DOUBLE_EQ(costStudies({a, b}, "rmse_penumbra").front().floor.value(), 0.06);
    a.metrics.mae = 0.1;
    EXPECT_EQ(costStudies({a}, "mae").front().floor, std::nullopt) << "unknown";
}

TEST(Pareto, TablesTakeTheCheapestAndTheBest) {
    const std::vector<CostStudy> studies = costStudies(
        {timed("hard", 0.2, 1, 2, 3), timed("hard-1", 0.3, 1, 1, 1), timed("a", 0.05, 9, 10, 11),
         timed("a-1", 0.01, 29, 30, 31), timed("b", 0.04, 19, 20, 21)},
        "rmse");
    const CostStudy& s = studies.front();
    EXPECT_EQ(costUnit(s)->setting, "hard");
    EXPECT_EQ(cheapestReaching(s, 0.05)->setting, "a") << "at most, not below";
    EXPECT_EQ(cheapestReaching(s, 0.049)->setting, "b");
    EXPECT_EQ(cheapestReaching(s, 0.049, "a")->setting, "a-1");
    EXPECT_EQ(cheapestReaching(s, 0.001), nullptr);
    EXPECT_EQ(bestWithin(s, 10)->setting, "a");
    EXPECT_EQ(bestWithin(s, 25)->setting, "b");
    EXPECT_EQ(bestWithin(s, 0.5), nullptr);
    EXPECT_EQ(
        costUnit(costStudies({timed("hard-1", 0.3, 1, 1, 1), timed("hard-2", 0.3, 2, 2, 2)}, "rmse")
                     .front())
            ->setting,
        "hard-1");
    EXPECT_EQ(costUnit(costStudies({timed("a", 0.3, 1, 1, 1)}, "rmse").front()), nullptr);
}

TEST(Pareto, CsvHasEveryPointWhateverTheOrderOfRows) {
    std::vector<Row> rows = {timed("s", 0, "a", 0.25, 1, 2, 3), timed("t", 0, "a", 0.25, 1, 2, 3),
                             timed("s", 0, "a-1", 0.5, 0.25, 0.5, 0.75)};
    const std::string csv = paretoCsv(costStudies(rows, "rmse"), "rmse");
    EXPECT_EQ(csv,
              "scene,method,setting,params,metric,error,frame_ms,frame_ms_low,frame_ms_high,"
              "on_front,frames,frames_of,scenes,scenes_of\n"
              "s,a,a-1,p=a-1,rmse,0.5,0.5,0.25,0.75,1,1,1,1,1\n"
              "s,a,a,p=a,rmse,0.25,2,1,3,1,1,1,1,1\n"
              "t,a,a,p=a,rmse,0.25,2,1,3,1,1,1,1,1\n"
              "suite,a,a-1,p=a-1,rmse,0.5,0.5,0.25,0.75,1,1,2,1,2\n"
              "suite,a,a,p=a,rmse,0.25,2,1,3,1,2,2,2,2\n");
    std::ranges::reverse(rows);
    EXPECT_EQ(paretoCsv(costStudies(rows, "rmse"), "rmse"), csv);
}

}  // namespace
}  // namespace penumbra
