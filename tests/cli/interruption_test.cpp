// Real processes that are asked to stop, run out of disk or work beside each other.
#include <chrono>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/image/image.hpp"
#include "harness/run/run_folder.hpp"
#include "tests/core/scene_files.hpp"
#include "tests/support/run_files.hpp"

namespace penumbra {
namespace {

using Texts = std::vector<std::string>;
using nlohmann::json;
using std::chrono::steady_clock;

/// Five frames whose images grow.
const Texts kWork = {"--scene", "half_plane", "contact", "spinner", "--method", "hard", "pcf"};

class Interruptions : public ::testing::Test {
  protected:
    std::filesystem::path path(const std::string& name) const { return folder.path() / name; }
    /// `penumbra compare` at 64x64 with a rough reference, into `run`.
    Texts command(const std::string& run, const Texts& arguments, const Texts& more = {}) const {
        Texts all = {"compare",   "--out", path(run).string(), "--size", "64x64",
                     "--repeats", "2",     "--reference-se",   "0.05"};
        if (std::ranges::find(more, "--cache") == more.end())
            all.insert(all.end(), {"--cache", path("cache").string()});
        all.insert(all.end(), arguments.begin(), arguments.end());
        all.insert(all.end(), more.begin(), more.end());
        return test::penumbraCommand(all);
    }
    test::Finished run(const std::string& name, const Texts& more = {}) const {
        return test::Program(command(name, kWork, more)).wait();
    }
    bool finished(const std::string& name) const {
        return json::parse(test::readText(path(name) / "run.json")).at("finished");
    }
    std::size_t rowCount(const std::string& name) const {
        const std::filesystem::path csv = path(name) / "results.csv";
        return std::filesystem::exists(csv) ? readCsv(csv).size() : 0;
    }
    void awaitRows(const std::string& name, std::size_t count) const {
        const auto giveUp = steady_clock::now() + std::chrono::seconds(60);
        while (rowCount(name) < count && steady_clock::now() < giveUp)
            std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    /// Until it says that it works on a frame.
    static void awaitStep(const test::Program& running) {
        const auto giveUp = steady_clock::now() + std::chrono::seconds(60);
        while (running.errorsSoFar().find("[1/") == std::string::npos &&
               steady_clock::now() < giveUp)
            std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
    void expectSameRun(const std::string& a, const std::string& b) const {
        EXPECT_EQ(test::untimedRows(path(a)), test::untimedRows(path(b)));
        test::expectSameFiles(path(a) / "images", path(b) / "images");
        EXPECT_TRUE(finished(a));
        EXPECT_TRUE(finished(b));
    }
    void expectEveryRowHasItsImage(const std::string& name) const {
        for (const Row& row : readResultsTable(path(name) / "results.csv").rows) {
            if (row.status != "ok") continue;
            const auto image =
                RunFolder(path(name)).readVisibility(row.scene, row.frame, row.setting);
            EXPECT_EQ(image.size(), 64u * 64u) << row.key();
        }
    }

    testing::TempFolder folder;
};

TEST_F(Interruptions, ASignalStopsAfterWhatIsBegunAndResumeDoesTheRest) {
    ASSERT_EQ(run("whole").exitCode, 0);
    for (const int signal : {SIGINT, SIGTERM}) {
        const std::string name = "stopped_" + std::to_string(signal);
        test::Program running(command(name, kWork));
        awaitRows(name, 2);
        running.signal(signal);
        const test::Finished done = running.wait();
        EXPECT_EQ(done.exitCode, 128 + signal) << done.err;
        EXPECT_NE(done.err.find("once more to stop at once"), std::string::npos) << done.err;
        EXPECT_NE(done.err.find("--resume"), std::string::npos) << done.err;
        EXPECT_FALSE(finished(name));
        EXPECT_GE(rowCount(name), 2u);
        EXPECT_LT(rowCount(name), rowCount("whole"));
        expectEveryRowHasItsImage(name);
        for (const char* file : {"summary.md", "report.html", "grid/half_plane.png"})
            EXPECT_TRUE(std::filesystem::exists(path(name) / file)) << file;
        EXPECT_EQ(run(name, {"--resume"}).exitCode, 0);
        expectSameRun(name, "whole");
    }
}

TEST_F(Interruptions, AReferenceIsNotFinishedAndASecondSignalStopsAtOnce) {
    // Some minutes of rays, which nobody shall wait for.
    const auto start = [&](const std::string& name) {
        auto running = std::make_unique<test::Program>(
            test::penumbraCommand({"compare", "--out", path(name).string(), "--size", "512x512",
                                   "--cache", path("cache").string(), "--scene", "foliage",
                                   "--method", "hard", "--reference-se", "0.0001"}));
        awaitStep(*running);
        return running;
    };
    const auto first = start("once");
    first->signal(SIGINT);
    const auto asked = steady_clock::now();
    const test::Finished done = first->wait();
    EXPECT_EQ(done.exitCode, 130) << done.err;
    EXPECT_LT(steady_clock::now() - asked, std::chrono::seconds(60))
        << "the reference takes longer";
    EXPECT_EQ(rowCount("once"), 0u);
    EXPECT_FALSE(finished("once"));
    EXPECT_TRUE(std::filesystem::exists(path("once") / "summary.md"));

    const auto second = start("twice");
    second->signal(SIGTERM);
    second->signal(SIGINT);
    const int code = second->wait().exitCode;
    EXPECT_TRUE(code == 130 || code == 143) << code;
    EXPECT_FALSE(finished("twice"));
}

TEST_F(Interruptions, AFileThatMayNotGrowEndsTheRunAndLosesNothing) {
    ASSERT_EQ(run("whole").exitCode, 0);
    // Between the greatest image of the first scene and that of the last.
    const auto largest = [&](const std::string& scene) {
        std::uintmax_t bytes = 0;
        for (const auto& entry :
             std::filesystem::recursive_directory_iterator(path("whole") / "images" / scene))
            if (entry.is_regular_file()) bytes = std::max(bytes, entry.file_size());
        return bytes;
    };
    const std::uintmax_t fits = largest("half_plane"), fails = largest("spinner");
    ASSERT_LT(fits + 1024, fails);
    const std::uintmax_t blocks = (fits + fails) / 2 / 512;  // POSIX: ulimit -f counts 512 bytes
    std::string line = "ulimit -f " + std::to_string(blocks) + "; exec";
    for (const std::string& word : command("full", kWork)) line += " '" + word + "'";
    const test::Finished full = test::Program({"/bin/sh", "-c", line}).wait();
    EXPECT_EQ(full.exitCode, 3) << full.err;
    EXPECT_NE(full.err.find("cannot be written"), std::string::npos) << full.err;
    EXPECT_GE(rowCount("full"), 2u);
    EXPECT_LT(rowCount("full"), rowCount("whole"));
    EXPECT_FALSE(finished("full"));
    expectEveryRowHasItsImage("full");
    for (const auto& [name, bytes] : test::filesBelow(path("full")))
        EXPECT_EQ(name.find(".tmp"), std::string::npos) << name;
    EXPECT_EQ(run("full", {"--resume"}).exitCode, 0);
    expectSameRun("full", "whole");
}

TEST_F(Interruptions, AFullDiskEndsTheRunAndLosesNothing) {
    const std::string mount = path("disk").string();
    std::filesystem::create_directories(mount);
    const auto inNamespace = [&](const std::string& script) {
        return test::Program(
                   {"/usr/bin/unshare", "-rm", "/bin/sh", "-c",
                    "mount -t tmpfs -o size=256k penumbra '" + mount + "' || exit 77; " + script})
            .wait();
    };
    if (!std::filesystem::exists("/usr/bin/unshare") || inNamespace("exit 0").exitCode != 0)
        GTEST_SKIP() << "needs to mount a tmpfs in a namespace of its own";
    ASSERT_EQ(run("whole").exitCode, 0);
    std::string line;
    for (const std::string& word : command("disk/run", kWork)) line += " '" + word + "'";
    // The mount is seen by this shell's children only, so they copy what there is to see.
    const std::string full = path("full").string(), code = path("code").string();
    const test::Finished done =
        inNamespace(line + "; echo $? > '" + code + "'; cp -r '" + mount + "/run' '" + full +
                    "'; mount -o remount,size=64m '" + mount + "'; " + line +
                    " --resume && cp -r '" + mount + "/run' '" + path("resumed").string() + "'");
    EXPECT_EQ(done.exitCode, 0) << done.err;
    EXPECT_EQ(test::readText(code), "3\n") << done.err;
    EXPECT_NE(done.err.find("No space left on device"), std::string::npos) << done.err;
    EXPECT_GE(rowCount("full"), 2u);
    EXPECT_LT(rowCount("full"), rowCount("whole"));
    expectEveryRowHasItsImage("full");
    expectSameRun("resumed", "whole");
}

TEST_F(Interruptions, TwoProcessesOnOneFolder) {
    ASSERT_EQ(run("whole").exitCode, 0);
    test::Program first(command("run", kWork));
    awaitRows("run", 2);
    first.signal(SIGSTOP);  // else it might be done before the others look
    for (const Texts& more : {Texts{}, Texts{"--resume"}}) {
        const test::Finished second = run("run", more);
        EXPECT_EQ(second.exitCode, 2);
        EXPECT_EQ(test::lines(second.err).size(), 1u) << second.err;
        EXPECT_NE(second.err.find("another process"), std::string::npos) << second.err;
    }
    EXPECT_EQ(test::penumbra({"report", path("run").string()}).exitCode, 2);
    first.signal(SIGCONT);
    EXPECT_EQ(first.wait().exitCode, 0);
    expectSameRun("run", "whole");

    // A lock does not outlive its process.
    test::Program killed(command("killed", kWork));
    awaitRows("killed", 1);
    killed.kill();
    killed.wait();
    EXPECT_EQ(run("killed", {"--resume"}).exitCode, 0);
    expectSameRun("killed", "whole");
}

TEST_F(Interruptions, TwoProcessesOnOneCache) {
    test::Program first(command("first", kWork)), second(command("second", kWork));
    EXPECT_EQ(first.wait().exitCode, 0);
    EXPECT_EQ(second.wait().exitCode, 0);
    expectSameRun("first", "second");
    ASSERT_EQ(run("own", {"--cache", path("own_cache").string()}).exitCode, 0);
    expectSameRun("first", "own");
    test::expectSameFiles(path("cache"), path("own_cache"));
}

TEST_F(Interruptions, ADamagedCacheIsTracedAgainAndSaidSo) {
    ASSERT_EQ(run("whole").exitCode, 0);
    const auto good = test::filesBelow(path("cache"));
    std::size_t number = 0;
    for (const auto& [name, bytes] : good) {
        std::string damaged = bytes;
        if (number++ % 2)
            damaged.resize(damaged.size() / 2);
        else
            damaged[damaged.size() / 2] ^= 1;
        std::ofstream(path("cache") / name, std::ios::binary) << damaged;
    }
    const test::Finished again = run("again");
    EXPECT_EQ(again.exitCode, 0);
    for (const auto& [name, bytes] : good)
        EXPECT_NE(again.err.find(name + ": cut short, altered"), std::string::npos) << again.err;
    expectSameRun("again", "whole");
    EXPECT_TRUE(test::filesBelow(path("cache")) == good);
}

}  // namespace
}  // namespace penumbra
