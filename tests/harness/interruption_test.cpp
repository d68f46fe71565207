// What stops a run before its end, inside one process; tests/cli and tests/long do it to real ones.
#include "harness/run/interruption.hpp"

#include <signal.h>

#include "harness/run/compare.hpp"
#include "harness/run/folder_lock.hpp"
#include "harness/run/merge.hpp"
#include "tests/support/compare_fixture.hpp"
#include "tests/support/fake_methods.hpp"

namespace penumbra {
namespace {

class Stopping : public test::CompareTest {
  protected:
    void TearDown() override { test::Interrupts::signal = 0; }
    std::vector<std::string> settingsWithRows(const std::string& run) const {
        std::vector<std::string> list;
        for (const Row& r : rows(run)) list.push_back(r.setting + std::to_string(r.frame));
        return list;
    }
};

using HandlerType = void (*)(int);
HandlerType handlerOf(int signal) {
    struct sigaction action {};
    sigaction(signal, nullptr, &action);
    return action.sa_handler;
}

TEST_F(Stopping, CellsThatAreBegunAreFinished) {
    const std::vector<std::string> methods = {"hard", "fake_interrupts", "pcf"};
    ASSERT_EQ(compare(options("whole", {script("still"), "half_plane"}, methods)), 0);
    for (const int signal : {SIGINT, SIGTERM}) {
        const std::string run = "stopped_" + std::to_string(signal);
        CompareOptions o = options(run, {script("still"), "half_plane"}, methods);
        test::Interrupts::signal = signal;
        EXPECT_EQ(compare(o), 128 + signal);
        // The signal came in the warm-up of the second of three; the first had its own before it.
        EXPECT_EQ(settingsWithRows(run), (std::vector<std::string>{"hard0", "fake_interrupts0"}));
        for (const Row& r : rows(run)) {
            EXPECT_EQ(r.status, "ok");
            EXPECT_EQ(r.repeats, o.repeats);
        }
        EXPECT_FALSE(record(run).finished);
        EXPECT_TRUE(std::filesystem::exists(RunFolder(path(run)).grid("still")));
        EXPECT_NE(test::readText(path(run) / "summary.md").find("unfinished"), std::string::npos);

        o.resume = true;
        EXPECT_EQ(compare(o), 0);
        EXPECT_TRUE(record(run).finished);
        EXPECT_EQ(test::untimedRows(path(run)), test::untimedRows(path("whole")));
        test::expectSameFiles(path(run) / "images", path("whole") / "images");
        EXPECT_EQ(test::readText(path(run) / "summary.md").find("unfinished"), std::string::npos);
    }
}

TEST_F(Stopping, ARunWhoseLastCellIsBegunEndsWhole) {
    test::Interrupts::signal = SIGINT;
    EXPECT_EQ(compare(options("run", {"half_plane"}, {"fake_interrupts"})), 130);
    EXPECT_EQ(rows("run").size(), 1u);
    EXPECT_TRUE(record("run").finished);
}

TEST_F(Stopping, HandlersAreOnlyThereWhileItRuns) {
    const HandlerType before = handlerOf(SIGINT);
    {
        const Interruption interruption;
        EXPECT_NE(handlerOf(SIGINT), before);
        EXPECT_EQ(Interruption::signal(), 0);
        raise(SIGTERM);
        EXPECT_EQ(Interruption::signal(), SIGTERM);
    }
    EXPECT_EQ(handlerOf(SIGINT), before);
    EXPECT_EQ(Interruption::signal(), 0);
}

TEST_F(Stopping, ASignalThatIsIgnoredStaysIgnored) {
    const HandlerType before = signal(SIGINT, SIG_IGN);
    {
        const Interruption interruption;
        raise(SIGINT);
        EXPECT_EQ(Interruption::signal(), 0);
    }
    EXPECT_EQ(handlerOf(SIGINT), SIG_IGN);
    signal(SIGINT, before);
}

TEST_F(Stopping, AMethodWhoseTaskThrowsFailsAlone) {
    const std::vector<std::string> methods = {"fake_throws_in_task", "hard",
                                              "fake_throws_a_number"};
    EXPECT_EQ(compare(options("run", {script("still")}, methods)), 3);
    for (const int frame : {0, 1}) {
        EXPECT_EQ(row("run", "hard", frame).status, "ok");
        EXPECT_EQ(row("run", "fake_throws_in_task", frame).status, "failed");
        EXPECT_EQ(row("run", "fake_throws_in_task", frame).message, "a task broke");
        EXPECT_EQ(row("run", "fake_throws_a_number", frame).status, "failed");
    }
    EXPECT_TRUE(record("run").finished);
    ASSERT_EQ(compare(options("alone", {script("still")}, {"hard"})), 0);
    for (const int frame : {0, 1})
        EXPECT_EQ(RunFolder(path("run")).readVisibility("still", frame, "hard"),
                  RunFolder(path("alone")).readVisibility("still", frame, "hard"));
}

TEST_F(Stopping, AFolderHasOneProcessAtATime) {
    CompareOptions o = options("run", {"half_plane"}, {"fake_constant"});
    std::filesystem::create_directories(path("run"));
    {
        const FolderLock other(path("run"));
        EXPECT_NE(refusal(o).find("another process"), std::string::npos) << refusal(o);
        EXPECT_TRUE(test::filesBelow(path("run")).empty());
    }
    ASSERT_EQ(compare(o), 0);
    const auto before = test::filesBelow(path("run"));
    o.resume = true;
    {
        const FolderLock other(path("run"));
        EXPECT_NE(refusal(o).find("another process"), std::string::npos) << refusal(o);
        std::filesystem::create_directories(path("merged"));
        const FolderLock merging(path("merged"));
        EXPECT_THROW(mergeRuns(path("merged"), {path("run")}), InputError);
    }
    EXPECT_TRUE(test::filesBelow(path("run")) == before);
    EXPECT_EQ(compare(o), 0);
}

TEST_F(Stopping, ARowWithoutItsImageIsDoneAgain) {
    CompareOptions o = options("run", {"half_plane"}, {"hard", "pcf"});
    ASSERT_EQ(compare(o), 0);
    const auto before = test::filesBelow(path("run") / "images");
    std::filesystem::remove(RunFolder(path("run")).setting("half_plane", 0, "pcf"));
    const Row kept = row("run", "hard");
    o.resume = true;
    EXPECT_EQ(compare(o), 0);
    EXPECT_EQ(row("run", "hard"), kept);
    EXPECT_TRUE(test::filesBelow(path("run") / "images") == before);
}

}  // namespace
}  // namespace penumbra
