// A hundred SIGKILLs at random moments of small runs: nothing finished is lost, and what resuming
// ends with is what a run that nobody killed ends with.
#include <fmt/format.h>

#include <chrono>
#include <random>
#include <thread>

#include "harness/run/run_folder.hpp"
#include "harness/run/run_record.hpp"
#include "tests/core/scene_files.hpp"
#include "tests/support/run_files.hpp"

namespace penumbra {
namespace {

using Files = std::map<std::string, std::string>;
using Seconds = std::chrono::duration<double>;
using std::chrono::steady_clock;

constexpr int kKills = 100;

class Kills : public ::testing::Test {
  protected:
    std::vector<std::string> command(const std::filesystem::path& into,
                                     const std::filesystem::path& references) const {
        return test::penumbraCommand(
            {"compare",   "--out", into.string(), "--cache",    references.string(), "--resume",
             "--size",    "48x48", "--repeats",   "1",          "--reference-se",    "0.05",
             "--threads", "2",     "--scene",     "half_plane", "spinner",           "--method",
             "hard",      "pcf",   "separation"});
    }
    /// Runs the whole of it; how long the folder and all of it took.
    void measure() {
        const auto start = steady_clock::now();
        test::Program program(command(whole, wholeCache));
        while (!std::filesystem::exists(whole / "run.json") &&
               steady_clock::now() - start < std::chrono::seconds(60))
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        untilFolder = steady_clock::now() - start;
        ASSERT_EQ(program.wait().exitCode, 0);
        duration = steady_clock::now() - start;
        wholeImages = test::filesBelow(whole / "images");
        for (const Row& row : readResultsTable(whole / "results.csv").rows)
            ASSERT_EQ(row.status, "ok") << row.key() << ": " << row.message;
    }
    /// After a kill: what the folder says is there is there, whole, and what was before still is.
    void expectNothingLost() {
        if (!std::filesystem::exists(run / "results.csv")) {
            EXPECT_TRUE(seen.empty());
            return;
        }
        EXPECT_NO_THROW(RunRecord::read(run / "run.json"));
        std::map<std::string, Row> now;
        for (const Row& row : readResultsTable(run / "results.csv").rows)  // refuses half a row
            now.emplace(row.key(), row);
        for (const auto& [key, before] : seen) {
            ASSERT_TRUE(now.contains(key)) << key;
            Row after = now.at(key);
            if (!before.metrics.flicker) after.metrics.flicker.reset();  // filled in at the end
            EXPECT_EQ(after, before) << key;
        }
        seen = std::move(now);
        for (const auto& [key, row] : seen)
            for (const std::string& name :
                 {row.setting, std::string("gbuffer"), std::string("reference")}) {
                const std::filesystem::path image =
                    RunFolder(run).setting(row.scene, row.frame, name);
                const std::string relative = image.lexically_relative(run / "images").string();
                ASSERT_TRUE(wholeImages.contains(relative)) << relative;
                EXPECT_TRUE(test::readText(image) == wholeImages.at(relative)) << relative;
            }
    }
    void expectSameAsWhole() {
        EXPECT_EQ(test::untimedRows(run), test::untimedRows(whole));
        test::expectSameFiles(run / "images", whole / "images");
        EXPECT_TRUE(RunRecord::read(run / "run.json").finished);
        for (const auto& [name, bytes] : test::filesBelow(run))
            EXPECT_EQ(name.find(".tmp"), std::string::npos) << name;
        const std::filesystem::path a = folder.path() / "drawn", b = folder.path() / "drawn_whole";
        test::drawUntimed(run, a);
        test::drawUntimed(whole, b);
        test::expectSameFiles(a / "grid", b / "grid");
        for (const auto& path : {a, b, run, cache}) std::filesystem::remove_all(path);
        seen.clear();
    }

    testing::TempFolder folder;
    const std::filesystem::path whole = folder.path() / "whole", run = folder.path() / "run",
                                cache = folder.path() / "cache",
                                wholeCache = folder.path() / "whole_cache";
    Seconds untilFolder{}, duration{};
    Files wholeImages;
    std::map<std::string, Row> seen;  ///< rows after the kill before
};

TEST_F(Kills, AHundredLoseNothing) {
    ASSERT_NO_FATAL_FAILURE(measure());  // reads the program and its libraries from disk
    std::filesystem::remove_all(whole);
    std::filesystem::remove_all(wholeCache);
    ASSERT_NO_FATAL_FAILURE(measure());
    std::mt19937 random(20240229);
    int kills = 0, completions = 0, withRows = 0;
    while (kills < kKills && !HasFatalFailure()) {
        // Hardly anything can be lost before there is a folder.
        const Seconds delay = 0.8 * untilFolder + (duration - 0.8 * untilFolder) *
                                                      (static_cast<double>(random()) * 0x1p-32);
        const auto killAt = steady_clock::now() + delay;
        test::Program program(command(run, cache));
        while (program.runs() && steady_clock::now() < killAt)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        program.kill();
        const test::Finished done = program.wait();
        if (done.exitCode == -SIGKILL) {
            ++kills;
            SCOPED_TRACE(fmt::format("kill {} after {:.0f} ms", kills, 1e3 * delay.count()));
            expectNothingLost();
            withRows += !seen.empty();
        } else {
            ASSERT_EQ(done.exitCode, 0) << done.err;
            ++completions;
            expectNothingLost();
            expectSameAsWhole();
        }
    }
    test::Finished last = test::Program(command(run, cache)).wait();
    ASSERT_EQ(last.exitCode, 0) << last.err;
    expectNothingLost();
    expectSameAsWhole();
    fmt::print("{} kills, {} of them with rows in the folder; {} runs completed\n", kills, withRows,
               completions + 1);
    EXPECT_GT(withRows, kKills / 4) << "the kills came too early to lose anything";
}

}  // namespace
}  // namespace penumbra
