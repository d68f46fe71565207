// Runs that were cut off, spread out or taken apart end like runs that were not.
#include "harness/report/report.hpp"
#include "harness/run/compare.hpp"
#include "harness/run/merge.hpp"
#include "tests/support/compare_fixture.hpp"
#include "tests/support/fake_methods.hpp"

namespace penumbra {
namespace {

using test::CompareTest;

const std::vector<std::string> kMethods = {"hard", "pcf", "ray_traced"};

class Resume : public CompareTest {
  protected:
    void TearDown() override { test::Flaky::broken = false; }
    /// Without the fields that say how long it took.
    void expectSameRun(const std::string& a, const std::string& b) const {
        EXPECT_EQ(test::untimedRows(path(a)), test::untimedRows(path(b)));
        test::expectSameFiles(path(a) / "images", path(b) / "images");
        const RunRecord ra = record(a), rb = record(b);
        EXPECT_EQ(ra.finished, rb.finished);
        ASSERT_EQ(ra.scenes.size(), rb.scenes.size());
        for (std::size_t i = 0; i < ra.scenes.size(); ++i)
            EXPECT_EQ(ra.scenes[i].id, rb.scenes[i].id);
        ASSERT_EQ(ra.settings.size(), rb.settings.size());
        for (std::size_t i = 0; i < ra.settings.size(); ++i)
            EXPECT_EQ(ra.settings[i].name, rb.settings[i].name);
        EXPECT_EQ(ra.references.size(), rb.references.size());
    }
};

TEST_F(Resume, FailedCellsAreTriedAgain) {
    const std::vector<std::string> methods = {"fake_flaky", "hard"};
    ASSERT_EQ(compare(options("whole", {script("still")}, methods)), 0);

    CompareOptions o = options("flaky", {script("still")}, methods);
    test::Flaky::broken = true;
    ASSERT_EQ(compare(o), 3);
    EXPECT_EQ(row("flaky", "fake_flaky", 0).status, "ok");
    EXPECT_EQ(row("flaky", "fake_flaky", 1).status, "failed");
    const Row kept = row("flaky", "hard", 1);
    o.resume = true;
    EXPECT_EQ(compare(o), 3) << "still broken";
    test::Flaky::broken = false;
    EXPECT_EQ(compare(o), 0);
    EXPECT_EQ(row("flaky", "hard", 1), kept) << "good rows stay as they are, times included";
    expectSameRun("whole", "flaky");
}

TEST_F(Resume, ARunCutOffAnywhereEndsLikeAWholeOne) {
    const std::vector<std::string> scenes = {script("still"), "half_plane"};
    ASSERT_EQ(compare(options("whole", scenes, kMethods)), 0);
    const std::string csv = test::readText(path("whole") / "results.csv");
    const std::vector<std::string> rowLines = test::lines(csv);
    ASSERT_EQ(rowLines.size(), 1u + 3u * kMethods.size());

    CompareOptions o = options("cut", scenes, kMethods);
    o.resume = true;
    // In the header, in the first row, inside the still scene whose second frame keeps its maps,
    // and in the last row.
    for (const std::size_t whole : {0, 1, 5, 9}) {
        std::filesystem::remove_all(path("cut"));
        std::filesystem::copy(path("whole"), path("cut"), std::filesystem::copy_options::recursive);
        std::string torn;
        for (std::size_t i = 0; i < whole; ++i) torn += rowLines[i] + "\n";
        torn += rowLines[whole].substr(0, rowLines[whole].size() / 2);
        std::ofstream(path("cut") / "results.csv", std::ios::binary) << torn;
        const std::vector<Row> left = rows("cut");
        for (const Row& r : rows("whole"))
            if (std::ranges::find(left, r.key(), &Row::key) == left.end())
                std::filesystem::remove(
                    RunFolder(path("cut")).setting(r.scene, r.frame, r.setting));
        for (const char* name :
             {"run.json.0011223344556677.tmp", "images/still/0000/hard.exr.8899aabbccddeeff.tmp"})
            std::ofstream(path("cut") / name) << "cut off while it was being written";
        RunRecord unfinished = record("cut");
        unfinished.finished = false;
        unfinished.references.clear();
        unfinished.write(path("cut") / "run.json");

        ASSERT_EQ(compare(o), 0) << "after " << whole << " lines";
        EXPECT_EQ(test::untimedRows(path("cut")), test::untimedRows(path("whole")))
            << "after " << whole << " lines";
        test::expectSameFiles(path("cut") / "images", path("whole") / "images");
        EXPECT_FALSE(std::filesystem::exists(path("cut") / "run.json.0011223344556677.tmp"));
    }
}

TEST_F(Resume, AFrameAloneHasWhatAWholeRunGivesIt) {
    // Maps are kept from a frame that this process never saw, light and camera as the plan has
    // them.
    const std::string moving = script("moving", R"(
[[track]]
target = "light.size"
times = [0.0, 1.0]
values = [[1.6, 1.0], [0.8, 0.5]]

[[track]]
target = "camera.position"
times = [0.0, 1.0]
values = [[-1.7, 2.6, 0.0], [-1.7, 1.3, 0.4]]
)");
    for (const char* effects : {"auto", "none"}) {
        const std::string whole = std::string("whole_") + effects, half = whole + "_half";
        CompareOptions o = options(whole, {moving}, {"pcf"});
        o.effects = EffectChoice::parse(effects);
        ASSERT_EQ(compare(o), 0);
        o.out = path(half);
        o.shard = o.shards = 2;
        ASSERT_EQ(compare(o), 0);
        ASSERT_EQ(rows(half).size(), 1u);
        EXPECT_EQ(rows(half)[0].frame, 1);
        EXPECT_EQ(RunFolder(path(half)).readVisibility("moving", 1, "pcf"),
                  RunFolder(path(whole)).readVisibility("moving", 1, "pcf"))
            << effects;
        EXPECT_EQ(rows(half)[0].buildMs.has_value(), row(whole, "pcf", 1).buildMs.has_value());
    }
}

TEST_F(Resume, AFinishedRunIsLeftAsItIs) {
    CompareOptions o = options("run", {"half_plane"}, kMethods);
    ASSERT_EQ(compare(o), 0);
    const auto before = test::filesBelow(path("run"));
    o.resume = true;
    ASSERT_EQ(compare(o), 0);
    auto after = test::filesBelow(path("run"));
    for (const char* timed : {"run.json", "summary.md", "report.html"})
        after[timed] = before.at(timed);
    EXPECT_TRUE(after == before);
    EXPECT_EQ(record("run").references.size(), 1u) << "what tracing cost is not forgotten";
}

TEST_F(Resume, OnlyWhatIsTheSameRunIsContinued) {
    const CompareOptions o = options("run", {"half_plane"}, {"fake_constant"});
    ASSERT_EQ(compare(o), 0);
    const auto before = test::filesBelow(path("run"));
    EXPECT_NE(refusal(o).find("holds a run already"), std::string::npos) << refusal(o);

    const auto expectRefused = [&](const auto& change) {
        CompareOptions other = o;
        other.resume = true;
        change(other);
        EXPECT_NE(refusal(other).find("must have the same"), std::string::npos) << refusal(other);
    };
    expectRefused([](CompareOptions& c) { c.width = 32; });
    expectRefused([](CompareOptions& c) { c.seed = 1; });
    expectRefused([](CompareOptions& c) { c.referenceSe = 0.04; });
    expectRefused([](CompareOptions& c) { c.effects = EffectChoice::parse("none"); });
    EXPECT_TRUE(test::filesBelow(path("run")) == before);

    CompareOptions nowhere = o;
    nowhere.resume = true;
    nowhere.out.clear();
    EXPECT_NE(refusal(nowhere).find("--out"), std::string::npos);
}

TEST_F(Resume, AnOlderRowOfAMethodThatIsGoneStays) {
    ASSERT_EQ(compare(options("run", {"half_plane"}, {"fake_constant", "hard"})), 0);
    CompareOptions o = options("run", {"half_plane"}, {"hard", "pcf"});
    o.resume = true;
    ASSERT_EQ(compare(o), 0);
    EXPECT_EQ(rows("run").size(), 3u);
}

TEST_F(Resume, MergedShardsAreTheWholeRun) {
    const std::vector<std::string> scenes = {script("still"), "half_plane"};
    ASSERT_EQ(compare(options("whole", scenes, kMethods)), 0);
    for (const int shard : {1, 2}) {
        CompareOptions o = options("shard" + std::to_string(shard), scenes, kMethods);
        o.shard = shard;
        o.shards = 2;
        ASSERT_EQ(compare(o), 0);
    }
    EXPECT_EQ(rows("shard1").size(), 5u);
    EXPECT_EQ(rows("shard2").size(), 4u);
    // Given the other way round, as a shell's glob may.
    EXPECT_EQ(mergeRuns(path("merged"), {path("shard2"), path("shard1")}), 0);
    expectSameRun("whole", "merged");
    for (const char* scene : {"still", "half_plane"})
        EXPECT_TRUE(std::filesystem::exists(RunFolder(path("merged")).grid(scene))) << scene;
    EXPECT_TRUE(std::filesystem::exists(RunFolder(path("merged")).summary()));
}

TEST_F(Resume, MergeRefusesWhatDoesNotBelongTogether) {
    ASSERT_EQ(compare(options("a", {"half_plane"}, {"fake_constant"})), 0);
    CompareOptions o = options("b", {"half_plane"}, {"hard"});
    o.seed = 7;
    ASSERT_EQ(compare(o), 0);
    const auto refused = [&](const std::string& out, const std::vector<std::string>& runs) {
        std::vector<std::filesystem::path> folders;
        for (const std::string& run : runs) folders.push_back(path(run));
        try {
            mergeRuns(path(out), folders);
        } catch (const InputError& e) {
            return std::string(e.what());
        }
        return std::string();
    };
    EXPECT_NE(refused("m", {"a", "b"}).find("differ in"), std::string::npos);
    EXPECT_NE(refused("m", {"a", "a"}).find("both have half_plane frame 0 fake_constant"),
              std::string::npos);
    EXPECT_NE(refused("m", {"a", "absent"}).find("not a run folder"), std::string::npos);
    EXPECT_FALSE(std::filesystem::exists(path("m")));
    EXPECT_NE(refused("a", {"b"}).find("holds a run already"), std::string::npos);
}

TEST_F(Resume, MergeReportsFailedCells) {
    ASSERT_EQ(compare(options("a", {"half_plane"}, {"fake_gl_error"})), 3);
    ASSERT_EQ(compare(options("b", {"half_plane"}, {"fake_constant"})), 0);
    EXPECT_EQ(mergeRuns(path("m"), {path("a"), path("b")}), 3);
    EXPECT_EQ(rows("m").size(), 2u);
}

TEST_F(Resume, TheReportIsRebuiltFromTheRows) {
    ASSERT_EQ(compare(options("run", {"half_plane", "two_layers"}, {"hard", "fake_gl_error"})), 3);
    const auto before = test::filesBelow(path("run"));
    std::filesystem::remove(path("run") / "summary.md");
    std::filesystem::remove_all(path("run") / "grid");
    writeArtefacts(RunFolder(path("run")));
    EXPECT_TRUE(test::filesBelow(path("run")) == before);
    EXPECT_TRUE(before.contains("grid/half_plane.png"));
    EXPECT_TRUE(before.contains("grid/two_layers.png"));
}

}  // namespace
}  // namespace penumbra
