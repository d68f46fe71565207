// How often cells are timed: as often as asked for, unless they took long.
#include "harness/run/cells.hpp"

#include <map>

#include "harness/run/staged_frame.hpp"
#include "harness/study/parameter_space.hpp"
#include "tests/support/compare_fixture.hpp"
#include "tests/support/fake_methods.hpp"

namespace penumbra {
namespace {

using std::chrono::milliseconds;
using test::CompareTest;
using test::Slow;

/// Timed frames of fake_slow and of fake_constant.
std::map<std::string, int> repeatsOf(int asked, double enoughMs) {
    test::glContext();
    const StagedFrame staged(loadScene("half_plane", SceneLibrary::standard()), 0, 16, 16, 0);
    const TextureTarget target(16, 16);
    const Setting slow = settingOf("fake_slow", {}), quick = settingOf("fake_constant", {});
    SettingRun slowRun(slow), quickRun(quick);
    CellOptions options;
    options.repeats = asked;
    options.enoughMs = enoughMs;
    std::map<std::string, int> repeats;
    runCells(staged.frame, options, {&slowRun, &quickRun}, target,
             [&](std::size_t, Row&& row, const std::vector<float>&) {
                 EXPECT_EQ(row.status, "ok") << row.message;
                 repeats[row.method] = row.repeats;
             });
    return repeats;
}

using Repeats = std::map<std::string, int>;

class Cells : public CompareTest {
  protected:
    void TearDown() override { Slow::first = Slow::further = milliseconds(0); }
};

TEST_F(Cells, WhatTookLongLeavesTheFurtherRounds) {
    Slow::further = milliseconds(400);
    // Eight frames of fake_constant fill 2048 pixels, which takes no second on any machine.
    EXPECT_EQ(repeatsOf(8, 1000), (Repeats{{"fake_slow", 3}, {"fake_constant", 8}}));
}

TEST_F(Cells, TheWarmUpCountsTowardNothing) {
    Slow::first = milliseconds(1000);
    EXPECT_EQ(repeatsOf(6, 1000).at("fake_slow"), 6);
}

TEST_F(Cells, ThreeTimesHoweverLong) {
    EXPECT_EQ(repeatsOf(9, 0).at("fake_slow"), 3);
    EXPECT_EQ(repeatsOf(2, 0).at("fake_slow"), 2) << "never more than asked for";
}

TEST_F(Cells, ACostlyOneIsTimedThreeTimesInARun) {
    Slow::further = milliseconds(700);  // three of them are more than kEnoughMs
    CompareOptions o = options("run", {"half_plane"}, {"fake_slow", "fake_constant"});
    o.repeats = 5;
    ASSERT_EQ(compare(o), 0);
    EXPECT_EQ(row("run", "fake_slow").repeats, 3);
    EXPECT_EQ(row("run", "fake_constant").repeats, 5);
}

TEST_F(Cells, APairIsTimedAsOftenAsAskedFor) {
    Slow::further = milliseconds(400);  // five of them are kEnoughMs
    CompareOptions o = options("run", {"half_plane"}, {});
    o.paired = {"fake_slow", "fake_constant"};
    o.repeats = 6;
    ASSERT_EQ(compare(o), 0);
    EXPECT_EQ(row("run", "fake_slow").repeats, 6);
    EXPECT_EQ(row("run", "fake_constant").repeats, 6);
}

}  // namespace
}  // namespace penumbra
