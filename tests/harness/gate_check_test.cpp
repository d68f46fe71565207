// The gate on real runs: what compare writes, changed for better or worse.
#include "harness/gate/check.hpp"

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "harness/gate/approve.hpp"
#include "harness/gate/judge.hpp"
#include "harness/run/csv.hpp"
#include "harness/run/files.hpp"
#include "tests/support/compare_fixture.hpp"
#include "tests/support/fake_methods.hpp"

namespace penumbra {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::Not;

/// Answers `visibility` everywhere.
class Leaky : public test::Constant {
  public:
    static inline float visibility = 0.5f;
    void shade(const Frame& frame, const Plan&, const VisibilityTarget& target) override {
        target.upload(std::vector<float>(frame.gbuffer.size(), visibility));
    }
};
const Register<Leaky> kLeaky{"fake_leaky", "As bright as it is told", "tests"};

class GateCheck : public test::CompareTest {
  protected:
    void SetUp() override {
        CompareTest::SetUp();
        folder.write("gates.toml", R"([[gate]]
metric = "frame_ms"
ignore = true
reason = "methods of microseconds on a machine that others use"
)");
    }
    void TearDown() override {
        Leaky::visibility = 0.5f;
        test::Slow::further = std::chrono::milliseconds(0);
    }

    struct Checked {
        int code = -1;
        std::string out;
    };
    Checked checked(const std::string& run, bool remeasure = true, bool partial = false) const {
        ::testing::internal::CaptureStdout();
        Checked done;
        try {
            done.code = gate::check({path(run), path("baseline.csv"), {}, remeasure, partial});
        } catch (const std::exception& e) {
            ADD_FAILURE() << e.what();
        }
        done.out = ::testing::internal::GetCapturedStdout();
        return done;
    }
    void approved(const std::string& run) const {
        ::testing::internal::CaptureStdout();
        gate::approve({path(run), "a test", path("baseline.csv"), {}});
        ::testing::internal::GetCapturedStdout();
    }
    void measured(const std::string& run, const std::vector<std::string>& methods) const {
        ::testing::internal::CaptureStdout();
        EXPECT_EQ(compare(options(run, {script("edge")}, methods)), 0);
        ::testing::internal::GetCapturedStdout();
    }
    /// An approved run "before", and "leaks", which is brighter.
    void measureLeak() const {
        measured("before", {"fake_leaky"});
        approved("before");
        Leaky::visibility = 0.9f;
        measured("leaks", {"fake_leaky"});
    }
    std::string text(const std::string& file) const { return readTextFile(path(file)); }
};

TEST_F(GateCheck, AnInjectedLightLeakFailsUntilItIsApproved) {
    measured("before", {"fake_leaky", "fake_constant"});
    approved("before");
    EXPECT_EQ(checked("before").code, 0);

    Leaky::visibility = 0.9f;
    measured("leaks", {"fake_leaky", "fake_constant"});
    const Checked leaks = checked("leaks");
    EXPECT_EQ(leaks.code, 1);
    EXPECT_THAT(leaks.out, AllOf(HasSubstr("FAIL edge frame 0 fake_leaky: accuracy"),
                                 HasSubstr("    bias "), HasSubstr("    rmse_umbra "),
                                 HasSubstr("(+80 %)"), HasSubstr("leaks/grid/edge.png, "),
                                 HasSubstr("leaks/images/edge/0000/fake_leaky.exr"),
                                 HasSubstr("    run penumbra compare --scene "),
                                 HasSubstr("--method fake_leaky --size 64x64 --repeats 2"),
                                 HasSubstr("    re-measured it fails again"),
                                 Not(HasSubstr("FAIL edge frame 0 fake_constant"))));
    EXPECT_THAT(text("leaks/junit.xml"), HasSubstr("<failure type=\"regression\""));
    EXPECT_THAT(text("leaks/summary.md"),
                AllOf(HasSubstr("\n## Gate\n"), HasSubstr("**the gate fails: ")));
    EXPECT_FALSE(nlohmann::json::parse(text("leaks/benchmark.json")).empty());

    approved("leaks");
    EXPECT_EQ(checked("leaks").code, 0) << "an approved change passes";
}

TEST_F(GateCheck, AnInjectedSlowDownFailsOnlyIfItIsSlowTwice) {
    std::filesystem::remove(path("gates.toml"));
    // Far apart, so that a busy machine moves no median from one to the other.
    test::Slow::further = std::chrono::milliseconds(60);
    measured("before", {"fake_slow"});
    approved("before");
    test::Slow::further = std::chrono::milliseconds(400);
    measured("slow", {"fake_slow"});

    const Checked again = checked("slow");
    EXPECT_EQ(again.code, 1);
    EXPECT_THAT(again.out, AllOf(HasSubstr("FAIL edge frame 0 fake_slow: time\n    frame_ms "),
                                 HasSubstr("    re-measured it fails again; at first frame_ms")));

    test::Slow::further = std::chrono::milliseconds(0);
    const Checked recovered = checked("slow");
    EXPECT_EQ(recovered.code, 0);
    EXPECT_THAT(recovered.out, AllOf(HasSubstr("recovered edge frame 0 fake_slow: time\n"
                                               "    re-measured it passes; at first frame_ms"),
                                     HasSubstr("2 passed when measured again")));
    EXPECT_EQ(readCsv(path("slow/remeasured/results.csv")).size(), 2u) << "these cells, no others";

    const Checked once = checked("slow", false);
    EXPECT_EQ(once.code, 1);
    EXPECT_THAT(once.out, Not(HasSubstr("re-measured")));
}

TEST_F(GateCheck, ALeakThatOnlyTheFileHasFails) {
    measured("before", {"fake_leaky"});
    approved("before");
    measured("edited", {"fake_leaky"});
    const std::vector<Row> rows = readCsv(path("edited/results.csv"));
    std::filesystem::remove(path("edited/results.csv"));
    CsvAppender edited(path("edited/results.csv"));
    for (Row row : rows) {
        row.metrics.rmse = *row.metrics.rmse + 0.1;
        edited.add(row);
    }
    const Checked done = checked("edited");
    EXPECT_EQ(done.code, 1);
    EXPECT_THAT(done.out, AllOf(HasSubstr("FAIL edge frame 0 fake_leaky: accuracy\n    rmse "),
                                HasSubstr("    re-measured it passes, but what is not a time")));
}

TEST_F(GateCheck, ARunMadeElsewhereIsNotMeasuredAgain) {
    measureLeak();
    RunRecord other = record("leaks");
    for (auto& [name, value] : other.provenance)
        if (name == "commit") value = "another";
    other.write(path("leaks/run.json"));
    const Checked done = checked("leaks");
    EXPECT_EQ(done.code, 1);
    EXPECT_THAT(done.out, HasSubstr("    re-measured no: the run's commit is another, this "
                                    "program's "));
}

TEST_F(GateCheck, ACellThatFailedOnceRecoversWhenItCanBeMeasured) {
    measured("before", {"fake_flaky"});
    approved("before");
    test::Flaky::broken = true;
    ::testing::internal::CaptureStdout();
    EXPECT_EQ(compare(options("broken", {script("edge")}, {"fake_flaky"})), 3);
    ::testing::internal::GetCapturedStdout();
    EXPECT_EQ(checked("broken").code, 1);
    test::Flaky::broken = false;
    const Checked done = checked("broken");
    EXPECT_THAT(done.out,
                HasSubstr("recovered edge frame 1 fake_flaky: row\n    re-measured it passes; at "
                          "first status ok -> failed: not today"));
    EXPECT_THAT(done.out, Not(HasSubstr("frame 1 fake_flaky: accuracy")));
}

TEST_F(GateCheck, AVanishedRowFailsUnlessItWasNotAskedFor) {
    measured("before", {"fake_constant", "fake_leaky"});
    approved("before");
    measured("fewer", {"fake_constant"});
    const Checked done = checked("fewer", false);
    EXPECT_EQ(done.code, 1);
    EXPECT_THAT(done.out,
                AllOf(HasSubstr("MISSING edge frame 0 fake_leaky: row"),
                      HasSubstr("row vanished: the run has no such row"), HasSubstr("2 missing")));
    EXPECT_THAT(text("fewer/junit.xml"), HasSubstr("<failure type=\"missing\""));
    const Checked partial = checked("fewer", false, true);
    EXPECT_EQ(partial.code, 0);
    EXPECT_THAT(partial.out, Not(HasSubstr("MISSING")));
}

TEST_F(GateCheck, CiIsTold) {
    measureLeak();
    setenv("GITHUB_ACTIONS", "true", 1);
    setenv("GITHUB_STEP_SUMMARY", path("step.md").c_str(), 1);
    const Checked done = checked("leaks");
    unsetenv("GITHUB_ACTIONS");
    unsetenv("GITHUB_STEP_SUMMARY");
    EXPECT_THAT(done.out, HasSubstr("::error title=edge frame 0 fake_leaky%3A accuracy::"));
    EXPECT_THAT(text("step.md"), ::testing::StartsWith("# Gate\n"))
        << "the cells measured again have no page of their own";
}

}  // namespace
}  // namespace penumbra
