// Two settings timed in pairs: the arithmetic by hand, how often equal ones are told apart under
// noise, drift and outliers, and a run of the real thing.
#include "harness/study/paired.hpp"

#include <cmath>
#include <random>
#include <stdexcept>

#include "harness/study/paired_report.hpp"
#include "tests/support/compare_fixture.hpp"
#include "tests/support/fake_methods.hpp"

namespace penumbra {
namespace {

using test::CompareTest;

/// A machine that slows down by a half over the run, has log-normal noise, a neighbour that makes
/// every eighth frame ten times as long, and gives whoever goes second 3 %.
class Machine {
  public:
    explicit Machine(unsigned seed) : random_(seed) {}
    std::vector<PairSample> pairs(int count, double aMs, double bMs) {
        std::vector<PairSample> all;
        for (int i = 0; i < count; ++i) {
            const double drift = 1.0 + 0.5 * i / count;
            PairSample pair;
            pair.aFirst = coin_(random_);
            const double first = drift * noise(), second = drift * noise() * 0.97;
            pair.aMs = aMs * (pair.aFirst ? first : second);
            pair.bMs = bMs * (pair.aFirst ? second : first);
            all.push_back(pair);
        }
        return all;
    }

  private:
    double noise() {
        return std::exp(0.1 * normal_(random_)) * (unit_(random_) < 0.125 ? 10.0 : 1.0);
    }
    std::mt19937 random_;
    std::normal_distribution<double> normal_;
    std::uniform_real_distribution<double> unit_;
    std::bernoulli_distribution coin_;
};

/// Trials of which 5 % may be wrong; three standard deviations of their share are 1.0 %.
constexpr int kTrials = 4000;
constexpr double kSlack = 0.0104;

TEST(SignTest, IntervalsByHand) {
    // P(0 heads of 6) is 1.6 %, P(at most 1) 10.9 %: the ends are the extremes.
    const MedianInterval six = signTestInterval({6, 1, 5, 2, 4, 3});
    EXPECT_EQ(six.median, 3.5);
    EXPECT_EQ(six.low, 1.0);
    EXPECT_EQ(six.high, 6.0);
    // P(at most 7 heads of 25) is 2.16 %, P(at most 8) 5.4 %: the 8th from both ends.
    std::vector<double> values;
    for (int i = 1; i <= 25; ++i) values.push_back(i);
    const MedianInterval many = signTestInterval(values);
    EXPECT_EQ(many.median, 13.0);
    EXPECT_EQ(many.low, 8.0);
    EXPECT_EQ(many.high, 18.0);
    EXPECT_THROW(signTestInterval({1, 2, 3, 4, 5}), std::invalid_argument);
    // Normal approximation: 1000 - 1.96 sqrt(500) - 0.5 is 955.7; 2^-2000 alone is no double.
    values.clear();
    for (int i = 1; i <= 2000; ++i) values.push_back(i);
    EXPECT_NEAR(signTestInterval(values).low, 956.0, 1.0);
}

TEST(Paired, EqualSettingsAreToldApartInAtMostFivePercent) {
    for (const int pairs : {6, 9, 25}) {
        int wrong = 0;
        for (unsigned trial = 0; trial < kTrials; ++trial)
            wrong += judgePairs(Machine(trial).pairs(pairs, 2.0, 2.0)).verdict !=
                     PairedVerdict::indistinguishable;
        EXPECT_LE(wrong, (0.05 + kSlack) * kTrials) << pairs << " pairs";
    }
}

TEST(Paired, TheIntervalHoldsTheTrueRatio) {
    int held = 0, right = 0;
    for (unsigned trial = 0; trial < kTrials; ++trial) {
        const PairedTiming t = judgePairs(Machine(trial).pairs(25, 2.0, 3.0));
        held += t.speedup.low <= 1.5 && 1.5 <= t.speedup.high;
        right += t.verdict == PairedVerdict::faster;
    }
    EXPECT_GE(held, (0.95 - kSlack) * kTrials);
    // A factor of 1.5 is more than the noise of most pairs: a test that never decides is no test.
    EXPECT_GE(right, 0.95 * kTrials);
    EXPECT_EQ(judgePairs(Machine(1).pairs(25, 3.0, 2.0)).verdict, PairedVerdict::slower);
}

PairedFrame frameOf(const std::string& scene, double speedup, int frame = 0) {
    return {scene, frame, "a", "b", std::vector<PairSample>(7, {true, 2.0, 2.0 * speedup})};
}

Row rowOf(const std::string& scene, const std::string& setting, double rmse, int frame = 0) {
    Row row;
    row.scene = scene;
    row.frame = frame;
    row.setting = setting;
    row.metrics.rmse = rmse;
    return row;
}

TEST(PairedFindings, SayWhichIsFasterAndWhatItCosts) {
    const auto sentence = [](double speedup, double rmseA, double rmseB) {
        return pairedFindings({frameOf("s", speedup)},
                              {rowOf("s", "a", rmseA), rowOf("s", "b", rmseB)})
            .at(0)
            .sentence();
    };
    EXPECT_EQ(sentence(1.83, 0.01006, 0.01),
              "A is 1.83x (1.83-1.83) faster than B at 0.6 % higher rmse");
    EXPECT_EQ(sentence(0.5, 0.009, 0.01),
              "A is 2.00x (2.00-2.00) slower than B at 10.0 % lower rmse");
    EXPECT_EQ(sentence(0.5, 0.03, 0.01), "A is 2.00x (2.00-2.00) slower than B at 3.00x the rmse");
    EXPECT_EQ(sentence(1.0, 0.01, 0.01),
              "A and B are indistinguishable in time: 1.00x (1.00-1.00) at the same rmse");
}

TEST(PairedFindings, FramesOfASceneArePooled) {
    const auto f = pairedFindings({frameOf("s", 1.0), frameOf("s", 2.0, 1)},
                                  {rowOf("s", "a", 3.0), rowOf("s", "a", 4.0, 1),
                                   rowOf("s", "b", 1.0), rowOf("s", "b", 1.0, 1)});
    ASSERT_EQ(f.size(), 1u);
    EXPECT_EQ(f[0].pairs, 14u);
    EXPECT_EQ(f[0].speedup, 1.5);  // between seven 1s and seven 2s
    EXPECT_NEAR(*f[0].rmseA, std::sqrt(12.5), 1e-12);
    EXPECT_NEAR(*f[0].rmseRatio, std::sqrt(12.5), 1e-12);
}

TEST(PairedFindings, OverallIsTheMedianOverScenes) {
    std::vector<PairedFrame> frames;
    std::vector<Row> rows;
    for (int i = 0; i < 7; ++i) {
        const std::string scene = "s" + std::to_string(i);
        frames.push_back(frameOf(scene, std::exp2(i - 1)));  // 1/2 to 32, middle 4
        rows.push_back(rowOf(scene, "a", 2.0));
        rows.push_back(rowOf(scene, "b", i < 3 ? 1.0 : 4.0));
    }
    const PairedFinding all = pairedFindings(frames, rows).back();
    EXPECT_EQ(all.scene, "overall");
    EXPECT_EQ(all.pairs, 49u);
    EXPECT_NEAR(all.speedup, 4.0, 1e-12);
    EXPECT_NEAR(*all.rmseRatio, 0.5, 1e-12);
    // Of seven scenes the extremes: P(0 of 7) is 0.8 %, P(at most 1) 6 %.
    EXPECT_NEAR(all.interval->low, 0.5, 1e-12);
    EXPECT_NEAR(all.interval->high, 32.0, 1e-12);
    frames.resize(3);
    const PairedFinding few = pairedFindings(frames, rows).back();
    EXPECT_FALSE(few.interval);
    EXPECT_NE(few.sentence().find("too few"), std::string::npos) << few.sentence();
}

TEST(PairedCsv, RoundTripAndErrors) {
    const testing::TempFolder folder;
    const auto path = folder.path() / "paired.csv";
    const std::vector<PairedFrame> frames = {frameOf("a, \"scene\"", 1.5), frameOf("two", 0.3, 4)};
    writePairedCsv(path, frames);
    EXPECT_EQ(readPairedCsv(path), frames);
    const auto errorOf = [&](const std::string& text) -> std::string {
        try {
            readPairedCsv(folder.write("bad.csv", text));
        } catch (const InputError& e) {
            return e.what();
        }
        return "";
    };
    const std::string header = "scene,frame,a,b,pair,first,a_ms,b_ms,speedup\n";
    EXPECT_NE(errorOf("scene,frame\n").find("bad.csv:1: "), std::string::npos);
    EXPECT_NE(errorOf(header + "s,0,a,b,0,a,1,2,2\ns,0,a,b,1,c,1,2,2\n").find("bad.csv:3: "),
              std::string::npos);
    EXPECT_NE(errorOf(header + "s,0,a,b,0,a,0,2,2\n").find("bad.csv:2: "), std::string::npos);
}

class PairedRun : public CompareTest {
  protected:
    CompareOptions paired(const std::string& run, std::vector<std::string> two, int repeats) const {
        CompareOptions o = options(run, {script("still")}, {});
        o.paired = std::move(two);
        o.repeats = repeats;
        return o;
    }
};

TEST_F(PairedRun, WritesEveryPairAndTheSection) {
    ASSERT_EQ(compare(paired("run", {"hard", "pcf:taps=9;map_size=64"}, 8)), 0);
    const RunFolder run(path("run"));
    const std::vector<PairedFrame> frames = readPairedCsv(run.paired());
    ASSERT_EQ(frames.size(), 2u);
    int aFirst = 0;
    for (const PairedFrame& f : frames) {
        EXPECT_EQ(f.a, "hard");
        EXPECT_EQ(f.pairs.size(), 8u);
        for (const PairSample& p : f.pairs) aFirst += p.aFirst;
    }
    EXPECT_GT(aFirst, 0) << "the order is drawn for every pair";
    EXPECT_LT(aFirst, 16);
    EXPECT_EQ(rows("run").size(), 4u);
    EXPECT_TRUE(row("run", frames[0].b).metrics.rmse);
    const std::string summary = test::readText(run.summary());
    EXPECT_NE(summary.find("## A against B"), std::string::npos);
    EXPECT_NE(summary.find("| still | 16 |"), std::string::npos) << summary;
}

TEST_F(PairedRun, AFailureLeavesTheOtherSettingItsRow) {
    ASSERT_EQ(compare(paired("run", {"fake_fails_when_timed", "hard"}, 6)), 3);
    EXPECT_EQ(row("run", "fake_fails_when_timed").status, "failed");
    EXPECT_EQ(row("run", "hard").status, "ok");
    EXPECT_TRUE(readPairedCsv(RunFolder(path("run")).paired()).empty());
    EXPECT_NE(
        test::readText(RunFolder(path("run")).summary()).find("No frame was rendered by both"),
        std::string::npos);
}

// Each verdict is wrong with a chance of at most 3.1 % (6 pairs: all must go one way, 2/64). That
// five or more of 10 are wrong has a chance of at most 252 * 0.031^5 = 7e-6.
TEST_F(PairedRun, OneSettingAgainstItselfOnTheRealRenderer) {
    int wrong = 0;
    for (unsigned trial = 0; trial < 10; ++trial) {
        CompareOptions o = options("run" + std::to_string(trial), {"half_plane"}, {});
        o.paired = {"hard:map_size=64", "hard:map_size=64"};
        o.repeats = 6;
        o.width = o.height = 16;
        o.seed = trial;
        ASSERT_EQ(compare(o), 0);
        const auto frames = readPairedCsv(RunFolder(o.out).paired());
        wrong += judgePairs(frames.at(0).pairs).verdict != PairedVerdict::indistinguishable;
        EXPECT_EQ(readCsv(RunFolder(o.out).results()).size(), 1u);
    }
    EXPECT_LT(wrong, 5);
}

}  // namespace
}  // namespace penumbra
