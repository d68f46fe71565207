#include "harness/gate/history.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <regex>
#include <set>

#include "core/error.hpp"
#include "harness/gate/approve.hpp"
#include "harness/gate/history_page.hpp"
#include "harness/gate/series.hpp"
#include "harness/run/csv.hpp"
#include "harness/run/run_folder.hpp"
#include "tests/core/scene_files.hpp"
#include "tests/support/gate_rows.hpp"

namespace penumbra::gate {
namespace {

using test::gateRow;
using ::testing::AllOf;
using ::testing::Each;
using ::testing::ElementsAre;
using ::testing::Field;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;

// ---- steps -----------------------------------------------------------------------------------

std::vector<std::size_t> stepsOf(const std::vector<double>& values, double halfWidth = 0.0,
                                 double relative = 0.1) {
    std::vector<Point> points;
    for (const double value : values) points.push_back({value, halfWidth});
    std::vector<std::size_t> at;
    for (const Step& step : findSteps(points, relative, 0.0)) at.push_back(step.at);
    return at;
}

TEST(FindSteps, OneLevelHasNone) {
    EXPECT_THAT(stepsOf({}), IsEmpty());
    EXPECT_THAT(stepsOf({1}), IsEmpty());
    EXPECT_THAT(stepsOf({1, 1, 1, 1}), IsEmpty());
    EXPECT_THAT(stepsOf({10, 10.5, 9.7, 10.2, 9.9, 10.4}), IsEmpty()) << "within a tenth";
}

TEST(FindSteps, EachChangeOfLevelIsFoundWhereItIs) {
    EXPECT_THAT(stepsOf({1, 2}), ElementsAre(1));
    EXPECT_THAT(stepsOf({1, 1, 1, 2, 2, 2, 2}), ElementsAre(3));
    EXPECT_THAT(stepsOf({1, 1, 1, 2, 2, 2, 1, 1, 1}), ElementsAre(3, 6));
    EXPECT_THAT(stepsOf({1, 1, 2, 2, 1, 1}), ElementsAre(2, 4)) << "a level of two";
    EXPECT_THAT(stepsOf({10, 10.3, 9.8, 10.1, 14.1, 13.8, 14.3, 14}), ElementsAre(4));
}

TEST(FindSteps, LevelsAreThoseBesideTheStep) {
    const std::vector<Point> points = {{1}, {1}, {1}, {2}, {2}, {2}, {4}, {4}, {4}};
    const std::vector<Step> steps = findSteps(points, 0.1, 0.0);
    ASSERT_EQ(steps.size(), 2u);
    EXPECT_EQ(steps[0].before, 1.0);
    EXPECT_EQ(steps[0].after, 2.0);
    EXPECT_EQ(steps[1].before, 2.0);
    EXPECT_EQ(steps[1].after, 4.0);
}

TEST(FindSteps, OutliersAndNoiseAreNone) {
    EXPECT_THAT(stepsOf({1, 1, 1, 5, 1, 1, 1}), IsEmpty());
    // The halves' medians differ by 1, a tenth; neighbours differ by 4.
    EXPECT_THAT(stepsOf({8, 12, 10, 14, 9, 13, 17, 12, 16, 11}), IsEmpty());
    EXPECT_THAT(stepsOf({10, 12}, 1.0), IsEmpty()) << "intervals of +-1 touch";
    EXPECT_THAT(stepsOf({10, 14}, 1.0), ElementsAre(1));
}

// ---- history ---------------------------------------------------------------------------------

Approval approval(const std::string& commit, std::vector<Change> changes) {
    return {"2026-01-02T03:04:05Z",
            "A <a@b.c>",
            commit,
            "a \"reason\",\nin two lines",
            "llvmpipe",
            "a processor",
            2,
            "0123456789abcdef",
            std::move(changes)};
}

TEST(History, RoundTripKeepsEverything) {
    const std::vector<Change> changes = {{"a,\"b\"", 3, "pcss", "rmse", std::nullopt, 0.1},
                                         {"fence", 0, "hard", "frame_ms", 1.0 / 3.0, std::nullopt}};
    const testing::TempFolder folder;
    const auto file =
        folder.write("history.csv", historyText({approval("abc", changes), approval("def", {})}));
    const std::vector<Approval> back = readHistory(file);
    ASSERT_EQ(back.size(), 2u);
    EXPECT_EQ(back[0].changes, changes);
    EXPECT_EQ(back[0].reason, "a \"reason\",\nin two lines");
    EXPECT_EQ(back[0].machine, "a processor");
    EXPECT_EQ(back[0].renderer, "llvmpipe");
    EXPECT_EQ(back[0].threads, 2);
    EXPECT_EQ(back[1].commit, "def");
}

TEST(History, BadLinesAreNamed) {
    const testing::TempFolder folder;
    const std::string header = historyText({});
    const auto refusal = [&](const std::string& text) -> std::string {
        const auto file = folder.write("history.csv", text);
        try {
            readHistory(file);
        } catch (const InputError& e) {
            return std::string(e.what()).substr(file.string().size());
        }
        return "nothing is refused";
    };
    EXPECT_EQ(refusal(header), "nothing is refused");
    EXPECT_THAT(refusal("scene,frame\n"), HasSubstr(":1: the columns are when,who,"));
    EXPECT_THAT(refusal(header + "a,b\n"), HasSubstr(":2: the columns are when,who,"));
    EXPECT_EQ(refusal(header + ",,,,,,,,fence,0,pcss,rmse,1,2\n"),
              ":2: a change before the first approval");
    EXPECT_EQ(refusal(historyText({approval("x", {})}) + ",,,,,,,,fence,0,pcss,rmse,fast,2\n"),
              ":4: column before: 'fast' is not a number");
    EXPECT_EQ(refusal(header + "cut short"), ": the last line is cut short");
}

TEST(History, ChangesAreOfRowsAndMetrics) {
    Row kept = gateRow("fence", "pcss"), changed = kept;
    changed.metrics.rmse = 0.06;
    const Row gone = gateRow("fence", "gone"), fresh = gateRow("fence", "fresh");
    const std::vector<Change> changes = changesBetween({kept, gone}, {changed, fresh});
    EXPECT_EQ(changes.front(), (Change{"fence", 0, "pcss", "rmse", 0.05, 0.06}));
    std::size_t ofFresh = 0, ofGone = 0;
    for (const Change& c : changes) {
        ofFresh += c.setting == "fresh" && !c.before && c.after;
        ofGone += c.setting == "gone" && c.before && !c.after;
    }
    EXPECT_EQ(ofFresh, ofGone);
    EXPECT_EQ(changes.size(), 1 + ofFresh + ofGone);
    EXPECT_GT(ofFresh, 15u) << "every number that the row has";
}

TEST(History, AnApprovalThatWasStoppedBeforeTheBaselineIsLeftOut) {
    const std::string old = "the old baseline", now = "the new baseline";
    Approval first = approval("a", {}), second = approval("b", {});
    first.baseline = hashOf(old);
    second.baseline = hashOf(now);
    const auto left = [](std::vector<Approval> approvals, const std::string& baseline) {
        dropUnborn(approvals, baseline);
        return approvals.size();
    };
    EXPECT_EQ(left({first, second}, now), 2u);
    EXPECT_EQ(left({first, second}, old), 1u);
    EXPECT_EQ(left({first}, ""), 0u) << "the very first, and there is no baseline";
    EXPECT_EQ(left({first, second}, "edited by hand"), 2u) << "not for us to undo";
    EXPECT_EQ(left({}, now), 0u);
}

TEST(History, SeriesCarryValuesOnAndFindSteps) {
    const auto value = [](const std::string& metric, std::optional<double> before,
                          std::optional<double> after) {
        return Change{"fence", 0, "pcss", metric, before, after};
    };
    std::vector<Approval> approvals = {
        approval("a", {value("rmse", {}, 0.1), value("frame_ms", {}, 10)}),
        approval("b", {value("frame_ms", 10, 10.2)}),
        approval("c", {value("rmse", 0.1, 0.2), value("frame_ms", 10.2, 30)}),
        approval("d", {value("rmse", 0.2, {})})};
    std::vector<Series> all = seriesOf(approvals);
    ASSERT_EQ(all.size(), 2u);
    EXPECT_EQ(all[0].values, (std::vector<std::optional<double>>{0.1, 0.1, 0.2, {}}));
    EXPECT_THAT(all[0].steps, ElementsAre(Field(&Step::at, 2u)));
    EXPECT_THAT(all[1].steps, ElementsAre(Field(&Step::at, 2u)));
    approvals[2].machine = approvals[3].machine = "another one";
    all = seriesOf(approvals);
    EXPECT_THAT(all[0].steps, ElementsAre(Field(&Step::at, 2u))) << "accuracy is no machine's";
    EXPECT_THAT(all[1].steps, IsEmpty()) << "times of different machines";
}

TEST(HistoryPage, NothingInItCanRun) {
    const std::string hostile = "</script><script>alert(1)</script>";
    Approval a = approval(hostile, {{hostile, 0, hostile, "rmse", {}, 0.1}});
    a.reason = a.who = hostile;
    const std::string page = historyPage({a});
    EXPECT_THAT(page, Not(HasSubstr("<script>alert(1)")));
    EXPECT_THAT(page, HasSubstr("\\u003c/script>\\u003cscript>alert(1)"));
}

TEST(HistoryPage, EveryIdIsOfOneElement) {
    const std::string page = historyPage({approval("a", {})});
    const std::regex id(" id=\"([a-z-]+)\"");
    std::set<std::string> ids;
    for (std::sregex_iterator at(page.begin(), page.end(), id), end; at != end; ++at)
        EXPECT_TRUE(ids.insert((*at)[1]).second) << (*at)[1];
    EXPECT_TRUE(ids.contains("approvals") && ids.contains("approval-data"));
}

// ---- approve -----------------------------------------------------------------------------------

class Approve : public ::testing::Test {
  protected:
    void SetUp() override { std::filesystem::create_directories(run()); }
    std::filesystem::path run() const { return folder_.path() / "run"; }
    std::filesystem::path baseline() const { return folder_.path() / "baseline.csv"; }
    std::filesystem::path history() const { return folder_.path() / "history.csv"; }

    void writeRun(const std::vector<Row>& rows, bool finished = true) const {
        RunRecord record = test::runOf(rows).record;
        record.finished = finished;
        record.write(RunFolder(run()).record());
        std::string text = csvHeader() + "\n";
        for (const Row& row : rows) text += toCsv(row) + "\n";
        folder_.write("run/results.csv", text);
    }
    std::string refusal(const std::string& reason = "because") const {
        try {
            approved(reason);
        } catch (const InputError& e) {
            return e.what();
        }
        return "nothing is refused";
    }
    std::string approved(const std::string& reason = "because") const {
        ::testing::internal::CaptureStdout();
        try {
            approve({run(), reason, baseline(), {}});
        } catch (...) {
            ::testing::internal::GetCapturedStdout();
            throw;
        }
        return ::testing::internal::GetCapturedStdout();
    }

    testing::TempFolder folder_;
};

TEST_F(Approve, WritesTheBaselineAndWhoWhenWhyBeforeAndAfter) {
    Row row = gateRow("fence", "pcss");
    writeRun({row, gateRow("fence", "hard")});
    EXPECT_THAT(approved("the first"), HasSubstr("2 rows, 2 new, 0 changed, 0 gone"));
    EXPECT_EQ(readBaseline(baseline()).table.rows.front(), row);
    EXPECT_THAT(readBaseline(baseline()).machines, Each(test::kMachine));

    row.metrics.rmse = 0.04;
    writeRun({row, gateRow("fence", "vsm")});
    EXPECT_THAT(approved("better now"), HasSubstr("2 rows, 1 new, 1 changed, 1 gone"));
    const std::vector<Approval> approvals = readHistory(history());
    ASSERT_EQ(approvals.size(), 2u);
    EXPECT_EQ(approvals[1].reason, "better now");
    EXPECT_FALSE(approvals[1].who.empty());
    EXPECT_THAT(approvals[1].when, ::testing::MatchesRegex("[0-9]{4}-..-..T..:..:..Z"));
    EXPECT_EQ(approvals[1].changes.front(), (Change{"fence", 0, "pcss", "rmse", 0.05, 0.04}));
    EXPECT_EQ(approvals[1].baseline, hashOf(readTextFile(baseline())));
}

TEST_F(Approve, RefusesWhatMustNotBecomeABaseline) {
    const Row row = gateRow("fence", "pcss");
    writeRun({row});
    EXPECT_THAT(refusal(""), HasSubstr("--reason: is empty"));
    EXPECT_THAT(refusal(" \n\t"), HasSubstr("--reason: is empty"));
    Row failed = row;
    failed.status = "failed";
    failed.message = "out of memory";
    writeRun({failed});
    EXPECT_THAT(refusal(), AllOf(HasSubstr("results.csv:2: fence frame 0 pcss failed (out of "
                                           "memory)"),
                                 HasSubstr("cannot be a baseline")));
    writeRun({row}, false);
    EXPECT_THAT(refusal(), HasSubstr("is not finished"));
    writeRun({});
    EXPECT_THAT(refusal(), HasSubstr("holds no row"));
    EXPECT_FALSE(std::filesystem::exists(baseline()));
    EXPECT_FALSE(std::filesystem::exists(history()));
}

TEST_F(Approve, OneThatWasStoppedHalfWayLeavesTheOldAndIsMadeUpFor) {
    Row row = gateRow("fence", "pcss");
    writeRun({row});
    approved("the first");
    const std::string old = readTextFile(baseline());
    row.metrics.rmse = 0.04;
    writeRun({row});
    approved("stopped");
    folder_.write("baseline.csv", old);  // as if it had been killed between its two files
    approved("again");
    const std::vector<Approval> approvals = readHistory(history());
    ASSERT_EQ(approvals.size(), 2u);
    EXPECT_EQ(approvals[1].reason, "again");
    EXPECT_EQ(approvals[1].changes.front(), (Change{"fence", 0, "pcss", "rmse", 0.05, 0.04}));
}

}  // namespace
}  // namespace penumbra::gate
