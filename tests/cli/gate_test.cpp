// check, approve and report --history as programs, on a run of the real methods.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "harness/gate/baseline.hpp"
#include "harness/gate/history.hpp"
#include "harness/run/csv.hpp"
#include "tests/core/scene_files.hpp"
#include "tests/support/run_program.hpp"

namespace penumbra {
namespace {

using ::testing::AllOf;
using ::testing::AnyOf;
using ::testing::HasSubstr;

class GateProgram : public ::testing::Test {
  protected:
    std::string path(const std::string& name) const { return (folder.path() / name).string(); }
    test::Finished compared(const std::string& run, std::vector<std::string> more = {}) const {
        std::vector<std::string> command = {
            "compare", "--scene", "half_plane",  "--method", "hard",
            "--size",  "64x64",   "--repeats",   "2",        "--reference-se",
            "0.02",    "--cache", path("cache"), "--out",    path(run)};
        command.insert(command.end(), more.begin(), more.end());
        return test::penumbra(command);
    }
    test::Finished checked(const std::string& run, std::vector<std::string> more = {}) const {
        std::vector<std::string> command = {"check", path(run), "--baseline", path("baseline.csv"),
                                            "--no-remeasure"};
        command.insert(command.end(), more.begin(), more.end());
        return test::penumbra(command);
    }
    test::Finished approved(const std::string& run, const std::string& reason) const {
        return test::penumbra(
            {"approve", path(run), "--reason", reason, "--baseline", path("baseline.csv")});
    }
    void expectRefused(const test::Finished& done, const std::string& said) const {
        EXPECT_EQ(done.exitCode, 2) << done.out;
        EXPECT_THAT(done.err, HasSubstr(said));
        EXPECT_EQ(test::lines(done.err).size(), 1u) << done.err;
        EXPECT_EQ(done.out, "");
    }

    testing::TempFolder folder;
};

TEST_F(GateProgram, FromTheFirstBaselineToALeakAndItsHistory) {
    ASSERT_EQ(compared("before").exitCode, 0);
    expectRefused(checked("before"), "baseline.csv: No such file");
    expectRefused(approved("before", " "), "--reason: is empty");
    const test::Finished first = approved("before", "the first");
    EXPECT_EQ(first.exitCode, 0) << first.err;
    const test::Finished good = checked("before");
    EXPECT_EQ(good.exitCode, 0) << good.out << good.err;
    EXPECT_THAT(good.out, HasSubstr("the gate passes: 5 gates, 5 passed\n"));

    // Depth compared with a bias of many great texels lets light through under the caster. The
    // setting is another one, so the baseline's row is given its name.
    ASSERT_EQ(compared("leaks", {"--set", "hard.bias=16", "--set", "hard.map_size=16"}).exitCode,
              0);
    std::vector<Row> rows = readCsv(path("before/results.csv"));
    const std::string name = readCsv(path("leaks/results.csv")).front().setting;
    ASSERT_NE(name, "hard");
    rows.front().setting = name;
    folder.write("baseline.csv", gate::baselineText(rows, ""));
    const test::Finished leak = checked("leaks");
    EXPECT_EQ(leak.exitCode, 1);
    EXPECT_THAT(
        leak.out,
        AllOf(
            HasSubstr("FAIL half_plane frame 0 " + name + ": accuracy\n"),
            HasSubstr("    leak_rate 0 -> 1 (+1)"), HasSubstr("    look at "),
            HasSubstr(
                "    run penumbra compare --scene half_plane --method hard --set "
                "hard.map_size=16 --set hard.bias=16 --size 64x64 --repeats 2 --reference-se 0.02"),
            HasSubstr("the baseline does not say on which machine it was measured")));

    ASSERT_EQ(approved("leaks", "meant to show a leak").exitCode, 0);
    EXPECT_EQ(checked("leaks").exitCode, 0);
    const test::Finished page =
        test::penumbra({"report", "--history", path("history.csv"), "--out", path("page.html")});
    EXPECT_EQ(page.exitCode, 0) << page.err;
    EXPECT_THAT(test::readText(path("page.html")), HasSubstr("meant to show a leak"));
    expectRefused(test::penumbra({"report"}), "name a run folder, or --history");
}

TEST_F(GateProgram, BadInputIsRefusedByLine) {
    ASSERT_EQ(compared("run").exitCode, 0);
    ASSERT_EQ(approved("run", "the first").exitCode, 0);
    const std::string baseline = test::readText(path("baseline.csv"));
    const std::string results = test::readText(path("run/results.csv"));

    folder.write("baseline.csv", baseline.substr(0, baseline.size() - 30));
    expectRefused(checked("run"), "baseline.csv:2: the file is cut short within this line");
    folder.write("baseline.csv", gate::baselineText({}, ""));
    expectRefused(checked("run"), "baseline.csv: holds no row to compare with");
    folder.write("baseline.csv", baseline);

    folder.write("run/results.csv", results + test::lines(results)[1] + "\n");
    expectRefused(checked("run"),
                  "results.csv:3: scene half_plane frame 0 setting hard has a row "
                  "in line 2 already");
    folder.write("run/results.csv", results);

    folder.write("gates.toml", "[[gate]]\nmetric = \"rmse\"\nrelative = 1\n");
    expectRefused(checked("run"), "gates.toml:1: 'reason' is missing");
    expectRefused(checked("run", {"--gates", path("none.toml")}), "none.toml");
    std::filesystem::remove(path("gates.toml"));
    expectRefused(checked("nowhere"), "nowhere/run.json: not a run folder");
    EXPECT_FALSE(std::filesystem::exists(path("run/junit.xml"))) << "nothing was judged";
}

TEST_F(GateProgram, ApproveKilledAtAnyTimeLeavesOldOrNew) {
    ASSERT_EQ(compared("run").exitCode, 0);
    ASSERT_EQ(approved("run", "the first").exitCode, 0);
    const std::string old = test::readText(path("baseline.csv"));
    std::vector<Row> rows = readCsv(path("run/results.csv"));
    rows.front().metrics.rmse = 0.5;
    folder.write("run/results.csv", csvHeader() + "\n" + toCsv(rows.front()) + "\n");
    const std::string now =
        gate::baselineText(rows, gate::readBaseline(path("baseline.csv")).machines.front());
    for (int ms = 0; ms < 200; ms += 20) {
        folder.write("baseline.csv", old);
        {
            const test::Program program(
                test::penumbraCommand({"approve", path("run"), "--reason", "killed", "--baseline",
                                       path("baseline.csv")}));
            std::this_thread::sleep_for(std::chrono::milliseconds(ms));
        }
        const std::string left = test::readText(path("baseline.csv"));
        EXPECT_THAT(left, AnyOf(old, now)) << "after " << ms << " ms";
        std::vector<gate::Approval> approvals = gate::readHistory(path("history.csv"));
        gate::dropUnborn(approvals, left);
        EXPECT_EQ(approvals.back().baseline, gate::hashOf(left)) << "after " << ms << " ms";
    }
}

}  // namespace
}  // namespace penumbra
